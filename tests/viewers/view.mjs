// Opens a trained scene's files in other programs' viewers, in headless Chromium, and compares their
// pictures with ours of the same file: docs/files.md has the figures. Needs node, chromium and
// `npm ci` in this folder.
//
//   node view.mjs MODEL -o OUT [--cosplat COMMAND] [--chromium COMMAND] [READER[:FORMAT]...]
//
// MODEL: the folder of a trained scene with held-out views (train-scene --eval). OUT gets the files,
// our pictures of three views, every reader's, and results.json. Every reader draws as 3DGS trains
// ("blur trained"), of the PLY also as it does by itself ("blur own"). Readers: playcanvas, spark,
// babylon, gaussian-splats-3d; formats: ply, glb, spz, sog. The .glb is also given to Khronos'
// validator.
import { execFileSync, spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

const here = path.dirname(fileURLToPath(import.meta.url));
const modules = path.join(here, "node_modules");
const kViews = 3;
const kTimeoutMs = 600_000;  // of one reader and format; SwiftShader is slow

// The version of SPZ that each reads.
const spzVersion = { playcanvas: 4, spark: 3, babylon: 3, "gaussian-splats-3d": 2 };
const formatsOf = {
  playcanvas: ["ply", "glb", "spz", "sog"],
  spark: ["ply", "spz", "sog"],
  babylon: ["ply", "glb", "spz", "sog"],
  "gaussian-splats-3d": ["ply", "spz"],
};

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    out: { type: "string", short: "o" },
    cosplat: { type: "string", default: "cosplat" },
    chromium: { type: "string", default: "chromium" },
  },
});
const [model, ...chosen] = positionals;
if (!model || !options.out) {
  console.error("usage: node view.mjs MODEL -o OUT [READER[:FORMAT]...]");
  process.exit(2);
}
const out = path.resolve(options.out);
fs.mkdirSync(out, { recursive: true });
const cosplat = (...parameters) =>
  execFileSync(options.cosplat, parameters, { stdio: ["ignore", "pipe", "inherit"] }).toString();

// The files.
function prepare() {
  for (const version of [2, 3, 4])
    cosplat("export", "-m", model, "--spz", `${out}/v${version}.spz`, "--spz-version", version);
  cosplat("export", "-m", model, "--ply", `${out}/scene.ply`, "--glb", `${out}/scene.glb`,
    "--sog", `${out}/scene.sog`);
}

function fileOf(reader, format) {
  return format === "spz" ? `v${spzVersion[reader]}.spz` : `scene.${format}`;
}

// The views with our pictures of a file, from what it holds.
function viewsOf(file) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "cosplat-ours-"));
  fs.cpSync(model, folder, { recursive: true });  // render writes into the model's folder
  cosplat("render", "-m", folder, "--splats", path.join(out, file), "--quiet");
  const test = path.join(folder, "test");
  const stem = path.parse(file).name;
  const run = fs.readdirSync(test).find((name) => name.endsWith(`_${stem}`));
  const renders = path.join(test, run, "renders");
  const cameras = JSON.parse(fs.readFileSync(path.join(model, "cameras.json")));
  const names = fs.readdirSync(renders).sort();
  const views = Array.from({ length: kViews }, (_, k) => {
    const index = Math.floor((k * names.length) / kViews);
    fs.copyFileSync(path.join(renders, names[index]), path.join(out, `ours_${file}_${k}.png`));
    const { position, rotation, fx, fy, width, height } = cameras[index];  // test views come first
    const column = (c) => rotation.map((row) => row[c]);
    return {
      image: `/files/ours_${file}_${k}.png`, position, right: column(0), down: column(1),
      forward: column(2), fx, fy, cx: width / 2, cy: height / 2, width, height,
    };
  });
  fs.rmSync(folder, { recursive: true, force: true });
  return views;
}

const types = {
  ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript",
  ".wasm": "application/wasm", ".png": "image/png", ".json": "application/json",
};
const roots = { "/packages/": modules, "/page/": path.join(here, "page"), "/files/": out };

function serve(url, response) {
  const prefix = Object.keys(roots).find((start) => url.startsWith(start));
  const file = prefix && path.join(roots[prefix], url.slice(prefix.length));
  if (!file || !file.startsWith(roots[prefix]) || !fs.existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.setHeader("content-type", types[path.extname(file)] ?? "application/octet-stream");
  fs.createReadStream(file).pipe(response);
}

// One browser per reader and format. Resolves with what compare.js sends.
function show(job) {
  const profile = fs.mkdtempSync(path.join(os.tmpdir(), "cosplat-viewers-"));
  return new Promise((resolve) => {
    let browser = null;
    const server = http.createServer(async (request, response) => {
      const url = new URL(request.url, "http://localhost");
      if (url.pathname === "/job") response.end(JSON.stringify(job));
      else if (url.pathname === "/progress") response.end();
      else if (url.pathname === "/result") {
        const body = [];
        for await (const part of request) body.push(part);
        response.end();
        finish(JSON.parse(Buffer.concat(body)));
      } else serve(decodeURIComponent(url.pathname), response);
    });
    const timer = setTimeout(() => finish({ error: "no picture in time" }), kTimeoutMs);
    let finished = false;
    function finish(result) {
      if (finished) return;
      finished = true;
      clearTimeout(timer);
      server.closeAllConnections();
      server.close();
      browser.removeAllListeners("exit");
      browser.once("exit", () => {
        fs.rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
        resolve(result);
      });
      process.kill(-browser.pid, "SIGKILL");
    }
    server.listen(0, "127.0.0.1", () => {
      const flags = [
        "--headless=new", "--no-first-run", `--user-data-dir=${profile}`, "--use-gl=angle",
        "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage",
        "--window-size=1200,1000", "--force-device-scale-factor=1",
        "--force-color-profile=srgb", "--enable-logging=stderr",
      ];
      if (process.getuid?.() === 0) flags.push("--no-sandbox");  // it refuses root's
      const log = fs.openSync(path.join(out, `${job.reader}_${job.format}_${job.blur}.log`), "w");
      browser = spawn(
        options.chromium,
        [...flags, `http://127.0.0.1:${server.address().port}/page/index.html`],
        { stdio: ["ignore", log, log], detached: true },
      );
      browser.on("exit", () => finish({ error: `${options.chromium} ended early` }));
    });
  });
}

// Khronos' validator: errors, and whether it knows the extension.
async function validate() {
  const validator = createRequire(import.meta.url)("gltf-validator");
  const report = await validator.validateBytes(
    new Uint8Array(fs.readFileSync(path.join(out, "scene.glb"))), { maxIssues: 1000 });
  const codes = {};
  for (const { code, severity } of report.issues.messages)
    codes[`${["error", "warning", "info", "hint"][severity]} ${code}`] =
      (codes[`${["error", "warning", "info", "hint"][severity]} ${code}`] ?? 0) + 1;
  return codes;
}

async function compare(reader, format, blur) {
  const file = fileOf(reader, format);
  const views = viewsOf(file);
  const { width, height } = views[0];
  const url = `/files/${file}`;
  const result = await show({ reader, format, blur, url, views, width, height });
  const name = `${reader} ${file}, blur ${blur}`;
  if (result.error) {
    results[name] = { error: result.error };
    console.log(`${name}: ${result.error}`);
    return;
  }
  results[name] = { psnr: result.views.map((view) => view.psnr) };
  result.views.forEach((view, k) => fs.writeFileSync(
    path.join(out, `${reader}_${format}_${blur}_${k}.png`),
    Buffer.from(view.png.split(",")[1], "base64")));
  console.log(`${name}: ${results[name].psnr.map((x) => x.toFixed(2)).join(" ")} dB`);
}

prepare();
const results = { glb: await validate() };
console.log("Khronos' validator:", JSON.stringify(results.glb));
for (const [reader, formats] of Object.entries(formatsOf))
  for (const format of formats) {
    const wanted = chosen.length === 0 || chosen.includes(reader) ||
      chosen.includes(`${reader}:${format}`);
    if (!wanted) continue;
    // Of the PLY also as the reader draws by itself.
    for (const blur of format === "ply" ? ["own", "trained"] : ["trained"])
      await compare(reader, format, blur);
  }
fs.writeFileSync(path.join(out, "results.json"), JSON.stringify(results, null, 2) + "\n");
