// PlayCanvas' engine.
import * as pc from "playcanvas";
import { SpzParser } from "playcanvas/scripts/esm/parsers/spz-parser.mjs";

import { far, near, placed, projection, turnedUp } from "./camera.js";

async function load(app, type, url) {
  const asset = new pc.Asset(url, type, { url });
  app.assets.add(asset);
  await new Promise((resolve, reject) => {
    asset.once("load", resolve);
    asset.once("error", (message) => reject(new Error(message)));
    app.assets.load(asset);
  });
  return asset;
}

export async function open(job) {
  const device = await pc.createGraphicsDevice(job.canvas, {
    deviceTypes: ["webgl2"], antialias: false, alpha: false, preserveDrawingBuffer: true,
  });
  device.maxPixelRatio = 1;
  const options = new pc.AppOptions();
  options.graphicsDevice = device;
  options.componentSystems = [
    pc.CameraComponentSystem, pc.GSplatComponentSystem, pc.RenderComponentSystem,
    pc.LightComponentSystem,
  ];
  options.resourceHandlers = [pc.GSplatHandler, pc.ContainerHandler, pc.TextureHandler];
  const app = new pc.AppBase(job.canvas);
  app.init(options);
  app.setCanvasFillMode(pc.FILLMODE_NONE);
  app.setCanvasResolution(pc.RESOLUTION_FIXED, job.width, job.height);
  app.start();
  pc.WasmModule.setConfig("ZstdDecoderModule", {
    glueUrl: "/page/zstd_glue.js", wasmUrl: "/page/zstd_glue.js",
  });
  app.loader.getHandler("gsplat").addParser(new SpzParser(app));

  // The engine projects to pixels of half the size before it adds 0.3 of their area, a quarter of what
  // 3DGS trains with.
  if (job.blur === "trained") {
    const chunks = pc.ShaderChunks.get(device, pc.SHADERLANGUAGE_GLSL);
    const corner = chunks.get("gsplatCornerVS");
    chunks.set("gsplatCornerVS", corner.replaceAll("+ 0.3", "+ 1.2"));
  }

  const camera = new pc.Entity("camera");
  camera.addComponent("camera", {
    clearColor: new pc.Color(0, 0, 0, 1), nearClip: near, farClip: far,
    toneMapping: pc.TONEMAP_NONE, gammaCorrection: pc.GAMMA_SRGB,
  });
  app.root.addChild(camera);

  if (job.format === "glb") {
    const asset = await load(app, "container", job.url);
    app.root.addChild(asset.resource.instantiateRenderEntity());
  } else {
    const asset = await load(app, "gsplat", job.url);
    const entity = new pc.Entity("splats");
    entity.addComponent("gsplat", { asset });
    app.root.addChild(entity);
  }
  const signs = job.format === "spz" || job.format === "glb" ? turnedUp : [1, 1, 1];
  return {
    canvas: job.canvas,
    look: (view) => {
      const { position, right, up, back } = placed(view, signs);
      const world = new pc.Mat4();
      world.data.set([...right, 0, ...up, 0, ...back, 0, ...position, 1]);
      camera.setPosition(...position);
      camera.setRotation(new pc.Quat().setFromMat4(world));
      camera.camera.calculateProjection = (matrix) =>
        matrix.data.set(projection(view, near, far));
    },
    // It draws by itself, once per frame.
    draw: () => new Promise((resolve) => app.once("postrender", resolve)),
  };
}
