// The frames of a video as JPEG, by the browser's own decoder.
const QUALITY = 0.97;
// A head's square becomes one of 512 px; frames of 4K would fill the memory.
const LARGEST = 1920;  // px

const event = (target, name, problem) =>
  new Promise((resolve, reject) => {
    target.addEventListener(name, resolve, { once: true });
    target.addEventListener("error", () => reject(new Error(problem())), { once: true });
  });

export async function encode(canvas) {
  const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/jpeg", QUALITY));
  if (!blob) throw new Error("a frame could not be encoded");
  return new Uint8Array(await blob.arrayBuffer());
}

export function canvasFor(video) {
  const scale = Math.min(1, LARGEST / Math.max(video.videoWidth, video.videoHeight));
  const side = (length) => Math.max(1, Math.round(scale * length));
  return Object.assign(document.createElement("canvas"), { width: side(video.videoWidth), height: side(video.videoHeight) });
}

const same = (a, b) => a?.length === b.length && a.every((byte, i) => byte === b[i]);

export async function openVideo(video, file) {
  video.srcObject = null;
  video.src = URL.createObjectURL(file);
  await event(video, "loadedmetadata", () => `${file.name}: is no video that this browser plays`);
  if (!video.videoWidth) throw new Error(`${file.name}: has no picture`);
  if (!Number.isFinite(video.duration)) {
    // What MediaRecorder wrote has no length before its end was looked for.
    video.currentTime = 1e9;
    await event(video, "seeked", () => `${file.name}: cannot be read to its end`);
  }
  return { width: video.videoWidth, height: video.videoHeight, seconds: video.duration };
}

// How many frames a second a video has: the shortest time between two that are shown, of the first
// few. Browsers do not say.
async function rateOf(video) {
  const times = [];
  if (!video.requestVideoFrameCallback) return 30;
  video.currentTime = 0;
  await new Promise((resolve) => {
    const look = (_, { mediaTime }) => {
      times.push(mediaTime);
      if (times.length < 12) video.requestVideoFrameCallback(look);
      else resolve();
    };
    video.requestVideoFrameCallback(look);
    video.addEventListener("ended", resolve, { once: true });
    video.playbackRate = 0.5;  // so that none is left out
    video.play();
  });
  video.pause();
  const steps = times.slice(1).map((t, i) => t - times[i]).filter((step) => step > 1e-3);
  return steps.length > 0 ? Math.min(240, Math.round(1 / Math.min(...steps))) : 30;
}

// Calls use(number, bytes) for at most `wanted` frames that are spread evenly, each other than the one
// before it: a still picture would be trained on and tested by. Says how far it is by
// progress(done, total).
export async function forFrames(video, wanted, use, progress) {
  const rate = await rateOf(video);
  const frames = Math.max(1, Math.floor(video.duration * rate));
  const count = Math.min(frames, wanted);
  const canvas = canvasFor(video), context = canvas.getContext("2d");
  let last = null, used = 0;
  for (let i = 0; i < count; ++i) {
    const frame = Math.floor((i * frames) / count);
    const seeked = event(video, "seeked", () => "the video cannot be decoded");
    video.currentTime = (frame + 0.5) / rate;
    await seeked;
    context.drawImage(video, 0, 0, canvas.width, canvas.height);
    const bytes = await encode(canvas);
    if (!same(last, bytes)) await use(used++, bytes);
    last = bytes;
    progress(i + 1, count);
  }
}
