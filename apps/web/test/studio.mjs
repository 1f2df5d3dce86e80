// The studio in headless Chromium or Firefox, from a film to a playing avatar:
//
//   node studio.mjs --cosplat PROGRAM --chromium|--firefox PROGRAM [--film FILE] [--quality draft] [--pictures FOLDER]
//                   [--dist FOLDER] [--out avatar.glb] [--frames FOLDER] [--times N] [--profile SECONDS]
//
// With --film only that, and how long each part took; --frames keeps its frames, for `cosplat avatar`;
// --times: so many avatars in a row, in one tab, and the memory after each; --profile (Chromium): where the time of so many
// seconds of the training goes. Otherwise with films of the made head: as a file,
// by the camera (Chromium's takes a film), in a tab that is closed and goes on, without a network, and with what goes wrong.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";

import { serve } from "./browser.mjs";
import { DevTools, sleep, until } from "./devtools.mjs";
import { Firefox } from "./firefox.mjs";

const { values } = parseArgs({
  options: Object.fromEntries(["cosplat", "chromium", "firefox", "film", "quality", "pictures", "dist", "out", "frames", "times", "profile"].map((name) => [name, { type: "string" }])),
});
const here = import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname);
const web = path.join(here, "..");
const work = fs.mkdtempSync(path.join(os.tmpdir(), "cosplat-studio-"));
const children = [];
process.on("exit", () => {
  for (const child of children) child.kill("SIGKILL");
  try {
    fs.rmSync(work, { recursive: true, force: true });
  } catch {}  // the browser is still writing
});
const inWork = (name) => path.join(work, name);
// [[path, base64]] of what the page has stored.
const stored = (folder) => `(async () => {
  const { Store } = await import("/pages/studio/store.js");
  return (await (await Store.open()).all("${folder}")).map(({ path, bytes }) => {
    let text = "";
    for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
    return [path, btoa(text)];
  });
})()`;
async function save(page, folder, to) {
  for (const [file, base64] of await page.value(stored(folder))) {
    const name = to(path.basename(file));
    fs.mkdirSync(path.dirname(name), { recursive: true });
    fs.writeFileSync(name, Buffer.from(base64, "base64"));
  }
}
const SECONDS = 1500;  // that an avatar may take

const folders = { "/dist/": values.dist ?? path.join(web, "dist"), "/head/": inWork("head"), "/": web };
const originOf = (server) => `http://127.0.0.1:${server.address().port}`;
const server = await serve({ folders });
const isolated = originOf(server);
const saved = inWork("saved");
const open = (name, ...flags) =>
  (values.firefox ? Firefox : DevTools).start({ ...values, profile: inWork(name), children, downloads: saved, flags });

// The studio's page, and what is asked of other places than its own.
async function studio(browser, width = 1280, origin = isolated) {
  const page = await browser.page("about:blank", width, 900);
  // Where no headers allow threads, and no service worker adds them, as by http from another machine.
  if (origin !== isolated) await page.ask("Page.addScriptToEvaluateOnNewDocument", { source: "delete Navigator.prototype.serviceWorker" });
  page.elsewhere = async () => (await page.requests()).filter((url) => !/^(blob|data|about):/.test(url) && !url.startsWith(origin));
  await page.goTo(`${origin}/pages/studio.html`);
  page.text = (id) => page.value(`document.getElementById("${id}")?.textContent ?? ""`);
  page.picture = async (name) => {
    if (!values.pictures) return;
    fs.mkdirSync(values.pictures, { recursive: true });
    fs.writeFileSync(path.join(values.pictures, `${name}-${width}.png`), await page.screenshot());
  };
  page.ready = () => until("the studio is ready", () => page.value("document.getElementById('drop')?.dataset.ready === 'true'"));
  page.quality = (quality) => page.value(`document.getElementById("quality").value = ${JSON.stringify(quality)}`);
  page.problem = () => page.value("document.querySelector('#status.problem')?.textContent ?? ''");
  page.plays = () => page.value("Boolean(document.querySelector('cosplat-avatar')?.remote)");
  await page.ready();
  return page;
}

// Until the avatar is done; says when each part began.
async function made(page, name) {
  const begun = performance.now(), clock = () => `${((performance.now() - begun) / 1000).toFixed(1).padStart(6)} s`;
  let last = "", shown = false;
  await until(`${name}: the avatar is done`, async () => {
    const now = await page.text("step"), title = now.split(":")[0];
    assert.equal(await page.problem(), "", name);
    if (title !== last) {
      console.log(clock(), now);
      last = title;
      await page.picture(`${name}-${title.split(" ")[0].toLowerCase()}`);
      if (values.frames && title === "Looking for the head") await save(page, "/frames/", (file) => path.join(values.frames, file));
    }
    if (values.profile && /^Training: [1-9]\d\d/.test(now)) {
      for (const worker of await page.profile(Number(values.profile))) {
        console.log("a worker");
        for (const [name, share] of worker.slice(0, 40)) console.log(`  ${(100 * share).toFixed(1).padStart(5)} %  ${name.slice(0, 110)}`);
      }
      values.profile = "";
    }
    if (!shown && (await page.plays())) {
      shown = true;
      console.log(clock(), "an avatar plays");
      await sleep(1000);
      await page.picture(`${name}-first`);
    }
    return now.startsWith("Done");
  }, SECONDS);
  await sleep(1500);
  await page.picture(`${name}-done`);
  assert.ok(await page.plays(), name);
  assert.deepEqual(await page.elsewhere(), [], name);
}

if (values.film) {
  const page = await studio(await open("profile"));
  await page.picture("begin");
  await page.quality(values.quality ?? "draft");
  for (let i = 0; i < Number(values.times ?? 1); ++i) {
    await page.choose("#file", path.resolve(values.film));
    await until("it has begun", async () => !(await page.text("step")).startsWith("Done"));
    await made(page, "film");
    console.log(await page.text("log"));
    const bytes = await page.value("performance.measureUserAgentSpecificMemory?.().then(({ bytes }) => bytes)");
    console.log(`memory: ${await page.value("document.documentElement.dataset.megabytes")} MB of the trainer, ${bytes ? Math.round(bytes / 1e6) : "?"} MB of the page after it`);
  }
  if (values.out) await save(page, "/avatar.glb", () => values.out);
  process.exit(0);
}

// The made head's film: what a recorder writes, and what a camera is played.
// Without the frames from all around, which come last.
const FRAMES = 80, SIZE = 384;
execFileSync(values.cosplat, ["make-head", "-o", inWork("head"), "--frontal", "--frames", String(FRAMES + 60), "--size", String(SIZE), "--quiet"], { stdio: "inherit" });
const browser = await open("profile");
const page = await studio(browser);
await page.picture("begin");
const planes = await page.value(`(async () => {
  const canvas = Object.assign(document.createElement("canvas"), { width: ${SIZE}, height: ${SIZE} });
  const context = canvas.getContext("2d", { willReadFrequently: true });
  const recorder = new MediaRecorder(canvas.captureStream(25), { videoBitsPerSecond: 2e7 }), parts = [];
  recorder.ondataavailable = ({ data }) => parts.push(data);
  const stopped = new Promise((resolve) => (recorder.onstop = resolve));
  recorder.start();
  let frames = "";
  for (let i = 1; i <= ${FRAMES}; ++i) {
    context.drawImage(await createImageBitmap(await (await fetch("/head/image/" + i + ".png")).blob()), 0, 0);
    await new Promise((resolve) => setTimeout(resolve, 40));
    const { data } = context.getImageData(0, 0, ${SIZE}, ${SIZE});
    for (let k = 0; k < data.length; k += 4) frames += String.fromCharCode(data[k], data[k + 1], data[k + 2]);
  }
  recorder.stop();
  await stopped;
  globalThis.film = new File(parts, "film.webm");
  return btoa(frames);
})()`);
// 4:2:0, BT.601.
function writeY4m(file, rgb) {
  const out = [Buffer.from(`YUV4MPEG2 W${SIZE} H${SIZE} F25:1 Ip A1:1 C420jpeg\n`)];
  for (let f = 0; f < FRAMES; ++f) {
    const at = (x, y) => 3 * ((f * SIZE + y) * SIZE + x);
    const luma = Buffer.alloc(SIZE * SIZE), chroma = [Buffer.alloc((SIZE * SIZE) / 4), Buffer.alloc((SIZE * SIZE) / 4)];
    for (let y = 0; y < SIZE; ++y)
      for (let x = 0; x < SIZE; ++x) {
        const [r, g, b] = rgb.subarray(at(x, y), at(x, y) + 3), l = 0.299 * r + 0.587 * g + 0.114 * b;
        luma[y * SIZE + x] = Math.round(l);
        if (x % 2 || y % 2) continue;
        const k = (y / 2) * (SIZE / 2) + x / 2;
        chroma[0][k] = Math.round(128 + (b - l) / 1.772);
        chroma[1][k] = Math.round(128 + (r - l) / 1.402);
      }
    out.push(Buffer.from("FRAME\n"), luma, ...chroma);
  }
  fs.writeFileSync(file, Buffer.concat(out));
}
writeY4m(inWork("camera.y4m"), Buffer.from(planes, "base64"));

// A file without a face, or that is none, says so, and the page goes on.
async function drop(page, file) {
  await page.value(`(() => {
    const transfer = new DataTransfer();
    transfer.items.add(${file});
    const input = document.getElementById("file");
    input.files = transfer.files;
    input.dispatchEvent(new Event("change"));
  })()`);
}
async function refused(page, file, words) {
  await drop(page, file);
  await until(`refused: ${words}`, async () => words.test(await page.problem()), 60);
  console.log(`refused: ${await page.problem()}`);
}
await page.quality("draft");
await refused(page, 'new File(["no video"], "notes.mp4")', /notes\.mp4: is no video that this browser plays/);
await page.value(`(async () => {
  const canvas = Object.assign(document.createElement("canvas"), { width: 64, height: 64 }), parts = [];
  const context = canvas.getContext("2d"), recorder = new MediaRecorder(canvas.captureStream(25));
  recorder.ondataavailable = ({ data }) => parts.push(data);
  const stopped = new Promise((resolve) => (recorder.onstop = resolve));
  recorder.start();
  for (let i = 0; i < 20; ++i) {
    context.fillRect(i, i, 9, 9);
    await new Promise((resolve) => setTimeout(resolve, 40));
  }
  recorder.stop();
  await stopped;
  globalThis.wall = new File(parts, "wall.webm");
})()`);
await refused(page, "globalThis.wall", /no face/);

// A model that does not fit: nothing is begun.
await page.value(`(() => {
  const transfer = new DataTransfer();
  transfer.items.add(new File(["no model"], "flame2023.pkl"));
  document.getElementById("flame").files = transfer.files;
})()`);
await refused(page, "globalThis.film", /flame2023\.pkl: /);
await page.value('document.getElementById("flame").value = ""');

// A full storage costs what a closed tab would go on from, and nothing else; Stop ends at once.
await page.value(`globalThis.put = IDBObjectStore.prototype.put;
  IDBObjectStore.prototype.put = () => { throw new DOMException("full", "QuotaExceededError"); }`);
await drop(page, "globalThis.film");
await until("the storage is said to be full", async () => /storage is full/.test(await page.text("kept")), 60);
await until("it is made all the same", async () => /^(Cutting|Finding|Looking)/.test(await page.text("step")), 60);
await page.value("IDBObjectStore.prototype.put = globalThis.put; document.getElementById('stop').click()");
await until("it has stopped", async () => (await page.text("status")) === "Stopped.", 5);
assert.ok(await page.value("!document.getElementById('file').disabled"));

// A tab that is killed in the middle of the training goes on where it was.
await drop(page, "globalThis.film");
await until("the training has begun", async () => /^Training: [1-9]\d\d/.test(await page.text("step")), SECONDS);
const at = await page.text("step");
await until("a checkpoint is kept", () => page.value(`(async () => {
  const { Store } = await import("/pages/studio/store.js");
  return (await (await Store.open()).all("/me/avatar/")).some(({ path }) => path.includes("checkpoint"));
})()`), 120);
await page.close();
console.log(`closed at ${at}`);
const again = await studio(browser);
await made(again, "again");
const log = await again.text("log");
assert.match(log, /resumed at step (?!2,000 )/);
console.log(log.split("\n").filter((line) => /PSNR|resum/.test(line)).join("\n"));

// What is saved: the avatar, and a page that plays it from a file.
for (const [id, name, seconds] of [["glb", "avatar.glb", 0], ["html", "me.html", 0], ["record", "me.webm", 2]]) {
  await again.value(`document.getElementById("${id}").click()`);
  if (seconds) {
    await sleep(1000 * seconds);
    await again.value(`document.getElementById("${id}").click()`);
  }
  await until(`${name} is saved`, () => fs.existsSync(path.join(saved, name)) && fs.statSync(path.join(saved, name)).size > 1e4);
}
const [[, base64]] = await again.value(stored("/avatar.glb"));
assert.ok(fs.readFileSync(path.join(saved, "avatar.glb")).equals(Buffer.from(base64, "base64")));
const alonePage = await browser.page(pathToFileURL(path.join(saved, "me.html")).href, 1280, 900);
await until("the saved page plays", () => alonePage.value("Boolean(document.querySelector('cosplat-avatar')?.remote)"));
await alonePage.close();

// Without a network.
await until("all is in the cache", () => again.value("document.documentElement.dataset.offline === 'true'"), 120);
server.close();
server.closeAllConnections();
await again.reload();
await again.ready();
await until("the earlier avatar plays without a network", () => again.plays());
await again.close();

if (values.firefox) process.exit(0);

// By the camera, on a phone's width, with one thread.
const alone = originOf(await serve({ folders, isolated: false }));
const filmed = await studio(await open("camera", `--use-file-for-fake-video-capture=${inWork("camera.y4m")}`), 390, alone);
assert.equal(await filmed.value("crossOriginIsolated"), false);
await filmed.quality("draft");
await filmed.value("document.getElementById('camera').click()");
await until("frames are taken", async () => /\([1-9]\d* frames\)/.test(await filmed.text("status")), 60);
await filmed.picture("coach");
await made(filmed, "camera");
const overflow = await filmed.value("document.documentElement.scrollWidth - innerWidth");
assert.ok(overflow <= 0, `${overflow} px wider than the window`);
await filmed.value("document.getElementById('live').click()");
await until("the camera moves it", async () => /^[1-9]\d* faces per second/.test(await filmed.text("status")), 60);
const health = await filmed.value("document.querySelector('cosplat-avatar').health()");
assert.ok(health.accepted > 0 && health.driveMalformed === 0, JSON.stringify(health));
await filmed.picture("live");

// A camera that goes away in the middle of a film.
await filmed.value("document.getElementById('camera').click()");
await until("frames are taken again", async () => /\([1-9]\d* frames\)/.test(await filmed.text("status")), 60);
await filmed.value("document.getElementById('video').srcObject.getTracks()[0].stop()");
await until("the camera is missed", async () => (await filmed.problem()) === "camera: the camera has gone", 20);
assert.ok(await filmed.plays(), "the avatar is still there");
process.exit(0);
