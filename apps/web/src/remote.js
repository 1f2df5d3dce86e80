// Avatars and scenes in a worker, so that the page never waits for a picture: the same verbs, as
// promises.
import { CosplatError } from "./module.js";

// A worker of another origin cannot be started, but one of the page's can import it.
function startWorker(options) {
  if (options.offline) return new Worker(options.offline.worker);
  const url = new URL("./worker.js", import.meta.url);
  if (url.origin === globalThis.location.origin) return new Worker(url, { type: "module" });
  const source = new Blob([`import ${JSON.stringify(String(url))};`], { type: "text/javascript" });
  return new Worker(URL.createObjectURL(source), { type: "module" });
}

class Remote extends EventTarget {
  constructor(options = {}) {
    super();
    this.calls = new Map();
    this.count = 0;
    this.worker = startWorker(options);
    this.worker.onmessage = ({ data }) => this.receive(data);
    this.worker.onerror = (event) => this.fail(event.message ?? "the worker cannot be started");
  }

  receive({ id, value, error, event, detail }) {
    if (event) return this.dispatchEvent(new CustomEvent(event, { detail }));
    const { resolve, reject } = this.calls.get(id);
    this.calls.delete(id);
    if (error) reject(new CosplatError(error.message, error.status));
    else resolve(value);
  }
  fail(message) {
    for (const { reject } of this.calls.values()) reject(new CosplatError(message));
    this.calls.clear();
    this.dispatchEvent(new CustomEvent("error", { detail: { message, status: "" } }));
  }

  call(verb, args = [], transfer = []) {
    const id = ++this.count;
    return new Promise((resolve, reject) => {
      this.calls.set(id, { resolve, reject });
      this.worker.postMessage({ id, verb, args }, transfer);
    });
  }
  // Without an answer; what goes wrong is an event "error".
  post(verb, ...args) {
    this.worker.postMessage({ verb, args });
  }
  // Gives the splats of an event "splats" back once they are shown, milliseconds after its arrival.
  shown(splats, milliseconds) {
    const arrays = [splats.centers, splats.colors, splats.scales, splats.rotations];
    this.worker.postMessage({ verb: "shown", args: [splats, milliseconds] }, arrays.map((array) => array.buffer));
  }

  open(kind, source, flame, options, canvas) {
    // A worker has a place of its own, from which relative addresses would be taken.
    const absolute = (from) => (typeof from === "string" ? new URL(from, document.baseURI).href : from);
    const args = { kind, source: absolute(source), flame: absolute(flame), options, canvas };
    const opened = this.call("open", [args], canvas ? [canvas] : []);
    opened.catch(() => this.close());
    return opened;
  }
  // {width, height: px of the pictures; orbit: {azimuth, elevation, zoom}; background: [r, g, b] or
  // null for a transparent one; renderer: "cpu", or "gpu" for events "splats" in place of pictures, as
  // of Avatar.splats with blurVariance}. What is not given stays.
  setView(view) {
    this.post("setView", view);
  }
  info() {
    return this.call("info");
  }
  render(width, height, options) {
    return this.call("render", [width, height, options]);
  }
  // With its threads and its memory, whatever it is doing.
  close() {
    this.worker.terminate();
  }
}

// canvas: an OffscreenCanvas into which it is drawn whenever it changes, or none.
export class RemoteAvatar extends Remote {
  static async open(avatar, flame, { canvas, ...options } = {}) {
    const remote = new RemoteAvatar(options);
    remote.properties = await remote.open("avatar", avatar, flame, options, canvas);
    return remote;
  }
  setParameters(parameters) {
    this.post("setParameters", parameters);
  }
  resetParameters() {
    this.post("resetParameters");
  }
  parameters() {
    return this.call("parameters");
  }
  advance(now) {
    return this.call("advance", [now]);
  }
  setDrive(drive) {
    const relative = typeof drive === "string" && drive !== "frames";
    return this.call("setDrive", [relative ? new URL(drive, document.baseURI).href : drive]);
  }
  send(frame) {
    this.post("send", frame);
  }
  sendPoints(seen) {
    this.post("sendPoints", seen);
  }
  calibrate() {
    this.post("calibrate");
  }
  setPolicy(policy) {
    return this.call("setPolicy", [policy]);
  }
  health() {
    return this.call("health");
  }
}

export class RemoteScene extends Remote {
  static async open(source, { canvas, ...options } = {}) {
    const remote = new RemoteScene(options);
    remote.properties = await remote.open("scene", source, null, options, canvas);
    return remote;
  }
  orbit(right, up) {
    this.post("orbit", right, up);
  }
  pan(right, down) {
    this.post("pan", right, down);
  }
  zoom(steps) {
    this.post("zoom", steps);
  }
  resetCamera() {
    this.post("resetCamera");
  }
}
