// Pages of Firefox by Marionette, over a socket: `LENGTH:[0, id, command, parameters]`, and
// `LENGTH:[1, id, error, result]` for an answer. It is to have a screen (Xvfb does): without one it has
// no WebGL.
import { spawn } from "node:child_process";
import fs from "node:fs";
import net from "node:net";
import path from "node:path";

import { until } from "./devtools.mjs";

const ports = "MarionetteActivePort";  // a file of the profile
const prefs = {
  "marionette.port": 0,
  // Nothing of the browser's own in the list of what a page asks for, and none of its windows before it.
  "browser.shell.checkDefaultBrowser": false,
  "browser.aboutwelcome.enabled": false,
  "datareporting.policy.dataSubmissionPolicyBypassNotification": true,
};
// In the browser's own context: what pages and their workers ask for, not what the browser does.
const listen = `
  globalThis.asked = [];
  globalThis.observer = { observe(channel) {
    const { loadInfo, URI } = channel.QueryInterface(Ci.nsIHttpChannel);
    if (!loadInfo.triggeringPrincipal.isSystemPrincipal) asked.push(URI.spec);
  } };
  Services.obs.addObserver(observer, "http-on-modify-request");`;
// In the page's own realm: Marionette's scripts have a sandbox.
const evaluate = `const [expression, done] = arguments;
  Promise.resolve(window.eval(expression)).then((value) => done({ value }), (error) => done({ error: String(error?.stack ?? error) }));`;

export class Firefox {
  // downloads: a folder.
  static async start({ firefox, profile, children, downloads }) {
    fs.mkdirSync(profile, { recursive: true });
    const all = { ...prefs, "browser.download.folderList": 2, "browser.download.dir": downloads };
    const text = Object.entries(all).map(([name, value]) => `user_pref(${JSON.stringify(name)}, ${JSON.stringify(value)});\n`);
    fs.writeFileSync(path.join(profile, "user.js"), text.join(""));
    const flags = ["--no-remote", "--profile", profile, "--marionette", "--remote-allow-system-access"];
    children.push(spawn(firefox, flags, { stdio: "ignore" }));
    const port = () => Number(fs.readFileSync(path.join(profile, ports), "utf8"));
    await until("Firefox listens", () => fs.existsSync(path.join(profile, ports)) && port() > 0, 60);
    const self = new Firefox(net.connect(port(), "127.0.0.1"));
    await self.ask("WebDriver:NewSession", { capabilities: { alwaysMatch: { timeouts: { script: 600000 } } } });
    self.home = self.tab = await self.ask("WebDriver:GetWindowHandle").then(({ value }) => value);
    await self.inBrowser(listen);
    return self;
  }
  constructor(socket) {
    this.count = 0;
    this.answers = new Map();
    this.queue = Promise.resolve();
    this.socket = socket;
    let rest = Buffer.alloc(0);
    socket.on("data", (data) => {
      rest = Buffer.concat([rest, data]);
      for (;;) {
        const colon = rest.indexOf(":");
        if (colon < 0) return;
        const end = colon + 1 + Number(rest.subarray(0, colon));
        if (rest.length < end) return;
        this.receive(JSON.parse(rest.subarray(colon + 1, end)));
        rest = rest.subarray(end);
      }
    });
  }
  receive(message) {
    if (!Array.isArray(message)) return;  // its greeting
    const [, id, error, result] = message;
    const answer = this.answers.get(id);
    this.answers.delete(id);
    if (error) answer?.reject(new Error(`${error.error}: ${error.message}`));
    else answer?.resolve(result);
  }
  ask(command, parameters = {}) {
    const id = ++this.count, text = JSON.stringify([0, id, command, parameters]);
    this.socket.write(`${Buffer.byteLength(text)}:${text}`);
    return new Promise((resolve, reject) => this.answers.set(id, { resolve, reject }));
  }
  // In a row: commands go to the tab that was switched to.
  inTurn(use) {
    const turn = this.queue.then(use);
    this.queue = turn.catch(() => {});
    return turn;
  }
  inBrowser(script) {
    return this.inTurn(async () => {
      await this.ask("Marionette:SetContext", { value: "chrome" });
      const { value } = await this.ask("WebDriver:ExecuteScript", { script, args: [], newSandbox: false, sandbox: "system" });
      await this.ask("Marionette:SetContext", { value: "content" });
      return value;
    });
  }
  async page(url, width, height) {
    const { handle } = await this.inTurn(() => this.ask("WebDriver:NewWindow", { type: "tab" }));
    const ask = (method, params) =>
      this.inTurn(async () => {
        if (this.tab !== handle) await this.ask("WebDriver:SwitchToWindow", { handle });
        this.tab = handle;
        return this.ask(method, params);
      });
    await ask("WebDriver:SetWindowRect", { width, height });
    const page = {
      ask,
      async value(expression) {
        const { value } = await ask("WebDriver:ExecuteAsyncScript", { script: evaluate, args: [expression] });
        if (value.error) throw new Error(value.error);
        return value.value;
      },
      goTo: (to) => ask("WebDriver:Navigate", { url: to }),
      // Not Marionette's, which passes a service worker by.
      reload: () => page.value("void location.reload()"),
      screenshot: async () => Buffer.from((await ask("WebDriver:TakeScreenshot", { full: false })).value, "base64"),
      async choose(selector, file) {
        const { value } = await ask("WebDriver:FindElement", { using: "css selector", value: selector });
        await ask("WebDriver:ElementSendKeys", { id: Object.values(value)[0], text: file });
      },
      requests: () => this.inBrowser("return asked;"),
      close: () =>
        this.inTurn(async () => {
          if (this.tab !== handle) await this.ask("WebDriver:SwitchToWindow", { handle });
          await this.ask("WebDriver:CloseWindow");
          await this.ask("WebDriver:SwitchToWindow", { handle: (this.tab = this.home) });
        }),
    };
    await page.goTo(url);
    return page;
  }
}
