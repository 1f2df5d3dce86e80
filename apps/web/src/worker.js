// The worker of a RemoteAvatar or RemoteScene: opens it, draws it into a canvas, answers calls.
//
// page -> {id, verb, args} -> {id, value} or {id, error}; events -> {event, detail}.
import { openAvatar } from "./avatar.js";
import { openScene } from "./scene.js";

const nextFrame = globalThis.requestAnimationFrame ?? ((draw) => setTimeout(() => draw(performance.now()), 1000 / 60));

let subject = null;
let context = null;
let view = { width: 0, height: 0, background: null, orbit: {} };
let image = null;  // ImageData of the view's size
let changed = false;  // since the last picture
let live = false;  // the face follows the clock
let failed = "";  // the last problem, which is told once
let stats = { since: 0, frames: 0, milliseconds: 0 };

const tell = (event, detail) => postMessage({ event, detail });
const problemOf = (error) => ({ message: String(error.message ?? error), status: error.status ?? "" });

// Once a second the page hears how fast it goes.
function count(milliseconds, now) {
  stats.frames += 1;
  stats.milliseconds += milliseconds;
  const elapsed = now - stats.since;
  if (elapsed < 1000) return;
  tell("stats", {
    framesPerSecond: (1e3 * stats.frames) / elapsed,
    milliseconds: stats.milliseconds / stats.frames,
    threads: subject.threads,
    health: subject.health?.(),
  });
  stats = { since: now, frames: 0, milliseconds: 0 };
}

function draw() {
  const { width, height, background } = view;
  if (image?.width !== width || image?.height !== height) {
    image = new ImageData(width, height);
    context.canvas.width = width;
    context.canvas.height = height;
  }
  if (subject.orbitCamera) subject.setCamera(subject.orbitCamera(width, height, view.orbit));
  const look = background ? { alpha: "opaque", background } : {};
  subject.render(width, height, look, image.data);
  context.putImageData(image, 0, 0);
}

function frame() {
  if (!subject) return;
  nextFrame(frame);
  if (!context || view.width < 1 || !(live || changed)) return;
  const begin = performance.now();
  changed = false;
  try {
    if (live) subject.advance(begin);
    draw();
    failed = "";
    const end = performance.now();
    count(end - begin, end);
  } catch (error) {
    const problem = problemOf(error);
    if (problem.message !== failed) tell("error", problem);
    failed = problem.message;
  }
}

const own = {
  async open({ kind, source, flame, options, canvas }) {
    const { offline, ...others } = options;
    // The offline page's worker brings the module's glue (pages/offline-worker.js).
    const load = offline && (async () => ({ glue: globalThis.cosplatGlue, wasm: offline.wasm }));
    subject = await (kind === "avatar"
      ? openAvatar(source, flame, { ...others, load })
      : openScene(source, { ...others, load }));
    context = canvas?.getContext("2d") ?? null;
    stats.since = performance.now();
    changed = true;
    frame();
    return { ...subject.info(), threads: subject.threads };
  },
  setView(values) {
    view = { ...view, ...values };
  },
  async setDrive(drive) {
    await subject.setDrive(drive);
    live = drive !== null;
    if (!live) subject.resetParameters();
  },
};

onmessage = async ({ data: { id, verb, args } }) => {
  try {
    if (!subject && verb !== "open") throw new Error(`${verb}: nothing is open`);
    const value = await (own[verb] ? own[verb](...args) : subject[verb](...args));
    changed = true;
    if (id) postMessage({ id, value });
  } catch (error) {
    if (id) postMessage({ id, error: problemOf(error) });
    else tell("error", problemOf(error));
  }
};
