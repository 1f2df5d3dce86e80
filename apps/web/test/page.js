// What test/run.mjs asks of a page, by the query: one of these, with its result posted to /result.
import { openAvatar, openScene, RemoteAvatar } from "/web/src/index.js";

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
    no_flame: ["cosplat-avatar", { src: avatar }],
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
  const jobs = { pictures, growth, errors, elements, speed };
  await post("/result", JSON.stringify(await jobs[query.get("job")]()));
} catch (error) {
  await post("/failed", String(error.stack ?? error));
}
