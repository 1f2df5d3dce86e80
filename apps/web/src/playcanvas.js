// PlayCanvas' engine draws the splats of each frame on the GPU, by WebGPU or WebGL 2:
//
//   import * as playcanvas from "playcanvas";
//   import { usePlayCanvas } from "cosplat-player/playcanvas";
//   usePlayCanvas(playcanvas);
//
// Before the first element is shown. The engine is the page's own; tested with 2.23.
import { setGpuRenderer } from "./gpu.js";

// px^2. The engine projects to half pixels and adds 0.3 of their area to a footprint's variances, 3DGS
// trains with 0.3 px^2; FillViewSplats (splat/render/view_splats.h) adds the difference.
const BLUR_VARIANCE = 0.3 - 0.3 / 4;
// Of the picture's farthest splat, whatever the unit. What is too near is left out by FillViewSplats.
const NEAR = 1e-6;
const FAR = 2;
const STREAMS = { centers: "dataCenter", colors: "dataColor", scales: "dataScale", rotations: "dataRotation" };

// deviceTypes: as of createGraphicsDevice; those that the browser has not are passed over.
export function usePlayCanvas(playcanvas, { deviceTypes = ["webgpu", "webgl2"] } = {}) {
  setGpuRenderer((canvas) => PlayCanvasRenderer.open(playcanvas, canvas, deviceTypes));
}

// How the engine reads a splat of our arrays: functions of its shaders.
const read = (header, four, three) =>
  ["Center", "Color", "Scale", "Rotation"]
    .map((name) => {
      const all = name === "Color" || name === "Rotation";
      return header(all ? four : three, `get${name}`, `loadData${name}()${all ? "" : ".xyz"}`);
    })
    .join("\n");
const READ = {
  readGLSL: read((type, name, value) => `${type} ${name}() { return ${value}; }`, "vec4", "vec3"),
  readWGSL: read((type, name, value) => `fn ${name}() -> ${type} { return ${value}; }`, "vec4f", "vec3f"),
};

class PlayCanvasRenderer extends EventTarget {
  static async open(pc, canvas, deviceTypes) {
    const options = { deviceTypes: [...deviceTypes], antialias: false, alpha: true, depth: false, stencil: false };
    return new PlayCanvasRenderer(pc, canvas, await pc.createGraphicsDevice(canvas, options));
  }

  constructor(pc, canvas, device) {
    super();
    this.pc = pc;
    this.canvas = canvas;
    this.device = device;
    this.blurVariance = BLUR_VARIANCE;
    this.container = null;
    this.farthest = 1;
    device.maxPixelRatio = 1;
    this.lost = new Promise((resolve, reject) =>
      device.on("devicelost", () => {
        this.dispatchEvent(new Event("lost"));
        reject(new Error("the GPU was lost"));
      }),
    );
    this.lost.catch(() => {});  // nobody may be waiting
    const options = new pc.AppOptions();
    options.graphicsDevice = device;
    options.componentSystems = [pc.CameraComponentSystem, pc.GSplatComponentSystem];
    options.resourceHandlers = [];
    this.app = new pc.AppBase(canvas);
    this.app.init(options);
    this.app.setCanvasFillMode(pc.FILLMODE_NONE);
    this.app.autoRender = false;
    // A picture is drawn in the order of the one before if its splats are not sorted yet; then it is
    // drawn again.
    this.ready = false;
    const { gsplat: system } = this.app.systems;
    system.on("frame:request", () => (this.app.renderNextFrame = true));
    system.on("frame:ready", (camera, layer, ready) => (this.ready = ready));
    const { gsplat } = this.app.scene;
    gsplat.dataFormat = pc.GSPLATDATA_LARGE;  // halves for colours, where it has a few bits otherwise
    gsplat.minPixelSize = 0;
    gsplat.minContribution = 0;
    this.camera = new pc.Entity("camera");
    this.camera.addComponent("camera", {
      clearColor: new pc.Color(0, 0, 0, 0),
      toneMapping: pc.TONEMAP_NONE, gammaCorrection: pc.GAMMA_SRGB,
    });
    this.camera.camera.calculateProjection = (matrix) => matrix.data.set(projection(this.view, this.farthest));
    this.app.root.addChild(this.camera);
    this.app.start();
  }

  // splats: of Avatar.splats. Resolves once they are on the canvas, in the task that drew them, to the
  // milliseconds that it took; finish: with those of the GPU.
  async draw(splats, { finish = false } = {}) {
    const begin = performance.now();
    this.look(splats);
    const first = this.container?.maxSplats !== splats.count;
    if (first) this.hold(splats.count);
    this.fill(splats);
    const filled = performance.now() - begin;
    let drawn = await this.render(finish);
    // Of new splats the first picture has no order; by WebGPU that of each update leaves most of
    // them out (2.23.3 in Chromium 156: a second one has all).
    if (first || this.device.isWebGPU)
      do drawn = await this.render(finish);
      while (!this.ready);
    return filled + drawn;
  }
  render(finish) {
    let begin = 0;
    this.app.renderNextFrame = true;
    this.app.once("prerender", () => (begin = performance.now()));
    const drawn = new Promise((resolve) =>
      this.app.once("postrender", () => {
        if (finish) this.finish();
        resolve(performance.now() - begin);
      }),
    );
    return Promise.race([drawn, this.lost]);
  }

  look(view) {
    const { width, height, camFromWorld: m } = view;
    this.view = view;
    if (this.canvas.width !== width || this.canvas.height !== height)
      this.app.setCanvasResolution(this.pc.RESOLUTION_FIXED, width, height);
    // Rows of the rotation are the camera's axes: right, down, forward.
    const axis = (row, sign) => [0, 1, 2].map((k) => sign * m[4 * row + k]);
    const position = [0, 1, 2].map((k) => -(m[k] * m[3] + m[4 + k] * m[7] + m[8 + k] * m[11]));
    const world = new this.pc.Mat4();
    world.data.set([...axis(0, 1), 0, ...axis(1, -1), 0, ...axis(2, -1), 0, ...position, 1]);
    this.camera.setPosition(...position);
    this.camera.setRotation(new this.pc.Quat().setFromMat4(world));
  }

  fill(splats) {
    const { pc } = this;
    for (const [name, stream] of Object.entries(STREAMS)) {
      const texture = this.container.getTexture(stream);
      texture.lock().set(splats[name]);
      texture.unlock();
    }
    // Sorting needs points by themselves, and their box, which it divides into steps of depth.
    const points = this.container.centers;
    const least = [Infinity, Infinity, Infinity];
    const most = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < splats.count; ++i)
      for (let k = 0; k < 3; ++k) {
        const value = splats.centers[4 * i + k];
        points[3 * i + k] = value;
        if (value < least[k]) least[k] = value;
        if (value > most[k]) most[k] = value;
      }
    this.farthest = farthestDepth(this.view.camFromWorld, least, most);
    this.camera.camera.nearClip = NEAR * this.farthest;
    this.camera.camera.farClip = FAR * this.farthest;
    this.container.aabb.setMinMax(new pc.Vec3(least), new pc.Vec3(most));
    this.container.update(splats.count);
  }

  hold(count) {
    const { pc, device } = this;
    this.entity?.destroy();
    this.container?.destroy();
    const streams = Object.values(STREAMS).map((name) => ({ name, format: pc.PIXELFORMAT_RGBA32F }));
    this.container = new pc.GSplatContainer(device, count, new pc.GSplatFormat(device, streams, READ));
    this.container.aabb = new pc.BoundingBox();
    this.entity = new pc.Entity("splats");
    this.entity.addComponent("gsplat", { resource: this.container, unified: true });
    // In every picture: an update "once" is lost if an order arrives with it (2.23).
    this.entity.gsplat.workBufferUpdate = pc.WORKBUFFER_UPDATE_ALWAYS;
    this.app.root.addChild(this.entity);
  }

  // Reading a pixel waits for the GPU, whichever interface draws.
  finish() {
    this.reader ??= new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    this.reader.drawImage(this.canvas, 0, 0, 1, 1);
    this.reader.getImageData(0, 0, 1, 1);
  }

  close() {
    this.app.destroy();
  }
}

// Of a box, > 0.
function farthestDepth(m, least, most) {
  let depth = m[11];
  for (let k = 0; k < 3; ++k) depth += Math.max(m[8 + k] * least[k], m[8 + k] * most[k]);
  return depth > 0 ? depth : 1;
}

// OpenGL's, column-major.
function projection({ fx, fy, cx, cy, width, height }, farthest) {
  const near = NEAR * farthest, far = FAR * farthest;
  return [
    (2 * fx) / width, 0, 0, 0,
    0, (2 * fy) / height, 0, 0,
    1 - (2 * cx) / width, (2 * cy) / height - 1, (far + near) / (near - far), -1,
    0, 0, (2 * far * near) / (near - far), 0,
  ];
}
