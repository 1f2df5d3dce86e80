// A headless Chromium that shows a page of ours, and the server which the page talks to.
import { spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import os from "node:os";
import path from "node:path";

const here = import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname);
const types = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".wasm": "application/wasm",
};

let browser = null, profile = null;

// Ends the browser and this program.
export function stop(status) {
  if (browser) {
    browser.removeAllListeners("exit");
    try {
      process.kill(-browser.pid, "SIGKILL");
    } catch {}  // it has ended by itself
  }
  if (profile) fs.rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
  process.exit(status);
}

export function fail(message) {
  console.error(message);
  stop(1);
}

// Files of the page, and of the packages under /packages/.
function serveFile(url, modules, response) {
  const packages = "/packages/";
  const root = url.startsWith(packages) ? path.join(modules, "@mediapipe") : here;
  const name = url.startsWith(packages) ? url.slice(packages.length) : url.slice(1);
  const file = path.join(root, name);
  if (!file.startsWith(root) || !fs.existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.setHeader("content-type", types[path.extname(file)] ?? "application/octet-stream");
  response.end(fs.readFileSync(file));
}

// Opens `url` in a page that has `permissions`, which can be given over Chromium's debugging pipe
// alone. Its messages end in a zero byte; answers are not needed, as a page that is refused
// something says so itself.
function openPermitted(origin, url, permissions) {
  const [, , , commands, answers] = browser.stdio;
  const send = (method, params) =>
    commands.write(`${JSON.stringify({ id: 1, method, params })}\0`);
  commands.on("error", () => {});  // it has ended, which is said elsewhere
  answers.resume();
  send("Browser.grantPermissions", { origin, permissions });
  send("Target.createTarget", { url });
}

// Opens `page` (of page/, with its query) in `chromium`. modules: npm's node_modules. answer(url,
// body, response) has what pages post, but "/failed", whose text ends this program. flags: of
// Chromium, besides those that all pages need. permissions: that the page is given.
export function open({ chromium, modules, page, answer, flags = [], permissions = [] }) {
  profile = fs.mkdtempSync(path.join(os.tmpdir(), "cosplat-chromium-"));
  for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.on(signal, () => stop(1));
  const server = http.createServer(async (request, response) => {
    const url = new URL(request.url, "http://localhost").pathname;
    const parts = [];
    for await (const part of request) parts.push(part);
    const body = Buffer.concat(parts);
    if (url === "/failed") fail(body.toString());
    else if (request.method === "POST") answer(url, body, response);
    else serveFile(url, modules, response);
  });
  server.listen(0, "127.0.0.1", () => {
    const origin = `http://127.0.0.1:${server.address().port}`;
    // SwiftShader draws on the CPU: the packages need WebGL to scale and to crop.
    const all = [
      "--headless=new",
      "--no-first-run",
      `--user-data-dir=${profile}`,
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--disable-dev-shm-usage",
      ...flags,
    ];
    if (process.getuid?.() === 0) all.push("--no-sandbox");  // it refuses root's
    const log = fs.openSync(path.join(profile, "log"), "w");
    const url = `${origin}/page/${page}`, permitted = permissions.length > 0;
    all.push(...(permitted ? ["--remote-debugging-pipe", "about:blank"] : [url]));
    const stdio = ["ignore", log, log, ...(permitted ? ["pipe", "pipe"] : [])];
    browser = spawn(chromium, all, { stdio, detached: true });
    browser.on("error", (error) => fail(`${chromium}: ${error.message}`));
    browser.on("exit", (code, signal) => {
      const lines = fs.readFileSync(path.join(profile, "log"), "utf8").trim().split("\n");
      fail(`${chromium} ended early (${signal ?? code}): ${lines.at(-1)}`);
    });
    if (permitted) openPermitted(origin, url, permissions);
  });
}
