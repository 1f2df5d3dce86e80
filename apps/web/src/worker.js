// The worker of a RemoteAvatar or RemoteScene: opens it, draws it into a canvas, answers calls.
//
// page -> {id, verb, args} -> {id, value} or {id, error}; events -> {event, detail}. With
// view.renderer "gpu" it draws nothing, but sends an event "splats" whenever the picture changes, and
// the page answers by the verb "shown".
import { openAvatar } from "./avatar.js";
import { openScene } from "./scene.js";

const nextFrame = globalThis.requestAnimationFrame ?? ((draw) => setTimeout(() => draw(performance.now()), 1000 / 60));

let subject = null;
let context = null;
let view = { width: 0, height: 0, background: null, orbit: {}, renderer: "cpu", blurVariance: 0 };
let image = null;  // ImageData of the view's size
let changed = false;  // since the last picture
let live = false;  // the face follows the clock
let sent = null;  // milliseconds that the splats took which the page has not shown yet
let shown = undefined;  // splats that it has, to be reused
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
    renderer: view.renderer,
    health: subject.health?.(),
  });
  stats = { since: now, frames: 0, milliseconds: 0 };
}

const arraysOf = ({ centers, colors, scales, rotations }) => [centers, colors, scales, rotations].map((array) => array.buffer);

// turn: radians of the camera to the left.
function look(turn = 0) {
  if (!subject.orbitCamera) return;
  const orbit = { ...view.orbit, azimuth: (view.orbit.azimuth ?? 0) + turn };
  subject.setCamera(subject.orbitCamera(view.width, view.height, orbit));
}
function draw() {
  const { width, height, background } = view;
  if (image?.width !== width || image?.height !== height) {
    image = new ImageData(width, height);
    context.canvas.width = width;
    context.canvas.height = height;
  }
  subject.render(width, height, background ? { alpha: "opaque", background } : {}, image.data);
  context.putImageData(image, 0, 0);
}
const splatsOf = (blurVariance, out) =>
  subject.orbitCamera ? subject.splats(blurVariance, out) : subject.splats(view.width, view.height, blurVariance, out);

// Before a picture is measured that was never drawn: of the same cost, but not the same.
const STEP = 1e-4;  // radians

function frame() {
  if (!subject) return;
  nextFrame(frame);
  if (!context || view.width < 1 || !(live || changed) || sent !== null) return;
  const begin = performance.now();
  changed = false;
  try {
    if (live) subject.advance(begin);
    look();
    if (view.renderer === "gpu") {
      const splats = splatsOf(view.blurVariance, shown);
      shown = undefined;
      sent = performance.now() - begin;
      postMessage({ event: "splats", detail: splats }, arraysOf(splats));
    } else {
      draw();
      const end = performance.now();
      count(end - begin, end);
    }
    failed = "";
  } catch (error) {
    const problem = problemOf(error);
    if (problem.message !== failed) tell("error", problem);
    failed = problem.message;
  }
}

const UNCHANGED = Symbol("the picture is as before");
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
    if (values.renderer) sent = null;  // what was sent to the other one is not answered
  },
  // What an event "splats" brought is on the canvas; milliseconds of the page's for it.
  shown(splats, milliseconds) {
    if (sent !== null) count(sent + milliseconds, performance.now());
    sent = null;
    shown = splats;
    return UNCHANGED;
  },
  // Milliseconds of picture i of a measurement on the CPU; it is not shown.
  timePicture(i) {
    const begin = performance.now();
    look(STEP * (i + 1));
    subject.render(view.width, view.height, {}, image?.data);
    return performance.now() - begin;
  },
  // The same for the GPU: milliseconds, and the splats.
  timeSplats(i, blurVariance) {
    const begin = performance.now();
    look(STEP * (i + 1));
    const splats = splatsOf(blurVariance);
    return { milliseconds: performance.now() - begin, splats };
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
    changed ||= value !== UNCHANGED;
    if (id) postMessage({ id, value });
  } catch (error) {
    if (id) postMessage({ id, error: problemOf(error) });
    else tell("error", problemOf(error));
  }
};
