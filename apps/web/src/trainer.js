// Makes a head avatar from frames of a video, in this page alone: nothing is sent anywhere.
//
// frames -> AvatarTrainer -> trainer-worker.js -> dist/trainer*.wasm, which is `cosplat avatar`;
// faces and mattes by MediaPipe in a frame of this page (FaceFinder).
import { CosplatError, threadsAvailable } from "./module.js";

const MAX_THREADS = 8;

// MediaPipe's face mesh and selfie segmentation (apps/landmarks/page/finder.js), in dist/finder/.
export class FaceFinder {
  static async open({ faces = 2, modules } = {}) {
    const finder = new FaceFinder();
    const base = new URL(modules ?? "../dist/", import.meta.url);
    const frame = document.createElement("iframe");
    frame.style.display = "none";
    frame.src = new URL(`finder/page/finder.html?faces=${faces}`, base).href;
    finder.frame = frame;
    await new Promise((resolve, reject) => {
      finder.listener = ({ source, data }) => {
        if (source !== frame.contentWindow) return;
        if (data.ready) return resolve();
        if (data.error && !data.id) return reject(new CosplatError(`the face finder: ${data.error}`));
        finder.waiting.get(data.id)?.(data);
        finder.waiting.delete(data.id);
      };
      window.addEventListener("message", finder.listener);
      frame.onerror = () => reject(new CosplatError("the face finder cannot be loaded"));
      document.body.append(frame);
    });
    return finder;
  }

  constructor() {
    this.waiting = new Map();
    this.count = 0;
  }
  // image: an ImageBitmap, which is used up. Gives {faces, matte}, as finder.js has them.
  async find(image, milliseconds, mattes = false) {
    const id = ++this.count;
    const found = await new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.frame.contentWindow.postMessage({ id, image, milliseconds, mattes }, "/", [image]);
    });
    if (found.error) throw new CosplatError(`the face finder: ${found.error}`);
    return found;
  }
  close() {
    window.removeEventListener("message", this.listener);
    this.frame.remove();
  }
}

const pixels = (x) => Math.round(1e4 * x) / 1e4;
const textOf = (found) =>
  new TextEncoder().encode(JSON.stringify(found.map(({ faces }) => faces.map((face) => face.map(([x, y]) => [pixels(x), pixels(y)])))));

// What was found, where the worker waits for it (trainer-worker.js).
function hand(found, { memory, textBytes, width, height }) {
  const state = new Int32Array(memory, 0, 2);
  const text = textOf(found);
  const fits = text.length <= textBytes;
  if (fits) new Uint8Array(memory, 8).set(text);
  for (const [k, { matte }] of found.entries())
    if (matte) new Uint8Array(memory, 8 + textBytes + k * width * height, matte.length).set(matte);
  state[1] = text.length;
  Atomics.store(state, 0, fits ? 1 : -1);
  Atomics.notify(state, 0);
}

// Events: "progress" {title, done, total, detail, seconds: left}; "line" {text}; "avatar" {bytes: of an
// avatar.glb as it is now}; "files" {files: [{path, bytes}]} to go on from, once given to `open`.
export class AvatarTrainer extends EventTarget {
  static async open({ threads, modules, files = [] } = {}) {
    const trainer = new AvatarTrainer();
    const base = new URL(modules ?? "../dist/", import.meta.url).href;
    const most = threadsAvailable() ? navigator.hardwareConcurrency : 1;
    trainer.threads = Math.max(1, Math.min(threads ?? most, most, MAX_THREADS));
    trainer.modules = base;
    trainer.worker = new Worker(new URL("./trainer-worker.js", import.meta.url), { type: "module" });
    await new Promise((resolve, reject) => {
      trainer.settle = { resolve, reject };
      trainer.worker.onmessage = ({ data }) => trainer.receive(data);
      trainer.worker.onerror = (event) => reject(new CosplatError(event.message ?? "the trainer's worker cannot be started"));
      trainer.worker.postMessage({ open: { threads: trainer.threads, modules: base } });
    });
    for (const file of files) trainer.addFile(file.path, file.bytes);
    return trainer;
  }

  addFile(path, bytes) {
    this.worker.postMessage({ file: { path, bytes } });
  }
  // bytes: of a JPEG or PNG. number: its place, from 0.
  addFrame(number, bytes) {
    this.addFile(`/frames/${String(number).padStart(5, "0")}.jpg`, bytes);
  }

  // options: of `cosplat avatar`, as a list of words. Resolves once the avatar is done, after its last
  // event "avatar"; rejects with what is wrong, in one line.
  make(options = []) {
    return new Promise((resolve, reject) => {
      this.settle = { resolve, reject };
      // As many threads as the module has been given: others could not start while it works.
      this.worker.postMessage({ run: ["avatar", "/frames", "-o", "/me", "--resume", "--threads", String(this.threads), ...options] });
    });
  }

  tell(event, detail) {
    this.dispatchEvent(new CustomEvent(event, { detail }));
  }
  async receive(data) {
    if (data.opened) this.settle.resolve();
    if (data.line) this.tell("line", { text: data.line });
    if (data.progress) this.tell("progress", data.progress);
    if (data.avatar) this.tell("avatar", { bytes: data.avatar });
    if (data.files) this.tell("files", { files: data.files });
    if (data.ask) await this.find(data.ask);
    if (!data.ended) return;
    this.memory = data.ended.memory;  // bytes, at most
    if (data.ended.code === 0) this.settle.resolve();
    else this.settle.reject(new CosplatError(data.ended.problem.replace(/^cosplat-trainer: /, "") || `the trainer ended with code ${data.ended.code}`));
  }

  async find(ask) {
    const { images, times, mattes, memory } = ask;
    try {
      this.finder ??= await FaceFinder.open({ modules: this.modules });
      const found = [], begun = performance.now();
      for (const [k, image] of images.entries()) {
        const bitmap = await createImageBitmap(new Blob([image], { type: "image/jpeg" }));
        found.push(await this.finder.find(bitmap, times[k], mattes));
        const seconds = ((performance.now() - begun) / 1000 / (k + 1)) * (images.length - k - 1);
        this.tell("progress", { title: mattes ? "landmarks" : "find the head", done: k + 1, total: images.length, detail: "frames", seconds: Math.round(seconds) });
      }
      if (memory) return hand(found, ask);
      const files = found.flatMap(({ matte }, k) => (matte ? [{ name: `${k}.matte`, bytes: matte }] : []));
      this.worker.postMessage({ found: [{ name: "faces.json", bytes: textOf(found) }, ...files] });
    } catch (error) {
      this.close();
      this.settle.reject(error);
    }
  }

  // At once; `make` rejects.
  stop() {
    this.close();
    this.settle.reject(new CosplatError("stopped"));
  }
  // Whatever it is doing.
  close() {
    this.worker.terminate();
    this.finder?.close();
  }
}
