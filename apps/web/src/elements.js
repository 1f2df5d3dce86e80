// <cosplat-avatar src flame camera drive background resolution renderer> and
// <cosplat-splats src background resolution renderer>.
//
// Events: "load" (detail: what is open), "error" (message, in one line), "stats" (detail, once a second
// while pictures change), "drive" (detail: "connected" or "lost"), "renderer" (detail: {renderer: "cpu"
// or "gpu"} and, if they were measured, {cpu, gpu}, milliseconds of a picture).
import { drawOnce, fasterRenderer, gpuRenderer, outgrown, timeRenderers } from "./gpu.js";
import { CosplatError } from "./module.js";
import { RemoteAvatar, RemoteScene } from "./remote.js";

const MAX_SIDE = 4096;  // px
const MAX_ELEVATION = 1.5;  // radians; as cosplat_orbit_camera
const RADIANS = Math.PI / 180;
const TURN_PER_PX = 0.01;  // radians per pixel of a drag
const QUIET_MS = 500;  // without a change of size, until the renderers are measured again
const RETRY_MS = [500, 1000, 2000, 5000];  // between attempts to reach a lost socket

const style = `:host { display: block; aspect-ratio: 1; overflow: hidden; touch-action: none; }
canvas { display: block; width: 100% !important; height: 100% !important; }
canvas[hidden] { display: none; }`;

// "#rrggbb" as [r, g, b] from 0 to 1; null for "" and "transparent".
function colorOf(text) {
  if (!text || text === "transparent") return null;
  const digits = /^#([0-9a-f]{6})$/i.exec(text)?.[1];
  if (!digits) throw new CosplatError(`background: '${text}' is neither #rrggbb nor transparent`);
  return [0, 2, 4].map((at) => parseInt(digits.slice(at, at + 2), 16) / 255);
}

class SplatElement extends HTMLElement {
  // Set by configure(): options for every player of the page, as of openAvatar.
  static options = {};

  constructor() {
    super();
    this.attachShadow({ mode: "open" });
    this.generation = 0;  // of opening; what belongs to an earlier one is ignored
    this.remote = null;
    this.drawing = "cpu";  // or "gpu"
    this.gpu = null;  // the page's renderer, while it is measured or draws
    this.choice = Promise.resolve();  // of one of them, one after the other
    this.measured = 0;  // pixels
    this.resizes = new ResizeObserver(() => this.resize());
    let from = null;
    this.addEventListener("pointerdown", (event) => {
      from = { x: event.clientX, y: event.clientY };
      this.setPointerCapture(event.pointerId);
    });
    this.addEventListener("pointermove", (event) => {
      if (!from || !this.remote) return;
      this.drag(event.clientX - from.x, event.clientY - from.y);
      from = { x: event.clientX, y: event.clientY };
    });
    for (const end of ["pointerup", "pointercancel"]) this.addEventListener(end, () => (from = null));
    this.addEventListener(
      "wheel",
      (event) => {
        if (!this.remote) return;
        event.preventDefault();
        this.scroll(-Math.sign(event.deltaY));
      },
      { passive: false },
    );
  }

  connectedCallback() {
    this.resizes.observe(this);
    this.reopen();
  }
  disconnectedCallback() {
    this.resizes.disconnect();
    this.shut();
  }

  // Attributes of one change open it once.
  reopen() {
    const generation = ++this.generation;
    queueMicrotask(async () => {
      if (generation !== this.generation || !this.isConnected) return;
      this.shut();
      ++this.generation;
      const mine = this.generation;
      this.canvas = document.createElement("canvas");
      this.shadowRoot.innerHTML = `<style>${style}</style>`;
      this.shadowRoot.append(this.canvas);
      try {
        const opened = await this.open(this.canvas.transferControlToOffscreen());
        if (mine !== this.generation) return opened.close();
        this.remote = opened;
        opened.addEventListener("error", ({ detail }) => this.report(detail));
        opened.addEventListener("stats", ({ detail }) =>
          this.dispatchEvent(new CustomEvent("stats", { detail })),
        );
        opened.addEventListener("splats", ({ detail }) => this.drawSplats(opened, detail));
        this.resize();
        this.showBackground();
        await this.opened();
        if (mine !== this.generation) return;
        this.dispatchEvent(new CustomEvent("load", { detail: opened.properties }));
        this.chooseRenderer();
      } catch (error) {
        if (mine === this.generation) this.report(error);
      }
    });
  }
  shut() {
    ++this.generation;
    this.remote?.close();
    this.remote = null;
    this.closeGpu();
  }
  async opened() {}

  // By the attribute renderer: "cpu", "gpu", or the one that is measured to be faster.
  chooseRenderer() {
    const generation = this.generation;
    const stale = () => generation !== this.generation || !this.remote;
    const choose = async () => {
      if (stale()) return;
      const wanted = this.getAttribute("renderer") ?? "auto";
      const detail = { renderer: wanted === "gpu" ? "gpu" : "cpu" };
      try {
        if (!["auto", "cpu", "gpu"].includes(wanted))
          throw new CosplatError(`renderer: '${wanted}' is none of auto, cpu, gpu`);
        if (wanted === "gpu" && !gpuRenderer())
          throw new CosplatError("renderer: 'gpu' needs a splat renderer of the page's, such as usePlayCanvas gives");
        if (wanted !== "cpu" && gpuRenderer()) {
          await this.openGpu();
          if (stale()) return;
          if (wanted === "auto") {
            this.measured = this.pixels();
            const times = await timeRenderers(this.remote, this.gpu);
            if (stale()) return;
            Object.assign(detail, { renderer: fasterRenderer(this.drawing, times), ...times });
          } else {
            await drawOnce(this.remote, this.gpu);  // before its canvas is shown
            if (stale()) return;
          }
        }
      } catch (error) {
        if (stale()) return;
        detail.renderer = "cpu";
        this.report(error);
      }
      this.useRenderer(detail.renderer);
      this.dispatchEvent(new CustomEvent("renderer", { detail }));
    };
    this.choice = this.choice.then(choose);
  }
  useRenderer(renderer) {
    this.drawing = renderer;
    if (renderer === "cpu") this.closeGpu();
    else this.gpu.canvas.hidden = false;
    this.canvas.hidden = renderer === "gpu";
    this.remote.setView({ renderer, blurVariance: this.gpu?.blurVariance ?? 0 });
  }
  async openGpu() {
    if (this.gpu) return;
    const canvas = document.createElement("canvas");
    canvas.hidden = true;
    this.shadowRoot.append(canvas);
    const gpu = await gpuRenderer()(canvas);
    if (!canvas.isConnected) return gpu.close();
    this.gpu = gpu;
    gpu.canvas = canvas;
    gpu.addEventListener("lost", () => {
      if (gpu !== this.gpu) return;
      this.report({ message: "the GPU was lost, drawing on the CPU" });
      this.useRenderer("cpu");
    });
    this.showBackground();
  }
  closeGpu() {
    this.drawing = "cpu";
    this.gpu?.canvas.remove();
    this.gpu?.close();
    this.gpu = null;
  }
  async drawSplats(remote, splats) {
    if (remote !== this.remote || this.drawing !== "gpu") return;
    try {
      remote.shown(splats, await this.gpu.draw(splats));
    } catch (error) {
      if (remote === this.remote && this.drawing === "gpu") this.report(error);
    }
  }

  report({ message }) {
    this.dispatchEvent(new ErrorEvent("error", { message }));
  }

  size() {
    const scale = Number(this.getAttribute("resolution") ?? 1) || 1;
    const side = (length) => Math.min(MAX_SIDE, Math.max(1, Math.round(length * scale)));
    return { width: side(this.clientWidth), height: side(this.clientHeight) };
  }
  pixels() {
    const { width, height } = this.size();
    return width * height;
  }
  resize() {
    this.remote?.setView(this.size());
    clearTimeout(this.quiet);
    if (this.measured > 0 && outgrown(this.measured, this.pixels()))
      this.quiet = setTimeout(() => this.chooseRenderer(), QUIET_MS);
  }
  showBackground() {
    try {
      const text = this.getAttribute("background");
      this.remote?.setView({ background: colorOf(text) });
      if (this.gpu) this.gpu.canvas.style.background = text ?? "";
    } catch (error) {
      this.report(error);
    }
  }

  attributeChangedCallback(name, before, after) {
    if (before === after || !this.isConnected) return;
    if (name === "resolution") this.resize();
    else if (name === "background") this.showBackground();
    else if (name === "renderer") this.chooseRenderer();
    else if (!this.remote || ["src", "flame", "bust", "threads"].includes(name)) this.reopen();
    else this.changed(name);
  }
  options() {
    const threads = this.getAttribute("threads");
    return { ...SplatElement.options, ...(threads ? { threads: Number(threads) } : {}) };
  }
}

export class AvatarElement extends SplatElement {
  static observedAttributes = ["src", "flame", "bust", "threads", "camera", "drive", "background", "resolution", "renderer"];

  constructor() {
    super();
    this.socket = null;
    this.onMessage = ({ data }) => {
      if (data?.cosplat) this.send(data.cosplat);
    };
  }

  open(canvas) {
    const options = { ...this.options(), canvas, bust: this.getAttribute("bust") ?? "follows" };
    return RemoteAvatar.open(this.sources?.src ?? this.getAttribute("src"), this.sources?.flame ?? this.getAttribute("flame"), options);
  }
  // Bytes or Blobs in place of the attributes src and flame.
  load(src, flame) {
    this.sources = { src, flame };
    this.reopen();
  }
  opened() {
    this.readCamera();
    return this.openDrive(this.getAttribute("drive"));
  }
  changed(name) {
    if (name === "camera") this.readCamera();
    if (name === "drive") this.openDrive(this.getAttribute("drive"));
  }

  // "azimuth elevation zoom", angles in degrees.
  readCamera() {
    const [azimuth = 0, elevation = 0, zoom = 1] = (this.getAttribute("camera") ?? "")
      .split(/[\s,]+/)
      .filter(Boolean)
      .map(Number);
    if (![azimuth, elevation, zoom].every(Number.isFinite))
      return this.report({ message: `camera: '${this.getAttribute("camera")}' is not AZIMUTH ELEVATION ZOOM` });
    this.look({ azimuth: azimuth * RADIANS, elevation: elevation * RADIANS, zoom });
  }
  // Radians.
  look(orbit) {
    this.orbit = orbit;
    this.remote?.setView({ orbit });
  }
  drag(right, down) {
    const elevation = this.orbit.elevation + TURN_PER_PX * down;
    this.look({
      ...this.orbit,
      azimuth: this.orbit.azimuth - TURN_PER_PX * right,
      elevation: Math.max(-MAX_ELEVATION, Math.min(MAX_ELEVATION, elevation)),
    });
  }
  scroll(steps) {
    this.look({ ...this.orbit, zoom: Math.max(0.1, Math.min(20, this.orbit.zoom * 1.1 ** steps)) });
  }

  // "ws://..." or "wss://...": frames as its messages; "events:URL": as server-sent events; "message": as {cosplat: FRAME} posted to the
  // window; "frames": by send(); else the address of a recording. What a frame is: docs/live-input.md.
  async openDrive(drive) {
    this.closeDrive();
    try {
      const kind = drive === "message" || drive === "frames" || /^(wss?|events):/.test(drive ?? "") ? "frames" : drive;
      if (kind || this.driven) await this.remote.setDrive(kind || null);
      this.driven = Boolean(kind);
      if (drive === "message") window.addEventListener("message", this.onMessage);
      if (/^wss?:/.test(drive ?? "")) this.connect(drive, 0);
      if (/^events:/.test(drive ?? "")) this.listen(drive.slice("events:".length));
    } catch (error) {
      this.report(error);
    }
  }
  connect(address, attempt) {
    const socket = new WebSocket(address);
    this.socket = socket;
    socket.onopen = () => {
      attempt = 0;
      this.dispatchEvent(new CustomEvent("drive", { detail: "connected" }));
    };
    socket.onmessage = ({ data }) => this.send(data);
    socket.onclose = ({ code }) => {
      if (socket !== this.socket) return;
      this.report({ message: `${address}: the connection was lost (code ${code}), trying again` });
      this.dispatchEvent(new CustomEvent("drive", { detail: "lost" }));
      const wait = RETRY_MS[Math.min(attempt, RETRY_MS.length - 1)];
      setTimeout(() => socket === this.socket && this.connect(address, attempt + 1), wait);
    };
  }
  // Browsers try again by themselves.
  listen(address) {
    const events = new EventSource(new URL(address, document.baseURI));
    this.socket = events;
    events.onopen = () => this.dispatchEvent(new CustomEvent("drive", { detail: "connected" }));
    events.onmessage = ({ data }) => this.send(data);
    events.onerror = () => {
      if (events !== this.socket) return;
      this.report({ message: `${address}: the connection was lost, trying again` });
      this.dispatchEvent(new CustomEvent("drive", { detail: "lost" }));
    };
  }
  closeDrive() {
    const socket = this.socket;
    this.socket = null;
    socket?.close();
    window.removeEventListener("message", this.onMessage);
  }
  shut() {
    this.closeDrive();
    super.shut();
    this.driven = false;
  }

  setParameters(parameters) {
    this.remote?.setParameters(parameters);
  }
  resetParameters() {
    this.remote?.resetParameters();
  }
  send(frame) {
    this.remote?.send(frame);
  }
  setPolicy(policy) {
    return this.remote?.setPolicy(policy);
  }
  health() {
    return this.remote?.health();
  }
}

export class SplatsElement extends SplatElement {
  static observedAttributes = ["src", "threads", "background", "resolution", "renderer"];

  open(canvas) {
    return RemoteScene.open(this.sources?.src ?? this.getAttribute("src"), { ...this.options(), canvas });
  }
  load(src) {
    this.sources = { src };
    this.reopen();
  }
  drag(right, down) {
    this.remote.orbit(-TURN_PER_PX * right, TURN_PER_PX * down);
  }
  scroll(steps) {
    this.remote.zoom(steps);
  }
}

// Options for every element of the page, as of openAvatar; before the first is shown.
export function configure(options) {
  SplatElement.options = options;
}

customElements.define("cosplat-avatar", AvatarElement);
customElements.define("cosplat-splats", SplatsElement);
