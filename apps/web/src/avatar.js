// An avatar on the thread that calls it: cosplat.h's verbs as an object. In a page that must stay
// responsive use the element or RemoteAvatar, which run this in a worker.
import { bytesOf, CosplatError, loadModule } from "./module.js";
import { heap } from "./structs.js";

const JOINTS = ["root", "neck", "jaw", "leftEye", "rightEye"];
const FACES = ["rest", "live", "decaying", "returning"];
const STATUS = [
  "ok", "bad argument", "not an open avatar", "in use", "not found", "not finite", "late", "bad file",
  "bad FLAME model", "no such device", "not enough memory", "internal fault", "bad drive",
];

// Milliseconds of performance.now() as cosplat.h's time.
const nanoseconds = (ms) => BigInt(Math.round(ms * 1e6));

// avatar: a .glb of `cosplat train-avatar`; flame: the FLAME model that it was trained with (.pkl or
// .npz), or nothing if that is in the .glb. Each a URL, a Blob, an ArrayBuffer or a Uint8Array. options: bust ("follows", "still"), and
// those of loadModule. Throws CosplatError.
export async function openAvatar(avatar, flame, options = {}) {
  const [file, model] = await Promise.all([
    bytesOf(avatar, "avatar.glb"),
    flame ? bytesOf(flame, "flame") : null,
  ]);
  return new Avatar(await loadModule(options), file, model, options);
}

// A FLAME model's kind is known by its extension; bytes without a name have none.
function named(model) {
  if (/\.(pkl|npz)$/.test(model.name)) return model;
  const zip = model.bytes[0] === 0x50 && model.bytes[1] === 0x4b;
  return { name: `${model.name}${zip ? ".npz" : ".pkl"}`, bytes: model.bytes };
}

export class Avatar {
  constructor(memory, file, model, { bust = "follows" } = {}) {
    this.memory = memory;
    this.module = memory.module;
    this.structs = memory.structs;
    this.handle = 0;
    this.expression = { pointer: 0, count: 0 };
    const out = this.module._malloc(4);
    const open = (path, flamePath) =>
      memory.withText(path, (name) =>
        memory.withText(flamePath, (flame) => {
          const busts = ["follows", "still"];
          const options = this.structs.fill("cosplat_open_options", {
            flamePath: flame,
            bust: Math.max(0, busts.indexOf(bust)),
          });
          this.check(this.module._cosplat_open(name, options, out));
        }),
      );
    try {
      memory.withFile(file, (path) =>
        model ? memory.withFile(named(model), (flame) => open(path, flame)) : open(path, null),
      );
      this.handle = new DataView(heap(this.module).buffer).getUint32(out, true);
    } finally {
      this.module._free(out);
    }
    this.rest = this.parameters();
  }

  get threads() {
    return this.memory.threads;
  }

  check(status) {
    if (status === 0) return;
    const text = this.structs.text(this.module._cosplat_last_error(this.handle));
    throw new CosplatError(text, STATUS[status] ?? String(status));
  }
  call(verb, ...numbers) {
    this.check(this.module[`_cosplat_${verb}`](this.handle, ...numbers));
  }
  query(verb, structure) {
    this.call(verb, this.structs.clear(structure));
    return this.structs.read(structure);
  }

  info() {
    return this.query("get_info", "cosplat_info");
  }

  // {expression, root, neck, jaw, leftEye, rightEye, translation, time}; what is not given is at
  // rest. time: milliseconds of performance.now().
  setParameters({ expression = [], translation, time = performance.now(), ...joints } = {}) {
    const values = { joints: this.rest.joints.slice(), translation: translation ?? this.rest.translation };
    for (const [name, turn] of Object.entries(joints)) {
      const joint = JOINTS.indexOf(name);
      if (joint < 0) throw new CosplatError(`joint: there is no '${name}'`, "not found");
      for (let k = 0; k < 3; ++k) values.joints[3 * joint + k] = turn[k];
    }
    this.reserveExpression(expression.length);
    new Float32Array(heap(this.module).buffer, this.expression.pointer, expression.length).set(expression);
    values.expression = this.expression.pointer;
    values.expressionCount = expression.length;
    values.timeNs = nanoseconds(time);
    this.call("set_parameters", this.structs.fill("cosplat_parameters", values));
  }
  reserveExpression(count) {
    if (count <= this.expression.count && this.expression.pointer) return;
    this.module._free(this.expression.pointer);
    this.expression = { pointer: this.module._malloc(4 * Math.max(count, 1)), count };
  }

  // {expression, joints: [5 x 3], translation, timeNs}.
  parameters() {
    const { expression, expressionCount, ...others } = this.query("get_parameters", "cosplat_parameters");
    const numbers = new Float32Array(heap(this.module).buffer, expression, expressionCount);
    return { ...others, expression: Array.from(numbers) };
  }
  resetParameters() {
    this.call("reset_parameters");
  }

  // now: milliseconds of performance.now(). From the first call on the rule for bad and missing
  // frames applies.
  advance(now = performance.now()) {
    this.call("advance", nanoseconds(now));
  }

  // A recording (.npz: URL, Blob, ArrayBuffer or Uint8Array); "frames", to be sent by send(); or null.
  async setDrive(drive) {
    if (drive === null) return this.setDriveName(null);
    if (drive === "frames") {
      this.memory.lines.length = 0;
      return this.setDriveName("stdin:");
    }
    const { name, bytes } = await bytesOf(drive, "recording.npz");
    this.memory.withFile({ name, bytes }, (path) => this.setDriveName(path));
  }
  setDriveName(name) {
    this.memory.withText(name, (text) => this.call("set_drive", text));
  }
  // A frame for the drive "frames": an object or a line of JSON, as docs/live-input.md.
  send(frame) {
    const line = typeof frame === "string" ? frame : JSON.stringify(frame);
    this.memory.lines.push(new TextEncoder().encode(`${line.replaceAll("\n", " ")}\n`));
    if (this.memory.lines.length > 4096) this.memory.lines.shift();  // nobody advances
  }

  // What a camera sees, for the drive "frames": {camera, width, height, time, milliseconds, points} as
  // apps/landmarks/page/camera.js has it. Scores and the head are beside the first half second's.
  sendPoints(seen) {
    const { module } = this.memory;
    const line = this.memory.withText(JSON.stringify(seen), (text) => module.UTF8ToString(module._cosplat_web_camera_face(text)));
    if (line) this.send(line);
  }
  calibrate() {
    this.memory.module._cosplat_web_calibrate();
  }

  // {holdS, decayS, blendInS, range, smoothing, minCutoffHz, beta, loop, framesPerSecond}.
  setPolicy(policy = {}) {
    const number = (names, value) => (typeof value === "string" ? names.indexOf(value) : value);
    this.call(
      "set_policy",
      this.structs.fill("cosplat_policy", {
        ...policy,
        range: number(["soft", "free"], policy.range),
        smoothing: number(["none", "oneEuro"], policy.smoothing),
        loop: policy.loop === undefined ? undefined : Number(policy.loop),
      }),
    );
  }
  health() {
    const health = this.query("get_health", "cosplat_health");
    return { ...health, face: FACES[health.face], driveEnded: health.driveEnded === 1 };
  }

  // {width, height, fx, fy, cx, cy, camFromWorld}.
  setCamera(camera) {
    this.call("set_camera", this.structs.fill("cosplat_camera", camera));
  }
  camera() {
    return this.query("get_camera", "cosplat_camera");
  }
  // Radians. Does not set it.
  orbitCamera(width, height, { azimuth = 0, elevation = 0, zoom = 1 } = {}) {
    const camera = this.structs.clear("cosplat_camera");
    this.call("orbit_camera", width, height, azimuth, elevation, zoom, camera);
    return this.structs.read("cosplat_camera");
  }

  // RGBA bytes, top row first, into `out` or a new Uint8ClampedArray. options: alpha ("straight",
  // "premultiplied", "opaque") and background ([r, g, b], 0 to 1).
  render(width, height, options = {}, out = undefined) {
    return this.memory.picture(width, height, options, out, (picture) => this.call("render", picture));
  }

  // The Gaussians of the face that render() would draw, by the camera that is set, for a splat renderer
  // that adds blurVariance px^2 less to a footprint's variances than 3DGS: {width, height, fx, fy, cx,
  // cy, camFromWorld, count, centers, colors, scales, rotations}. out: an earlier result, to be reused.
  splats(blurVariance, out = undefined) {
    this.call("get_splats", blurVariance, this.structs.clear("cosplat_splats"));
    return this.memory.splats(out);
  }

  close() {
    this.check(this.module._cosplat_close(this.handle));
    this.handle = 0;
  }
}
