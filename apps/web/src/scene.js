// A static scene of splats on the thread that calls it, seen by a camera that orbits.
import { bytesOf, CosplatError, loadModule } from "./module.js";

// source: a .ply (3DGS's layout, PlayCanvas's compressed one) or one of `cosplat export --vq`; a URL,
// a Blob, an ArrayBuffer or a Uint8Array. options: those of loadModule. Throws CosplatError.
export async function openScene(source, options = {}) {
  const file = await bytesOf(source, "splats");
  return new Scene(await loadModule(options), file);
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

  close() {
    this.module._cosplat_scene_close(this.handle);
    this.handle = 0;
  }
}
