// What test/run.mjs asks of a page, by the query: one of these, with its result posted to /result.
import { fasterRenderer, gpuRenderer, outgrown } from "/web/src/gpu.js";
import { openAvatar, openScene, RemoteAvatar } from "/web/src/index.js";
import { usePlayCanvas } from "/web/src/playcanvas.js";

const query = new URLSearchParams(location.search);
const avatar = "/data/avatar.glb";
const flame = "/data/flame.npz";
const threads = query.has("threads") ? Number(query.get("threads")) : undefined;

const post = (url, body) => fetch(url, { method: "POST", body });
const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];
const bytesOf = async (url) => new Uint8Array(await (await fetch(url)).arrayBuffer());

function set(player, { parameters, orbit }, side) {
  player.setParameters(parameters);
  player.setCamera(player.orbitCamera(side, side, orbit));
}

// The number of bytes that differ, the largest difference, and the smallest PSNR of a picture.
async function pictures() {
  const side = Number(query.get("size"));
  const frames = await (await fetch("/data/frames.json")).json();
  const expected = await bytesOf("/data/pictures.rgba");
  const player = await openAvatar(avatar, flame, { threads });
  const result = { threads: player.threads, psnr: Infinity, different: 0, largest: 0, bytes: expected.length };
  frames.forEach((frame, i) => {
    set(player, frame, side);
    const got = player.render(side, side);
    let squares = 0;
    for (let k = 0; k < got.length; ++k) {
      const d = Math.abs(got[k] - expected[i * got.length + k]);
      if (d === 0) continue;
      squares += d * d;
      result.different += 1;
      result.largest = Math.max(result.largest, d);
    }
    result.psnr = Math.min(result.psnr, 10 * Math.log10((255 * 255 * got.length) / Math.max(squares, 1e-9)));
  });
  player.close();
  return result;
}

// Bytes of the module's and of the page's memory after a tenth of the frames, and at the end.
async function growth() {
  const count = Number(query.get("frames"));
  const frames = await (await fetch("/data/frames.json")).json();
  const player = await openAvatar(avatar, flame, { threads });
  const out = new Uint8ClampedArray(4 * 128 * 128);
  const held = () => {
    globalThis.gc();
    return { module: player.memory.module.HEAPU8.buffer.byteLength, page: performance.memory.usedJSHeapSize };
  };
  await player.setDrive("frames");
  let early = null;
  for (let i = 0; i < count; ++i) {
    const { parameters, orbit } = frames[i % frames.length];
    const expression = parameters.expression.map((x) => x * Math.cos(i));
    if (i % 50 !== 7) player.send({ seq: i, time: i / 25, expression, jaw: parameters.jaw });
    else player.send(`{"seq": ${i}, "jaw": [1, 2]}`);
    player.advance(1e3 + 40 * i);
    player.setCamera(player.orbitCamera(128, 128, orbit));
    player.render(128, 128, {}, out);
    if (i === Math.floor(count / 10)) early = held();
  }
  return { early, late: held(), health: player.health() };
}

// The first event of that name, or of "load" or "error" if that is what comes.
const event = (element, name) =>
  new Promise((resolve) => element.addEventListener(name, resolve, { once: true }));
function element(kind, attributes) {
  const made = document.createElement(kind);
  made.style.width = "256px";
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  document.body.append(made);
  return made;
}

// The one line of what goes wrong, by what it is.
async function errors() {
  const result = {};
  const failing = {
    missing_avatar: ["cosplat-avatar", { src: "/data/none.glb", flame }],
    missing_flame: ["cosplat-avatar", { src: avatar, flame: "/data/none.npz" }],
    no_flame: ["cosplat-avatar", { src: "/data/bare.glb" }],
    wrong_flame: ["cosplat-avatar", { src: avatar, flame: "/data/frames.json" }],
    cut_avatar: ["cosplat-avatar", { src: "/data/cut.glb", flame }],
    cut_flame: ["cosplat-avatar", { src: avatar, flame: "/data/cut.npz" }],
    wrong_splats: ["cosplat-splats", { src: "/data/frames.json" }],
    missing_splats: ["cosplat-splats", { src: "/data/none.ply" }],
  };
  for (const [name, [kind, attributes]] of Object.entries(failing)) {
    const made = element(kind, attributes);
    result[name] = (await event(made, "error")).message;
    made.remove();
  }
  const lost = element("cosplat-avatar", { src: avatar, flame, drive: "ws://127.0.0.1:9/face" });
  const first = await Promise.race([event(lost, "load"), event(lost, "error")]);
  result.loads_before = first.type;
  result.lost_socket = (await event(lost, "error")).message;
  lost.setAttribute("drive", "/data/none.npz");
  result.missing_drive = (await event(lost, "error")).message;
  lost.setAttribute("drive", "frames");
  const pink = event(lost, "error");
  lost.setAttribute("background", "pink");
  result.background = (await pink).message;
  lost.setParameters({ jaw: [Number.NaN, 0, 0] });
  result.not_finite = (await event(lost, "error")).message;
  return result;
}

// The elements draw what the object draws: pixels of the canvas beside render()'s.
async function elements() {
  const shown = element("cosplat-avatar", { src: avatar, flame, drive: "message", camera: "20 10 1.5" });
  await event(shown, "load");
  window.postMessage({ cosplat: { seq: 1, jaw: [0.2, 0, 0] } });
  let health = null;
  for (let i = 0; i < 200 && !(health?.accepted > 0); ++i) {
    await new Promise((resolve) => setTimeout(resolve, 25));
    health = await shown.health();
  }
  const socket = element("cosplat-avatar", { src: avatar, flame, drive: `ws://${location.host}/face` });
  const heard = [];
  socket.addEventListener("drive", ({ detail }) => heard.push(detail));
  socket.addEventListener("error", ({ message }) => heard.push(message.replace(/.*face: /, "")));
  for (let i = 0; i < 400 && heard.length < 4; ++i) await new Promise((resolve) => setTimeout(resolve, 25));
  const driven = await socket.health();
  socket.remove();
  const splats = element("cosplat-splats", { src: "/data/scene.ply" });
  const scene = await event(splats, "load");
  const opened = await openScene("/data/scene.ply");
  const picture = opened.render(256, 256);
  let visible = 0;
  for (let k = 3; k < picture.length; k += 4) visible += picture[k] > 128 ? 1 : 0;
  const pixelsOf = async (from) => {
    const bitmap = await createImageBitmap(from.shadowRoot.querySelector("canvas"));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let covered = 0;
    for (let k = 3; k < data.length; k += 4) covered += data[k] > 128 ? 1 : 0;
    return covered / (data.length / 4);
  };
  await new Promise((resolve) => setTimeout(resolve, 300));
  return {
    heard,
    driven: driven.driveFrames + driven.driveReplaced,
    accepted: health.accepted,
    face: health.face,
    gaussians: scene.detail.gaussianCount,
    visible: visible / (picture.length / 4),
    avatarOnCanvas: await pixelsOf(shown),
    splatsOnCanvas: await pixelsOf(splats),
  };
}

// PlayCanvas' pictures of driven frames beside ours, over black; of every seventh also once it is sorted
// by its own depths. `device`: of createGraphicsDevice.
const playcanvas = () => import("/web/node_modules/playcanvas/build/playcanvas.min.mjs");
async function gpu() {
  const side = Number(query.get("size"));
  const device = query.get("device");
  usePlayCanvas(await playcanvas(), { deviceTypes: [device] });
  const frames = await (await fetch("/data/frames.json")).json();
  const player = await openAvatar(avatar, flame, { threads });
  const canvas = document.createElement("canvas");
  document.body.append(canvas);
  const renderer = await gpuRenderer()(canvas);
  const reader = new OffscreenCanvas(side, side).getContext("2d", { willReadFrequently: true });
  const picture = async (splats) => {
    await renderer.draw(splats);
    reader.fillStyle = "#000";
    reader.fillRect(0, 0, side, side);
    reader.drawImage(canvas, 0, 0);
    return reader.getImageData(0, 0, side, side).data;
  };
  const settled = async (splats) => {
    let last = await picture(splats);
    for (let still = 0, i = 0; still < 3 && i < 100; ++i) {
      await new Promise((resolve) => setTimeout(resolve, 50));
      const next = await picture(splats);
      still = next.every((value, k) => value === last[k]) ? still + 1 : 0;
      last = next;
    }
    return last;
  };
  const compare = (ours, theirs) => {
    let squares = 0;
    let covered = 0;
    for (let k = 0; k < ours.length; ++k) {
      if (k % 4 === 3) continue;
      squares += (ours[k] - theirs[k]) ** 2;
      covered += theirs[k] > 8;
    }
    const count = 0.75 * ours.length;
    return { psnr: 10 * Math.log10((255 * 255 * count) / squares), covered: covered / count };
  };
  const depth = ({ camFromWorld: m, centers }, i) => m[8] * centers[4 * i] + m[9] * centers[4 * i + 1] + m[10] * centers[4 * i + 2];
  const result = { device: renderer.device.deviceType, still: [], moving: [], unsorted: 0 };
  for (const [i, frame] of frames.entries()) {
    set(player, frame, side);
    const ours = player.render(side, side, { alpha: "opaque" });
    const splats = player.splats(renderer.blurVariance);
    for (let i = 1; i < splats.count; ++i) result.unsorted += depth(splats, i) < depth(splats, i - 1) - 1e-6;
    result.moving.push(compare(ours, await picture(splats)));
    if (i % 7 === 0) result.still.push(compare(ours, await settled(splats)));
  }
  renderer.close();
  return result;
}

// Pictures of these files beside that of another, and what is said of the damaged ones.
async function files() {
  const side = 256;
  const expected = await openScene(`/data/${query.get("like")}`);
  const picture = expected.render(side, side, { alpha: "opaque" });
  const result = { count: expected.info().gaussianCount, files: {} };
  for (const name of query.get("names").split(" ")) {
    const bytes = await bytesOf(`/data/${name}`);
    const begin = performance.now();
    const scene = await openScene(new File([bytes], name));
    const milliseconds = performance.now() - begin;
    const got = scene.render(side, side, { alpha: "opaque" });
    const squares = got.reduce((sum, value, k) => sum + (value - picture[k]) ** 2, 0);
    const problem = await openScene(`/data/bad_${name}`).then(() => "none", ({ message }) => message);
    const psnr = 10 * Math.log10((255 * 255 * 0.75 * got.length) / Math.max(squares, 1e-9));
    result.files[name] = { psnr, count: scene.info().gaussianCount, milliseconds, problem };
    scene.close();
  }
  return result;
}

// The element's way to draw: forced, refused, measured, changed while it draws.
async function renderers() {
  const chosen = async (shown) => (await event(shown, "renderer")).detail;
  const result = {};
  const refused = element("cosplat-avatar", { src: avatar, flame, renderer: "gpu" });
  result.without = (await event(refused, "error")).message;
  refused.setAttribute("renderer", "fast");
  result.unknown = (await event(refused, "error")).message;
  refused.remove();

  usePlayCanvas(await playcanvas(), { deviceTypes: ["webgl2"] });
  // The part of the GPU's canvas that is covered, after its next picture.
  const covered = (shown) =>
    new Promise((resolve) =>
      shown.gpu.app.once("postrender", () => {
        const { width, height } = shown.gpu.canvas;
        const reader = new OffscreenCanvas(width, height).getContext("2d");
        reader.drawImage(shown.gpu.canvas, 0, 0);
        const { data } = reader.getImageData(0, 0, width, height);
        let count = 0;
        for (let k = 3; k < data.length; k += 4) count += data[k] > 128;
        resolve(count / (data.length / 4));
      }),
    );
  const shown = element("cosplat-avatar", { src: avatar, flame, renderer: "gpu", camera: "20 10 1.5" });
  result.forced = await chosen(shown);
  const moves = setInterval(() => shown.setParameters({ jaw: [0.1 + 0.1 * Math.sin(performance.now()), 0, 0] }), 20);
  const stats = event(shown, "stats");
  result.avatar = await covered(shown);
  result.stats = (await stats).detail;
  clearInterval(moves);
  shown.setAttribute("renderer", "cpu");
  result.back = { ...(await chosen(shown)), canvases: shown.shadowRoot.querySelectorAll("canvas").length };
  shown.removeAttribute("renderer");
  result.measured = await chosen(shown);
  result.faster = fasterRenderer("cpu", result.measured);
  result.drawing = shown.drawing;
  shown.remove();

  const splats = element("cosplat-splats", { src: "/data/scene.ply", renderer: "gpu" });
  result.scene = await chosen(splats);
  splats.remote.orbit(0.1, 0);
  result.splats = await covered(splats);
  // Where the engine's context is lost the CPU draws on.
  const lost = event(splats, "error");
  splats.gpu.device.gl.getExtension("WEBGL_lose_context").loseContext();
  result.lost = (await lost).message;
  result.after = splats.drawing;

  result.rule = [
    fasterRenderer("cpu", { cpu: 10, gpu: 9 }), fasterRenderer("cpu", { cpu: 10, gpu: 7 }),
    fasterRenderer("gpu", { cpu: 9, gpu: 10 }), fasterRenderer("gpu", { cpu: 7, gpu: 10 }),
    outgrown(100, 190), outgrown(100, 210), outgrown(100, 45),
  ];
  return result;
}

// Milliseconds per picture of these sizes, and from the avatar's bytes to the first picture.
async function speed() {
  const frames = await (await fetch("/data/frames.json")).json();
  const file = await bytesOf(avatar);
  const model = await bytesOf(flame);
  const started = performance.now();
  const remote = await RemoteAvatar.open(file.slice(), model.slice(), { threads });
  await remote.render(512, 512);
  const first = performance.now() - started;
  remote.close();
  const player = await openAvatar(file, model, { threads });
  const begin = performance.now();
  player.render(512, 512);
  const result = { threads: player.threads, first, picture: performance.now() - begin, info: player.info() };
  for (const side of [512, 256]) {
    const out = new Uint8ClampedArray(4 * side * side);
    const times = frames.map((frame) => {
      const from = performance.now();
      set(player, frame, side);
      player.render(side, side, {}, out);
      return performance.now() - from;
    });
    player.resetParameters();
    result[`at${side}`] = { median: median(times.slice(5)), least: Math.min(...times.slice(5)) };
  }
  return result;
}

try {
  const jobs = { pictures, growth, errors, elements, files, gpu, renderers, speed };
  await post("/result", JSON.stringify(await jobs[query.get("job")]()));
} catch (error) {
  await post("/failed", String(error.stack ?? error));
}
