// From a film of a head to its avatar, in this page alone (docs/web.md).
import "../../src/index.js";
import { AvatarTrainer, FaceFinder } from "../../src/trainer.js";
import { film, wishes } from "./coach.js";
import { forFrames, openVideo } from "./frames.js";
import { drive } from "./live.js";
import { faceControls, lookControls, make, show } from "../panel.js";
import { Store } from "./store.js";

// What a quality means: at most so many frames, options of `cosplat avatar`, steps at which the avatar
// is shown, minutes between checkpoints.
const QUALITIES = {
  draft: { frames: 120, options: ["--quality", "draft", "-r", "2", "--avatar-rounds", "0"], shown: [500, 1000, 1500], checkpoints: 0.1 },
  standard: { frames: 240, options: ["--quality", "standard", "-r", "2", "--avatar-rounds", "1"], shown: [1000, 2000, 4000], checkpoints: 0.5 },
  best: { frames: 300, options: ["--quality", "best", "--avatar-rounds", "2"], shown: [2000, 5000, 10000], checkpoints: 1 },
};
const STEPS = { "find the head": "Looking for the head", decode: "Cutting frames", landmarks: "Finding the face", mattes: "Cutting the person out", track: "Fitting a head", train: "Training" };

const byId = (id) => document.getElementById(id);
const query = new URLSearchParams(location.search);
// One tab at a time keeps its film here: another would go on with this one's.
const owns = new Promise((resolve) => {
  if (!navigator.locks) return resolve(true);
  navigator.locks.request("cosplat-studio", { ifAvailable: true }, (lock) => {
    resolve(lock !== null);
    return new Promise(() => {});  // until the tab is closed
  });
});
const store = (await owns) ? await Store.open().catch(() => null) : null;
// A FLAME model that was given, {path, bytes}: an avatar on it does not play without.
let flame = null;
let element = null, trainer = null, avatar = null, stopped = null;

const say = (text, problem = false) => {
  byId("status").textContent = text;
  byId("status").classList.toggle("problem", problem);
};
const step = (text, share = null) => {
  byId("step").textContent = text;
  if (share === null) byId("bar").removeAttribute("value");
  else byId("bar").value = share;
};
const nameOf = ({ path }) => path.slice(path.lastIndexOf("/") + 1);
const clock = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
const busy = (is) => {
  for (const id of ["camera", "file", "flame", "quality", "open"]) byId(id).disabled = is;
  byId("stop").disabled = !is;
};

// Frames and what a run goes on from. A full storage costs that only.
let full = false;
async function keep(path, bytes) {
  if (full || !store) return;
  try {
    await store.put(path, bytes);
  } catch (error) {
    full = true;
    byId("kept").textContent = `This browser's storage is full (${error.name}): a closed tab will begin again`;
  }
}

// One of: "video", "frame" (the film's last, once the camera is off), "shown" (the avatar).
function stage(which) {
  for (const id of ["video", "frame", "shown"]) byId(id).hidden = id !== which;
}

// It stands still while another is being made, which would have to share the processor.
let face = null;
function showAvatar(bytes, moves) {
  avatar = bytes;
  const file = new File([bytes], "avatar.glb"), model = flame && new File([flame.bytes], nameOf(flame));
  if (!element) {
    element = show({ title: "you", avatar: file, flame: model }, byId("shown"), byId("status"));
    face = faceControls(element);
    byId("controls").replaceChildren(face.controls, lookControls(element));
    if (moves) element.addEventListener("load", face.start, { once: true });
  } else {
    element.load(file, model);
  }
  byId("play").hidden = false;
  stage("shown");
}

async function train(quality, files = []) {
  const { options, shown, checkpoints } = QUALITIES[quality];
  trainer.addEventListener("progress", ({ detail: { title, done, total, seconds } }) =>
    step(`${STEPS[title] ?? title}: ${done} of ${total}, ${clock(seconds)} left`, done / total));
  trainer.addEventListener("line", ({ detail }) => byId("log").append(`${detail.text}\n`));
  trainer.addEventListener("avatar", ({ detail }) => {
    keep("/avatar.glb", detail.bytes);
    showAvatar(detail.bytes, false);
  });
  trainer.addEventListener("files", async ({ detail }) => {
    for (const { path, bytes } of detail.files) await keep(path, bytes);
  });
  for (const { path, bytes } of files) trainer.addFile(path, bytes);
  const begun = performance.now();
  step("Starting");
  const model = flame ? ["--flame", flame.path] : [];
  await trainer.make([...options, ...model, "--checkpoint-every", String(checkpoints), "--save_iterations", ...shown.map(String)]);
  step(`Done in ${clock((performance.now() - begun) / 1000)}`, 1);
  await store?.clear().catch(() => {});
  await keep("/avatar.glb", avatar);
  if (flame) await keep(flame.path, flame.bytes);
  face.start();
}

// Calls work(), with its problem as one line; nothing is lost by it.
async function guarded(work) {
  busy(true);
  face?.stop();
  stopped = new AbortController();
  full = false;
  byId("kept").textContent = "";
  byId("log").textContent = "";
  try {
    trainer = await AvatarTrainer.open({ threads: Number(query.get("threads")) || undefined });
    await work();
  } catch (error) {
    step("", 0);
    if (avatar) stage("shown");
    say(stopped.signal.aborted ? "Stopped." : error.message ?? String(error), !stopped.signal.aborted);
    await store?.remove("/quality").catch(() => {});  // it is not begun again by itself
  }
  trainer?.close();
  document.documentElement.dataset.megabytes = Math.round((trainer?.memory ?? 0) / 1e6);
  busy(false);
}

async function chosenFlame() {
  const [file] = byId("flame").files;
  return file ? { path: `/flame/${file.name}`, bytes: new Uint8Array(await file.arrayBuffer()) } : null;
}

async function fromFrames(quality, frames) {
  await store?.clear().catch(() => {});
  if (avatar) await keep("/avatar.glb", avatar);
  await keep("/quality", quality);
  flame = await chosenFlame();
  if (flame) {
    await keep(flame.path, flame.bytes);
    trainer.addFile(flame.path, flame.bytes);
  }
  await frames(async (number, bytes) => {
    const path = `/frames/${String(number).padStart(5, "0")}.jpg`;
    await keep(path, bytes);
    trainer.addFile(path, bytes);
  });
  await train(quality);
}

function fromFile(file) {
  const quality = byId("quality").value;
  guarded(() => fromFrames(quality, async (use) => {
    const video = byId("video");
    stage("video");
    video.classList.add("plain");
    const { width, height, seconds } = await openVideo(video, file);
    say(`${file.name}: ${width}x${height}, ${clock(seconds)}`);
    await forFrames(video, QUALITIES[quality].frames, use, (done, total) => step(`Reading frames: ${done} of ${total}`, done / total));
  }));
}

function fromCamera() {
  const quality = byId("quality").value;
  guarded(() => fromFrames(quality, async (use) => {
    const video = byId("video");
    let stream = null, finder = null, lastFrame = null;
    try {
      stream = await navigator.mediaDevices.getUserMedia({ video: { width: 1280, height: 720, facingMode: "user" } });
      stage("video");
      video.classList.remove("plain");
      video.srcObject = stream;
      await video.play();
      say("Loading what finds your face");
      finder = await FaceFinder.open({ faces: 1 });
      const count = await film({
        video, finder, say,
        use: (number, bytes) => use(number, (lastFrame = bytes)),
        ring: byId("ring"), list: byId("coach"), signal: stopped.signal, most: QUALITIES[quality].frames,
      });
      if (stopped.signal.aborted) throw new Error("stopped");
      say(`${count} frames`);
      byId("frame").src = URL.createObjectURL(new Blob([lastFrame]));
      stage("frame");
    } catch (error) {
      throw new Error(`camera: ${error.message ?? error}`);
    } finally {
      for (const track of stream?.getTracks() ?? []) track.stop();
      finder?.close();
      byId("ring").getContext("2d").clearRect(0, 0, 512, 512);
    }
  }));
}

function save(blob, name) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

async function savePage() {
  const page = await (await fetch("../dist/offline.html")).text();
  let text = "";
  for (let i = 0; i < avatar.length; i += 0x8000) text += String.fromCharCode(...avatar.subarray(i, i + 0x8000));
  const model = JSON.stringify({ title: "me", avatar: { name: "avatar.glb", base64: btoa(text) } });
  save(new Blob([page.replace("@MODEL@", () => model)], { type: "text/html" }), "me.html");
}

let recorder = null;
function record() {
  const button = byId("record");
  if (recorder) return recorder.stop();
  const parts = [], canvas = element.shadowRoot?.querySelector("canvas") ?? element.querySelector("canvas");
  recorder = new MediaRecorder(canvas.captureStream(30));
  recorder.ondataavailable = ({ data }) => parts.push(data);
  recorder.onstop = () => {
    save(new Blob(parts, { type: recorder.mimeType }), /mp4/.test(recorder.mimeType) ? "me.mp4" : "me.webm");
    recorder = null;
    button.textContent = "Record a video";
  };
  recorder.start();
  button.textContent = "End the recording";
}

// Without a network from then on; and threads, where the server does not allow them.
async function serveSelf() {
  if (!navigator.serviceWorker) return;
  await navigator.serviceWorker.register("../service-worker.js");
  await navigator.serviceWorker.ready;
  document.documentElement.dataset.offline = "true";
  if (globalThis.crossOriginIsolated || sessionStorage.getItem("isolating")) return;
  sessionStorage.setItem("isolating", "true");
  location.reload();
}
serveSelf().catch((error) => console.warn(`cosplat: ${error.message}`));

byId("coach").append(...wishes.map((text) => make("li", { textContent: text })));
byId("camera").onclick = fromCamera;
byId("file").onchange = () => {
  const [file] = byId("file").files;
  byId("file").value = "";  // or the same one could not be chosen again
  if (file) fromFile(file);
};
byId("drop").ondragover = (event) => event.preventDefault();
byId("drop").ondrop = (event) => {
  event.preventDefault();
  const [file] = event.dataTransfer.files;
  if (file && !byId("file").disabled) fromFile(file);
};
byId("stop").onclick = () => {
  stopped.abort();
  trainer?.stop();
};
byId("open").onchange = async () => {
  flame = await chosenFlame();
  showAvatar(new Uint8Array(await byId("open").files[0].arrayBuffer()), true);
};
byId("glb").onclick = () => save(new Blob([avatar], { type: "model/gltf-binary" }), "avatar.glb");
byId("html").onclick = () => savePage().catch((error) => say(error.message, true));
byId("record").onclick = record;
byId("live").onclick = () => drive(element, byId("video"), say).catch((error) => say(`camera: ${error.message ?? error}`, true));

// A tab that was closed in the middle.
const files = (await store?.all("/")) ?? [];
const quality = files.find(({ path }) => path === "/quality")?.bytes;
flame = files.find(({ path }) => path.startsWith("/flame/")) ?? null;
const earlier = files.find(({ path }) => path === "/avatar.glb")?.bytes;
if (earlier) showAvatar(earlier, !quality);
if (quality && files.some(({ path }) => path.startsWith("/frames/")) ) {
  say("Going on with the film of before");
  byId("quality").value = quality;
  guarded(() => train(quality, files.filter(({ path }) => /^\/(flame|frames|me)\//.test(path))));
}
byId("drop").dataset.ready = "true";
