// Loads a module of dist/ and gives files and memory to it.
import { heap, Structs } from "./structs.js";

// What is wrong, in one line that names file, field and value. `status` is that of cosplat.h.
export class CosplatError extends Error {
  constructor(message, status = "") {
    super(message);
    this.name = "CosplatError";
    this.status = status;
  }
}

// Whether the page may use threads: it is cross-origin isolated, and the module's own worker, which
// must be of the page's origin, can be started.
export function threadsAvailable(base = import.meta.url) {
  return (
    globalThis.crossOriginIsolated === true &&
    typeof SharedArrayBuffer === "function" &&
    new URL(base).origin === globalThis.location?.origin
  );
}

const MAX_THREADS = 16;  // more gain nothing: a picture of 512x512 has 1024 tiles, most of them small

// The bytes of a URL, a Blob, an ArrayBuffer or a Uint8Array, with a name for messages.
export async function bytesOf(source, what) {
  if (source instanceof Uint8Array) return { name: what, bytes: source };
  if (source instanceof ArrayBuffer) return { name: what, bytes: new Uint8Array(source) };
  if (source instanceof Blob)
    return { name: source.name ?? what, bytes: new Uint8Array(await source.arrayBuffer()) };
  if (!source) throw new CosplatError(`${what}: is missing`, "file");
  const url = new URL(source, globalThis.location?.href);
  const name = url.protocol === "data:" ? what : decodeURIComponent(url.pathname.split("/").pop()) || what;
  let response;
  try {
    response = await fetch(url);
  } catch (error) {
    throw new CosplatError(`${source}: cannot be loaded: ${error.message}`, "file");
  }
  if (!response.ok)
    throw new CosplatError(`${source}: cannot be loaded: HTTP ${response.status}`, "file");
  return { name, bytes: new Uint8Array(await response.arrayBuffer()) };
}

// options.threads: how many; by default one per core where threads are available, else 1.
// options.modules: the folder of the modules, if it is not ../dist/ beside this file.
// options.load: a function that gives the glue of one thread and its .wasm, in place of files
// (the offline page).
export async function loadModule({ threads, modules, load } = {}) {
  const most = !load && threadsAvailable() ? navigator.hardwareConcurrency : 1;
  const count = Math.max(1, Math.min(threads ?? most, most, MAX_THREADS));
  const name = count > 1 ? "player-threads" : "player";
  const base = load ? null : new URL(modules ?? "../dist/", import.meta.url);
  const lines = [];  // bytes that the drive "stdin:" has not read yet
  let at = 0;
  const module = {
    threads: count - 1,
    locateFile: (file) => (load ? file : new URL(file, base).href),
    stdin: () => {
      if (lines.length === 0) return undefined;  // nothing yet
      const byte = lines[0][at++];
      if (at === lines[0].length) {
        lines.shift();
        at = 0;
      }
      return byte;
    },
    print: () => {},
    printErr: (text) => console.error(`cosplat: ${text}`),
  };
  try {
    const loaded = load ? await load() : { glue: await import(new URL(`${name}.mjs`, base).href) };
    if (loaded.wasm) module.wasmBinary = loaded.wasm;
    const instance = await loaded.glue.default(module);
    instance._cosplat_web_use_threads(count);
    return new Memory(instance, count, lines);
  } catch (error) {
    throw new CosplatError(`${name}.wasm: cannot be started: ${error.message ?? error}`);
  }
}

// Decoders of dist/, for `codecs` of a module; none in a page of one file, which has not got them.
export async function loadCodecs({ modules, load } = {}) {
  if (load) return undefined;
  const url = new URL("codecs.mjs", new URL(modules ?? "../dist/", import.meta.url)).href;
  try {
    return await (await import(url)).loadCodecs();
  } catch (error) {
    throw new CosplatError(`codecs.mjs: cannot be started: ${error.message ?? error}`);
  }
}

export class Memory {
  constructor(module, threads, lines) {
    this.module = module;
    this.threads = threads;
    this.lines = lines;
    this.structs = new Structs(module);
    this.pixels = { pointer: 0, bytes: 0 };
  }

  // Calls use(path) with a file of these bytes.
  withFile({ name, bytes }, use) {
    let path = name.replaceAll("/", "_");
    while (this.module.FS.analyzePath(path).exists) path = `_${path}`;
    this.module.FS.writeFile(path, bytes);
    try {
      return use(path);
    } finally {
      this.module.FS.unlink(path);
    }
  }

  // Calls use(pointer) with a zero-terminated copy of a text, or 0 for null.
  withText(text, use) {
    if (text === null) return use(0);
    const bytes = new TextEncoder().encode(`${text}\0`);
    const pointer = this.module._malloc(bytes.length);
    heap(this.module).set(bytes, pointer);
    try {
      return use(pointer);
    } finally {
      this.module._free(pointer);
    }
  }

  // Room for a picture's bytes, kept for the next one.
  pictureMemory(bytes) {
    if (bytes > this.pixels.bytes) {
      this.module._free(this.pixels.pointer);
      this.pixels = { pointer: this.module._malloc(bytes), bytes };
      if (this.pixels.pointer === 0) {
        this.pixels.bytes = 0;
        throw new CosplatError("out of memory", "not enough memory");
      }
    }
    return this.pixels.pointer;
  }

  // Copies of the arrays of a cosplat_splats, into those of `out` if it has them, and its other fields.
  splats(out) {
    const splats = this.structs.read("cosplat_splats");
    const { buffer } = heap(this.module);
    for (const name of ["centers", "colors", "scales", "rotations"]) {
      const values = new Float32Array(buffer, splats[name], 4 * splats.count);
      splats[name] = out?.[name]?.length === values.length ? out[name] : new Float32Array(values.length);
      splats[name].set(values);
    }
    return splats;
  }

  // Fills `out`, or a new array, with the picture that draw(structure) makes: RGBA, top row first.
  picture(width, height, { alpha = "straight", background = [0, 0, 0] } = {}, out, draw) {
    const bytes = 4 * width * height;
    if (!(bytes > 0 && bytes <= 2 ** 28))
      throw new CosplatError(`picture.width, height: ${width}x${height}`, "bad argument");
    const names = ["straight", "premultiplied", "opaque"];
    if (!names.includes(alpha))
      throw new CosplatError(`picture.alpha: '${alpha}' is none of ${names.join(", ")}`, "bad argument");
    const pixels = this.pictureMemory(bytes);
    const values = { width, height, alpha: names.indexOf(alpha), background, pixels };
    draw(this.structs.fill("cosplat_picture", values));
    out ??= new Uint8ClampedArray(bytes);
    out.set(heap(this.module).subarray(pixels, pixels + bytes));
    return out;
  }
}
