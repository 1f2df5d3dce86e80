/** MediaPipe's face mesh and selfie segmentation, in a hidden frame of this page. */
export class FaceFinder {
  static open(options?: { faces?: number; modules?: string }): Promise<FaceFinder>;
  /**
   * Of one image, which is used up. faces: each of 478 points, [x, y, z] in pixels; matte: a byte per pixel, 255
   * where the person is.
   */
  find(
    image: ImageBitmap, milliseconds: number, mattes?: boolean,
  ): Promise<{ faces: number[][][]; matte?: Uint8Array }>;
  close(): void;
}

export interface TrainerFile {
  path: string;
  bytes: Uint8Array;
}

/**
 * Makes a head avatar from frames of a video, in this page alone. Events (CustomEvent): "progress" {title, done,
 * total, detail, seconds}, "line" {text}, "avatar" {bytes}: the avatar.glb as it is now, "files" {files}: what
 * another run goes on from, once given to `open` with the frames.
 */
export class AvatarTrainer extends EventTarget {
  static open(options?: { threads?: number; modules?: string; files?: TrainerFile[] }): Promise<AvatarTrainer>;
  readonly threads: number;
  addFile(path: string, bytes: Uint8Array): void;
  /** A JPEG or PNG; all of one size. */
  addFrame(number: number, bytes: Uint8Array): void;
  /** options: of `cosplat avatar`, as words. Rejects with one line. */
  make(options?: string[]): Promise<void>;
  stop(): void;
  close(): void;
}
