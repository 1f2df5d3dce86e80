// Headless Chromium for tests and measurements: serves folders, opens a page and waits for what it
// posts to /result.
import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import fs from "node:fs";
import http from "node:http";
import os from "node:os";
import path from "node:path";

const types = {
  ".css": "text/css",
  ".html": "text/html",
  ".js": "text/javascript",
  ".mjs": "text/javascript",
  ".wasm": "application/wasm",
};

// The path of the file of the first folder that has it, by the URL's prefix; null if none does.
export function fileOf(folders, url) {
  const name = decodeURIComponent(url);
  for (const [prefix, folder] of Object.entries(folders)) {
    if (!name.startsWith(prefix)) continue;
    const file = path.join(folder, name.slice(prefix.length));
    if (file.startsWith(folder) && fs.existsSync(file) && fs.statSync(file).isFile()) return file;
  }
  return null;
}

// A WebSocket (RFC 6455) that sends 20 frames of a face, one each 20 ms, and is then lost.
function sendFace(request, socket) {
  const key = `${request.headers["sec-websocket-key"]}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`;
  const accept = createHash("sha1").update(key).digest("base64");
  socket.write(
    `HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\n\r\n`,
  );
  socket.on("error", () => {});
  let seq = 0;
  const timer = setInterval(() => {
    const text = Buffer.from(JSON.stringify({ seq: ++seq, jaw: [0.01 * seq, 0, 0] }));
    socket.write(Buffer.concat([Buffer.from([0x81, text.length]), text]));
    if (seq < 20) return;
    clearInterval(timer);
    socket.destroy();
  }, 20);
  socket.on("close", () => clearInterval(timer));
}

// folders: {"/prefix/": folder}. answer(url, body): for POST requests. isolated: with the headers
// that allow threads.
export function serve({ folders, isolated = true, answer = () => {} }) {
  const server = http.createServer(async (request, response) => {
    const url = new URL(request.url, "http://localhost").pathname;
    if (isolated) {
      response.setHeader("cross-origin-opener-policy", "same-origin");
      response.setHeader("cross-origin-embedder-policy", "require-corp");
      response.setHeader("cross-origin-resource-policy", "cross-origin");
      response.setHeader("access-control-allow-origin", "*");
    }
    if (request.method === "POST") {
      const body = [];
      for await (const part of request) body.push(part);
      response.end();
      return answer(url, Buffer.concat(body));
    }
    const file = fileOf(folders, url);
    if (!file) return response.writeHead(404).end();
    response.setHeader("content-type", types[path.extname(file)] ?? "application/octet-stream");
    fs.createReadStream(file).pipe(response);
  });
  server.on("upgrade", sendFace);
  return new Promise((resolve) => server.listen(0, "127.0.0.1", () => resolve(server)));
}

// WebGL and WebGPU on the CPU.
export const software = [
  "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--enable-unsafe-webgpu",
  "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan", "--use-vulkan=swiftshader",
];

// webgl: with a GPU, by software. Opens `page` (an URL's path and query) and resolves to what it posts to /result; rejects with what
// it posts to /failed, if the browser ends, or after `seconds`.
export async function inBrowser({ chromium, page, folders, isolated, webgl = false, flags = [], seconds = 120 }) {
  const profile = fs.mkdtempSync(path.join(os.tmpdir(), "cosplat-chromium-"));
  let browser = null;
  let server = null;
  try {
    return await new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`${page}: no result in ${seconds} s`)), 1e3 * seconds);
      timer.unref();
      const answer = (url, body) => {
        if (url === "/result") resolve(JSON.parse(body.toString()));
        if (url === "/failed") reject(new Error(body.toString()));
        if (url === "/log") console.error(body.toString());
      };
      serve({ folders, isolated, answer }).then((started) => {
        server = started;
        const log = fs.openSync(path.join(profile, "log"), "w");
        const all = [
          "--headless=new",
          "--no-first-run",
          `--user-data-dir=${profile}`,
          ...(webgl ? software : ["--disable-gpu"]),
          "--disable-dev-shm-usage",
          ...(process.getuid?.() === 0 ? ["--no-sandbox"] : []),  // it refuses root's
          ...flags,
          `http://127.0.0.1:${server.address().port}${page}`,
        ];
        browser = spawn(chromium, all, { stdio: ["ignore", log, log], detached: true });
        browser.on("error", (error) => reject(new Error(`${chromium}: ${error.message}`)));
        browser.on("exit", (code, signal) => reject(new Error(`${chromium} ended early (${signal ?? code})`)));
      });
    });
  } finally {
    if (browser) {
      browser.removeAllListeners("exit");
      browser.on("exit", () => {});
      try {
        process.kill(-browser.pid, "SIGKILL");
      } catch {}  // it has ended by itself
    }
    server?.close();
    server?.closeAllConnections();
    fs.rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
  }
}
