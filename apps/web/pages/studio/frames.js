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
    setTimeout(resolve, STALLED);
    video.playbackRate = 0.5;  // so that none is left out
    video.play().catch(resolve);
  });
  video.pause();
  video.playbackRate = 1;
  const steps = times.slice(1).map((t, i) => t - times[i]).filter((step) => step > 1e-3);
  return steps.length > 0 ? Math.min(240, Math.round(1 / Math.min(...steps))) : 30;
}

// Seconds that looking up one frame takes: it is decoded from the key frame before it.
const SEEK = 0.2;
// ms without a frame, as in a tab that is not shown: browsers do not play there.
const STALLED = 3000;
const WAITING = 4;  // frames that may wait for the encoder while more are read

// Calls use(number, bytes) for at most `wanted` frames that are spread evenly, each other than the one
// before it: a still picture would be trained on and tested by. Says how far it is by
// progress(done, total).
export async function forFrames(video, wanted, use, progress) {
  const rate = await rateOf(video);
  const frames = Math.max(1, Math.floor(video.duration * rate));
  const count = Math.min(frames, wanted);
  const canvas = canvasFor(video), context = canvas.getContext("2d");
  let last = null, used = 0, taken = 0, done = 0, queue = Promise.resolve();
  const take = () => {
    context.drawImage(video, 0, 0, canvas.width, canvas.height);
    const encoded = encode(canvas);
    ++taken;
    queue = queue.then(async () => {
      const bytes = await encoded;
      if (!same(last, bytes)) await use(used++, bytes);
      last = bytes;
      progress(++done, count);
    });
  };
  const played = video.requestVideoFrameCallback && video.duration < SEEK * count;
  const wantedFrame = (i) => Math.floor((i * frames) / count);
  // Plays until the i-th wanted frame is shown, or one before the next, and takes it; false if all were
  // passed over.
  const playedTo = (i) =>
    new Promise((resolve) => {
      let waited = 0;
      const end = (found) => {
        clearTimeout(stalled);
        video.removeEventListener("ended", missed);
        video.cancelVideoFrameCallback(waited);
        resolve(found);
      };
      const missed = () => end(false);
      const stalled = setTimeout(missed, STALLED);
      const look = (_, { mediaTime }) => {
        const shown = Math.floor(mediaTime * rate + 0.25);
        if (shown < wantedFrame(i)) return void (waited = video.requestVideoFrameCallback(look));
        if (shown < wantedFrame(i + 1)) take();
        end(shown < wantedFrame(i + 1));
      };
      if (video.ended) return missed();
      video.addEventListener("ended", missed);
      waited = video.requestVideoFrameCallback(look);
      if (video.paused) video.play().catch(missed);
    });
  for (let i = 0; i < count; ++i) {
    if (!played || !(await playedTo(i))) {
      video.pause();
      const seeked = event(video, "seeked", () => "the video cannot be decoded");
      video.currentTime = (wantedFrame(i) + 0.5) / rate;
      await seeked;
      take();
    }
    if (taken - done > WAITING) {
      video.pause();
      await queue;
    }
  }
  video.pause();
  await queue;
}
