// The pages in headless Chromium or Firefox at a desktop's and a phone's width, from `cosplat serve` and
// from a file of `cosplat export --html`:
//
//   node pages.mjs --cosplat PROGRAM --chromium|--firefox PROGRAM [--pictures FOLDER]
//
// Makes a head and a small avatar; checks that each page draws, is no wider than the window and tells
// nothing wrong; --pictures keeps screenshots.
import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import dgram from "node:dgram";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";

import { serve } from "./browser.mjs";
import { DevTools, sleep, until } from "./devtools.mjs";
import { Firefox } from "./firefox.mjs";

const { values } = parseArgs({
  options: Object.fromEntries(["cosplat", "chromium", "firefox", "pictures"].map((name) => [name, { type: "string" }])),
});
const here = import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname);
const work = fs.mkdtempSync(path.join(os.tmpdir(), "cosplat-pages-"));
const children = [];
process.on("exit", () => {
  for (const child of children) child.kill("SIGKILL");
  fs.rmSync(work, { recursive: true, force: true });
});

function run(...args) {
  execFileSync(values.cosplat, [...args, "--quiet"], { stdio: "inherit" });
}
const inWork = (name) => path.join(work, name);
run("make-head", "-o", inWork("head"), "--frames", "60", "--test-frames", "10", "--size", "256");
run("train-avatar", "-s", inWork("head"), "--flame", inWork("head/model.npz"), "-m", inWork("avatar"),
    "--preset", "quick", "--gaussians", "6000", "--iterations", "500");
run("export", "-m", inWork("avatar"), "--ply", inWork("scene.ply"), "--html", inWork("avatar.html"));
run("export", "--splats", inWork("scene.ply"), "--spz", inWork("scene.spz"), "--sog", inWork("scene.sog"));
run("export", "--splats", inWork("scene.spz"), "--html", inWork("scene.html"));
const refused = spawnSync(values.cosplat, ["export", "--splats", inWork("scene.sog"), "--html", inWork("none.html")], { encoding: "utf8" });
assert.match(refused.stderr, /scene\.sog: is SOG or version 4 of SPZ, whose decoders are not in a page of one file/);
assert.ok(!fs.existsSync(inWork("none.html")));

// Of `cosplat serve`.
function served(model, ...more) {
  const child = spawn(values.cosplat, ["serve", model, "--no-open", "--port", "0", ...more]);
  children.push(child);
  return new Promise((resolve, reject) => {
    child.stdout.once("data", (text) => resolve(new URL(String(text).split("\n")[0]).origin));
    child.once("exit", () => reject(new Error("cosplat serve ended")));
  });
}
const avatars = await served(inWork("avatar"));
const scenes = await served(inWork("scene.sog"));
// A phone's part: frames to a port that was free a moment ago.
const sender = dgram.createSocket("udp4");
const tracker = await new Promise((resolve) => sender.bind(0, "127.0.0.1", () => resolve(sender.address().port + 1)));
const relayed = await served(inWork("avatar"), "--relay", `udp://127.0.0.1:${tracker}`);
let sent = 0;
setInterval(() => sender.send(
  JSON.stringify({ seq: sent, time: sent / 50, jaw: [0.1 - 0.1 * Math.cos(sent++ / 8), 0, 0] }), tracker, "127.0.0.1"), 20);
// In place of MediaPipe, whose model is not in a package: a jaw that opens and a head that turns.
const elsewhere = await serve({ folders: { "/": here, "/playcanvas/": path.join(here, "../node_modules/playcanvas/build") } });
const mediapipe = `http://127.0.0.1:${elsewhere.address().port}/mediapipe-stub`;
const playcanvas = `http://127.0.0.1:${elsewhere.address().port}/playcanvas/playcanvas.min.mjs`;

// Isolated: whether the page may use threads.
const pages = [
  { name: "gallery", url: `${avatars}/pages/index.html`, isolated: true },
  { name: "gallery-splats", url: `${scenes}/pages/index.html`, isolated: true },
  { name: "gallery-gpu", url: `${avatars}/pages/index.html?playcanvas=${playcanvas}&renderer=gpu`, isolated: true, gpu: true },
  { name: "obs", url: `${avatars}/pages/obs.html?camera=20+5+0.9`, isolated: true },
  { name: "beyond", url: `${avatars}/pages/index.html`, isolated: true, beyond: true },
  { name: "relay", url: `${relayed}/pages/obs.html`, isolated: true, relay: true },
  { name: "webcam", url: `${avatars}/pages/webcam.html?package=${mediapipe}`, isolated: true, webcam: true },
  { name: "offline", url: pathToFileURL(inWork("avatar.html")).href, isolated: false },
  { name: "offline-splats", url: pathToFileURL(inWork("scene.html")).href, isolated: false },
];

const browser = await (values.firefox ? Firefox : DevTools).start({ ...values, profile: inWork("profile"), children, downloads: work });
const shown = "document.querySelector('cosplat-avatar, cosplat-splats')";
// Without a screen Firefox has neither a GPU nor a camera of a person.
const shownBy = pages.filter(({ webcam, gpu }) => !values.firefox || !(webcam || gpu));
for (const { name, url, isolated, webcam, relay, beyond, gpu = false } of shownBy)
  for (const [width, height] of [[1280, 800], [390, 844]]) {
    const page = await browser.page(url, width, height);
    const text = (id) => page.value(`document.getElementById("${id}")?.textContent ?? ""`);
    await until(`${name} draws`, async () => {
      const problem = await page.value("document.querySelector('.problem')?.textContent ?? ''");
      assert.equal(problem, "", name);
      return page.value(`Boolean(${shown}?.remote)`);
    });
    if (webcam) {
      await page.value("document.getElementById('start').click()");
      await until("faces are seen", async () => /^[1-9]\d* faces/.test(await text("tracking")));
      const health = await page.value(`${shown}.health()`);
      assert.ok(health.accepted > 0 && health.driveMalformed === 0, JSON.stringify(health));
    }
    if (relay) {
      await until("frames come", async () => (await page.value(`${shown}.health()`)).accepted > 20);
      const { driveMalformed } = await page.value(`${shown}.health()`);
      assert.equal(driveMalformed, 0);
    }
    if (beyond) {
      await page.value(`${shown}.setAttribute("camera", "180")`);
      await until("the page says what is a guess", async () => /a guess: the head was filmed from/.test(await page.value("document.querySelector('.speed').textContent")));
    }
    if (gpu) await until("the GPU draws", () => page.value(`${shown}.drawing === "gpu"`));
    await sleep(1500);
    assert.equal(await page.value(`${shown}.drawing`), gpu ? "gpu" : "cpu", name);
    assert.equal(await page.value("crossOriginIsolated"), isolated, name);
    const overflow = await page.value("document.documentElement.scrollWidth - innerWidth");
    assert.ok(overflow <= 0, `${name} is ${overflow} px wider than ${width}`);
    const threads = await page.value(`${shown}.remote.properties.threads`);
    assert.equal(threads > 1, isolated && os.availableParallelism() > 1, name);
    if (name === "obs" && !values.firefox) await page.ask("Emulation.setDefaultBackgroundColorOverride", { color: { r: 0, g: 0, b: 0, a: 0 } });
    if (values.pictures) {
      fs.mkdirSync(values.pictures, { recursive: true });
      fs.writeFileSync(path.join(values.pictures, `${name}-${width}.png`), await page.screenshot());
    }
    console.log(`${name} at ${width} px: ${threads} threads, ${(await page.value("document.querySelector('.speed')?.textContent")) || "at rest"}`);
    await page.close();
  }
process.exit(0);
