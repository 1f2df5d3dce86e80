/** A URL, or the bytes themselves. */
export type Source = string | Blob | ArrayBuffer | Uint8Array;
export type Vector3 = ArrayLike<number>;

/** What is wrong, in one line that names file, field and value. */
export class CosplatError extends Error {
  /** As cosplat_status_text of cosplat.h, such as "bad file". */
  readonly status: string;
  constructor(message: string, status?: string);
}

export interface LoadOptions {
  /** How many threads draw; by default one per core where the page is cross-origin isolated, else 1. */
  threads?: number;
  /** The folder of the package's modules, if the files were moved; ends in "/". */
  modules?: string;
}
export interface AvatarOptions extends LoadOptions {
  /** Whether shoulders follow the head as they did in training, which is the default. */
  bust?: "follows" | "still";
}
export interface RemoteOptions {
  /** Into which pictures are drawn whenever they change. */
  canvas?: OffscreenCanvas;
}

export interface AvatarInfo {
  gaussianCount: number;
  triangleCount: number;
  expressionCount: number;
  jointCount: number;
  /** Metres: bounds of the Gaussians' centres at rest. */
  boxMin: number[];
  boxMax: number[];
  /** sRGB from 0 to 1: the background on which it was evaluated. */
  background: number[];
  /** 1: the file says from where the head was filmed. */
  knowsFilmed: number;
  /** Radians, least and most, to the head's left and upwards. */
  filmedYaw: number[];
  filmedPitch: number[];
}
export interface SceneInfo {
  gaussianCount: number;
}
export interface Threads {
  threads: number;
}

/** FLAME's parameters. What is not given is at rest. */
export interface Parameters {
  expression?: ArrayLike<number>;
  /** Axis times angle, radians. */
  root?: Vector3;
  neck?: Vector3;
  jaw?: Vector3;
  leftEye?: Vector3;
  rightEye?: Vector3;
  /** Metres. */
  translation?: Vector3;
  /** Milliseconds; performance.now() of the thread that draws, if it is not given. */
  time?: number;
}
export interface CurrentParameters {
  expression: number[];
  /** Five axis-angles: root, neck, jaw, left eye, right eye. */
  joints: number[];
  translation: number[];
  timeNs: number;
}

/** A frame of docs/live-input.md; its root and translation are relative to the rest pose. */
export interface Frame {
  seq: number;
  /** Seconds. */
  time?: number;
  expression?: number[];
  pose?: number[];
  neck?: number[];
  jaw?: number[];
  eyes?: number[];
  translation?: number[];
  /** Scores from 0 to 1 by ARKit's names, in place of expression, jaw and eyes. */
  blendshapes?: Record<string, number>;
}

/** What a camera sees, by MediaPipe's face mesh. */
export interface SeenFace {
  camera: string;
  /** Pixels. */
  width: number;
  height: number;
  /** Milliseconds: when the frame was captured, and how long the face took to find. */
  time: number;
  milliseconds: number;
  /** Of 478 points: [x, y, z] in pixels, z away from the camera; none: there is no face. */
  points: number[][];
}

/** cosplat_policy; what is not given has its default. */
export interface Policy {
  holdS?: number;
  decayS?: number;
  blendInS?: number;
  range?: "soft" | "free";
  smoothing?: "none" | "oneEuro";
  minCutoffHz?: number;
  beta?: number;
  loop?: boolean;
  framesPerSecond?: number;
}

/** cosplat_health. */
export interface Health {
  face: "rest" | "live" | "decaying" | "returning";
  ageS: number;
  driveEnded: boolean;
  accepted: number;
  replaced: number;
  late: number;
  notFinite: number;
  outOfRange: number;
  wrongSize: number;
  softened: number;
  held: number;
  decayed: number;
  returned: number;
  driveFrames: number;
  driveReplaced: number;
  driveReordered: number;
  driveMalformed: number;
  driveOversize: number;
  driveFlooded: number;
  drive: string;
  driveProblem: string;
  drivePackets: number;
  driveUnusable: number;
  driveNotes: string;
  beyondFilm: number;
}

/** A pinhole camera: x right, y down, looking along +z; pixel centres at +0.5. */
export interface Camera {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  /** [R | t], 3x4, row-major. */
  camFromWorld: ArrayLike<number>;
}
/** Radians; at zoom 1 the head fills seven tenths of the shorter side. */
export interface Orbit {
  azimuth?: number;
  elevation?: number;
  zoom?: number;
}

export interface Look {
  alpha?: "straight" | "premultiplied" | "opaque";
  /** sRGB from 0 to 1, with alpha "opaque". */
  background?: Vector3;
}

/** The Gaussians as a camera sees them, the nearest first, for a splat renderer. */
export interface ViewSplats extends Camera {
  count: number;
  /** Four numbers per splat: x, y, z and 0. */
  centers: Float32Array;
  /** Red, green, blue (sRGB, not clamped above) and opacity. */
  colors: Float32Array;
  /** Standard deviations along the rotated axes, and 0. */
  scales: Float32Array;
  /** A unit quaternion, wxyz. */
  rotations: Float32Array;
}

/** Draws splats on the GPU for an element. Dispatches an event "lost" if the GPU is. */
export interface GpuRenderer extends EventTarget {
  /** px^2: by how much less than 3DGS's 0.3 it widens a footprint's variances; done for it. */
  readonly blurVariance: number;
  /**
   * Resolves once the splats are on its canvas, in the task that drew them, to the milliseconds that it
   * took; finish: with those of the GPU.
   */
  draw(splats: ViewSplats, options?: { finish?: boolean }): Promise<number>;
  close(): void;
}
/** For elements that are shown afterwards; null: none. usePlayCanvas of cosplat-player/playcanvas calls it. */
export function setGpuRenderer(open: ((canvas: HTMLCanvasElement) => Promise<GpuRenderer>) | null): void;

/** An avatar on the thread that calls it. Methods throw CosplatError and then change nothing. */
export class Avatar {
  readonly threads: number;
  /** The parameters it was opened with. */
  readonly rest: CurrentParameters;
  info(): AvatarInfo;
  setParameters(parameters?: Parameters): void;
  parameters(): CurrentParameters;
  resetParameters(): void;
  /** Milliseconds of performance.now(). From the first call on bad and missing frames are dealt with. */
  advance(now?: number): void;
  /** A recording (.npz); "frames", to be sent by send(); null for none. */
  setDrive(drive: Source | "frames" | null): Promise<void>;
  send(frame: Frame | string): void;
  /** For the drive "frames": scores and the head, beside those of the first half second. */
  sendPoints(seen: SeenFace): void;
  /** The neutral face is that of the next half second. */
  calibrate(): void;
  setPolicy(policy?: Policy): void;
  health(): Health;
  setCamera(camera: Camera): void;
  camera(): Camera;
  orbitCamera(width: number, height: number, orbit?: Orbit): Camera;
  /** RGBA bytes, top row first. */
  render(width: number, height: number, look?: Look, out?: Uint8ClampedArray): Uint8ClampedArray;
  /** By the camera that is set; blurVariance: as of GpuRenderer; out: an earlier result, to be reused. */
  splats(blurVariance: number, out?: ViewSplats): ViewSplats;
  close(): void;
}
export function openAvatar(avatar: Source, flame?: Source | null, options?: AvatarOptions): Promise<Avatar>;

/** A static scene on the thread that calls it. */
export class Scene {
  readonly threads: number;
  info(): SceneInfo;
  /** Radians. */
  orbit(right: number, up: number): void;
  /** Fractions of the picture's height. */
  pan(right: number, down: number): void;
  /** Each step comes a tenth nearer. */
  zoom(steps: number): void;
  resetCamera(): void;
  render(width: number, height: number, look?: Look, out?: Uint8ClampedArray): Uint8ClampedArray;
  splats(width: number, height: number, blurVariance: number, out?: ViewSplats): ViewSplats;
  close(): void;
}
export function openScene(source: Source, options?: LoadOptions): Promise<Scene>;

export interface View {
  /** Pixels of the pictures. */
  width?: number;
  height?: number;
  orbit?: Orbit;
  /** sRGB from 0 to 1; null: transparent. */
  background?: Vector3 | null;
}

declare class Remote extends EventTarget {
  setView(view: View): void;
  render(width: number, height: number, look?: Look): Promise<Uint8ClampedArray>;
  close(): void;
}

/** An avatar in a worker. Events: "error" (detail: {message, status}) and "stats" (detail: Stats). */
export class RemoteAvatar extends Remote {
  static open(avatar: Source, flame?: Source | null, options?: AvatarOptions & RemoteOptions): Promise<RemoteAvatar>;
  readonly properties: AvatarInfo & Threads;
  info(): Promise<AvatarInfo>;
  setParameters(parameters?: Parameters): void;
  parameters(): Promise<CurrentParameters>;
  resetParameters(): void;
  advance(now?: number): Promise<void>;
  setDrive(drive: Source | "frames" | null): Promise<void>;
  send(frame: Frame | string): void;
  sendPoints(seen: SeenFace): void;
  calibrate(): void;
  setPolicy(policy?: Policy): Promise<void>;
  health(): Promise<Health>;
}

export class RemoteScene extends Remote {
  static open(source: Source, options?: LoadOptions & RemoteOptions): Promise<RemoteScene>;
  readonly properties: SceneInfo & Threads;
  info(): Promise<SceneInfo>;
  orbit(right: number, up: number): void;
  pan(right: number, down: number): void;
  zoom(steps: number): void;
  resetCamera(): void;
}

/** What the event "stats" says of the last second. */
export interface Stats {
  framesPerSecond: number;
  /** Mean time of a picture; with renderer "gpu" without the GPU's own. */
  milliseconds: number;
  threads: number;
  renderer: "cpu" | "gpu";
  health?: Health;
}

/** Which way to draw was chosen, with milliseconds of a picture in each if they were measured. */
export interface ChosenRenderer {
  renderer: "cpu" | "gpu";
  cpu?: number;
  gpu?: number;
}

/**
 * <cosplat-avatar src flame camera="AZIMUTH ELEVATION ZOOM" drive background resolution renderer bust
 * threads>
 *
 * Events: "load" (detail: AvatarInfo & Threads), "error" (an ErrorEvent), "stats" (detail: Stats),
 * "drive" (detail: "connected" or "lost"), "renderer" (detail: ChosenRenderer).
 */
export class AvatarElement extends HTMLElement {
  readonly remote: RemoteAvatar | null;
  readonly drawing: "cpu" | "gpu";
  /** In place of the attributes src and flame. */
  load(src: Source, flame?: Source | null): void;
  look(orbit: Required<Orbit>): void;
  setParameters(parameters?: Parameters): void;
  resetParameters(): void;
  /** With drive="frames". */
  send(frame: Frame | string): void;
  setPolicy(policy: Policy): Promise<void> | undefined;
  health(): Promise<Health> | undefined;
}

/** <cosplat-splats src background resolution renderer threads>; events "load", "error", "stats", "renderer". */
export class SplatsElement extends HTMLElement {
  readonly remote: RemoteScene | null;
  readonly drawing: "cpu" | "gpu";
  load(src: Source): void;
}

export function configure(options: LoadOptions): void;
/** Whether this page may draw with several threads. */
export function threadsAvailable(): boolean;

declare global {
  interface HTMLElementTagNameMap {
    "cosplat-avatar": AvatarElement;
    "cosplat-splats": SplatsElement;
  }
}
