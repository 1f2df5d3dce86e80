// Runs MediaPipe's face mesh and selfie segmentation over images, in headless Chromium.
//
//   node detect.mjs --chromium PROGRAM --modules FOLDER --jobs face,matte --width W --height H
//                   --frames FOLDER
//
// FOLDER of frames has 0.jpg ... N-1.jpg of one size, and times.json: when each was taken, in
// increasing milliseconds. faces.json (per frame a list of faces, each a list of [x, y] in pixels)
// and 0.matte ... (a byte per pixel, rows from the top) are written beside them, by the job that
// is asked for. FOLDER of modules is npm's node_modules. Prints "frame K" for each frame that all
// jobs have seen.
//
// Each item of --jobs is a page that asks for a frame, and posts what it found with the next request.
// Pages of one job share its frames, which should not follow each other then. The pages have
// different origins, so that Chromium gives each a process, and they run on several cores.
import { spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import os from "node:os";
import path from "node:path";
import { parseArgs } from "node:util";

const names = ["chromium", "modules", "frames", "jobs", "width", "height"];
const { values: options } = parseArgs({
  options: Object.fromEntries(names.map((name) => [name, { type: "string" }])),
});
const times = JSON.parse(fs.readFileSync(path.join(options.frames, "times.json")));
const count = times.length;
const here = import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname);
const pages = options.jobs.split(",").map((job) => ({ job, frame: null }));
const next = Object.fromEntries(pages.map(({ job }) => [job, 0]));
const found = { ...next };
const faces = new Array(count);
const profile = fs.mkdtempSync(path.join(os.tmpdir(), "cosplat-chromium-"));

const types = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".wasm": "application/wasm",
};

function fail(message) {
  console.error(message);
  stop(1);
}

// A frame for `page`, and what it found in the one before.
function answer(page, result, response) {
  const { job, frame } = page;
  if (result.length > 0) {
    if (job === "face") faces[frame] = JSON.parse(result.toString());
    else fs.writeFileSync(path.join(options.frames, `${frame}.matte`), result);
    const before = Math.min(...Object.values(found));
    ++found[job];
    const all = Math.min(...Object.values(found));
    if (all > before) console.log(`frame ${all}`);
  }
  if (next[job] < count) {
    page.frame = next[job]++;
    response.setHeader("content-type", "image/jpeg");
    response.setHeader("x-milliseconds", times[page.frame]);
    response.end(fs.readFileSync(path.join(options.frames, `${page.frame}.jpg`)));
    return;
  }
  response.writeHead(204).end();
  if (Object.values(found).every((each) => each === count)) {
    fs.writeFileSync(path.join(options.frames, "faces.json"), JSON.stringify(faces));
    stop(0);
  }
}

// Files of the page, and of the packages under /packages/.
function serve(url, response) {
  const packages = "/packages/";
  const root = url.startsWith(packages) ? path.join(options.modules, "@mediapipe") : here;
  const name = url.startsWith(packages) ? url.slice(packages.length) : url.slice(1);
  const file = path.join(root, name);
  if (!file.startsWith(root) || !fs.existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.setHeader("content-type", types[path.extname(file)] ?? "application/octet-stream");
  response.end(fs.readFileSync(file));
}

const server = http.createServer(async (request, response) => {
  const url = new URL(request.url, "http://localhost").pathname;
  const body = [];
  for await (const part of request) body.push(part);
  const page = pages[Number(/^\/page-([0-9]+)$/.exec(url)?.[1])];
  if (url === "/failed") fail(Buffer.concat(body).toString());
  else if (request.method === "POST" && page) answer(page, Buffer.concat(body), response);
  else serve(url, response);
});

let browser = null;
function stop(status) {
  if (browser) {
    browser.removeAllListeners("exit");
    try {
      process.kill(-browser.pid, "SIGKILL");
    } catch {}  // it has ended by itself
  }
  fs.rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
  process.exit(status);
}
for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.on(signal, () => stop(1));

server.listen(0, "127.0.0.1", () => {
  const { port } = server.address();
  const { jobs, width, height } = options;
  const query = new URLSearchParams({ jobs, width, height });
  // SwiftShader draws on the CPU: the packages need WebGL to scale and to crop.
  const flags = [
    "--headless=new",
    "--no-first-run",
    `--user-data-dir=${profile}`,
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
  ];
  if (process.getuid?.() === 0) flags.push("--no-sandbox");  // it refuses root's
  const log = fs.openSync(path.join(profile, "log"), "w");
  browser = spawn(
    options.chromium,
    [...flags, `http://127.0.0.1:${port}/page/index.html?${query}`],
    { stdio: ["ignore", log, log], detached: true },
  );
  browser.on("error", (error) => fail(`${options.chromium}: ${error.message}`));
  browser.on("exit", (code, signal) => {
    const lines = fs.readFileSync(path.join(profile, "log"), "utf8").trim().split("\n");
    fail(`${options.chromium} ended early (${signal ?? code}): ${lines.at(-1)}`);
  });
});
