// Pages of headless Chromium by its DevTools protocol, over a pipe: messages that end in a zero byte.
import { spawn } from "node:child_process";

import { software } from "./browser.mjs";

export class DevTools {
  // flags: more of Chromium's.
  // downloads: a folder.
  static async start({ downloads, ...how }) {
    const self = new DevTools(how);
    await self.ask("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: downloads });
    return self;
  }
  constructor({ chromium, profile, children, flags: more = [] }) {
    this.count = 0;
    this.answers = new Map();
    this.listeners = new Map();
    const flags = [
      "--headless=new", "--no-first-run", `--user-data-dir=${profile}`, ...software,
      "--disable-dev-shm-usage", "--remote-debugging-pipe", "--use-fake-device-for-media-stream",
      "--use-fake-ui-for-media-stream", ...more, ...(process.getuid?.() === 0 ? ["--no-sandbox"] : []),
    ];
    const stdio = ["ignore", "ignore", "ignore", "pipe", "pipe"];
    const child = spawn(chromium, flags, { stdio });
    children.push(child);
    this.to = child.stdio[3];
    let rest = "";
    child.stdio[4].setEncoding("utf8").on("data", (text) => {
      const parts = (rest + text).split("\0");
      rest = parts.pop();
      for (const part of parts) this.receive(JSON.parse(part));
    });
  }
  receive({ id, result, error, method, params, sessionId }) {
    if (method) return this.listeners.get(`${sessionId} ${method}`)?.(params);
    const answer = this.answers.get(id);
    this.answers.delete(id);
    if (error) answer?.reject(new Error(error.message));
    else answer?.resolve(result);
  }
  ask(method, params = {}, sessionId = undefined) {
    const id = ++this.count;
    this.to.write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
    return new Promise((resolve, reject) => this.answers.set(id, { resolve, reject }));
  }
  // What the workers of a page or worker do, and theirs, in so many seconds: for each the shares of the functions, the
  // largest first. The module has names if it was linked with --profiling-funcs.
  async profile(sessionId, seconds) {
    const workers = [];
    const attach = async (to) => {
      this.listeners.set(`${to} Target.attachedToTarget`, ({ sessionId: worker }) => {
        workers.push(worker);
        attach(worker);
      });
      await this.ask("Target.setAutoAttach", { autoAttach: true, waitForDebuggerOnStart: false, flatten: true }, to).catch(() => {});
    };
    await attach(sessionId);
    await sleep(1000);
    const all = [...workers];
    const each = (method) => Promise.all(all.map((worker) => this.ask(`Profiler.${method}`, {}, worker)));
    await each("enable");
    await each("start");
    await sleep(1000 * seconds);
    return (await each("stop")).map(({ profile: { nodes } }) => {
      const samples = new Map();
      let count = 0;
      for (const { callFrame, hitCount } of nodes) {
        samples.set(callFrame.functionName, (samples.get(callFrame.functionName) ?? 0) + hitCount);
        count += hitCount;
      }
      return [...samples].map(([name, hits]) => [name, hits / count]).sort((a, b) => b[1] - a[1]);
    });
  }
  async page(url, width, height) {
    const { targetId } = await this.ask("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await this.ask("Target.attachToTarget", { targetId, flatten: true });
    const ask = (method, params) => this.ask(method, params, sessionId);
    await ask("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: width < 500 });
    await ask("Page.enable");
    const requests = [];
    this.listeners.set(`${sessionId} Network.requestWillBeSent`, ({ request }) => requests.push(request.url));
    await ask("Network.enable");
    const page = {
      ask,
      async value(expression) {
        const { result, exceptionDetails } = await ask("Runtime.evaluate", {
          expression, awaitPromise: true, returnByValue: true, userGesture: true,
        });
        if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
        return result.value;
      },
      goTo: (to) => ask("Page.navigate", { url: to }),
      reload: () => ask("Page.reload"),
      screenshot: async () => Buffer.from((await ask("Page.captureScreenshot", { format: "png" })).data, "base64"),
      // A file of the disk, as if it were chosen.
      async choose(selector, file) {
        const { root } = await ask("DOM.getDocument");
        const { nodeId } = await ask("DOM.querySelector", { nodeId: root.nodeId, selector });
        await ask("DOM.setFileInputFiles", { nodeId, files: [file] });
      },
      requests: async () => requests,
      profile: (seconds) => this.profile(sessionId, seconds),
      close: () => this.ask("Target.closeTarget", { targetId }),
    };
    await page.goTo(url);
    return page;
  }
}

export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
// Waits for a test that holds; it may throw.
export async function until(what, test, seconds = 20) {
  for (let i = 0; i < 10 * seconds; ++i) {
    if (await test()) return;
    await sleep(100);
  }
  throw new Error(`not within ${seconds} s: ${what}`);
}
