// A static scene of splats on the thread that calls it, seen by a camera that orbits.
import { bytesOf, CosplatError, loadCodecs, loadModule } from "./module.js";

// Whether the module may need the page's decoders for it: a ZIP archive (SOG), or SPZ without gzip.
function isPacked(bytes) {
  const text = String.fromCharCode(...bytes.subarray(0, 4));
  return text === "NGSP" || text.startsWith("PK");
}

// source: a .ply (3DGS's layout, PlayCanvas's compressed one), .spz, .sog (a bundle), .splat or .glb; a URL, a
// Blob, an ArrayBuffer or a Uint8Array. options: those of loadModule. Throws CosplatError.
export async function openScene(source, options = {}) {
  const file = await bytesOf(source, "splats");
  const memory = await loadModule(options);
  if (isPacked(file.bytes)) memory.module.codecs = await loadCodecs(options);
  return new Scene(memory, file);
}

export class Scene {
  constructor(memory, file) {
    this.memory = memory;
    this.module = memory.module;
    const handle = memory.withFile(file, (path) =>
      memory.withText(path, (name) => this.module._cosplat_scene_open(name)),
    );
    if (!handle) throw this.error();
    this.handle = handle;
  }

  get threads() {
    return this.memory.threads;
  }
  error() {
    return new CosplatError(this.memory.structs.text(this.module._cosplat_scene_error()), "bad file");
  }
  info() {
    return { gaussianCount: this.module._cosplat_scene_count(this.handle) };
  }

  // Radians.
  orbit(right, up) {
    this.module._cosplat_scene_orbit(this.handle, right, up);
  }
  // Fractions of the picture's height.
  pan(right, down) {
    this.module._cosplat_scene_pan(this.handle, right, down);
  }
  // Each step comes a tenth nearer.
  zoom(steps) {
    this.module._cosplat_scene_zoom(this.handle, steps);
  }
  resetCamera() {
    this.module._cosplat_scene_reset(this.handle);
  }

  // As Avatar.render.
  render(width, height, options = {}, out = undefined) {
    return this.memory.picture(width, height, options, out, (picture) => {
      if (!this.module._cosplat_scene_render(this.handle, picture)) throw this.error();
    });
  }

  // As Avatar.splats, by the orbiting camera at this size.
  splats(width, height, blurVariance, out = undefined) {
    const at = this.memory.structs.clear("cosplat_splats");
    if (!this.module._cosplat_scene_splats(this.handle, width, height, blurVariance, at)) throw this.error();
    return this.memory.splats(out);
  }

  close() {
    this.module._cosplat_scene_close(this.handle);
    this.handle = 0;
  }
}
