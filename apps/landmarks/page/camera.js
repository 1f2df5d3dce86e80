// Posts the face in each frame of a camera: the newest one that there is when the last was looked at.
const settings = new URLSearchParams(location.search);
const wanted = Number(settings.get("camera")), size = { width: 640, height: 480 };
const cells = Number(settings.get("bar") ?? 0);

const post = (url, body) => fetch(url, { method: "POST", body });
const report = (error) => post("../failed", error?.message ?? String(error));
self.addEventListener("unhandledrejection", (event) => report(event.reason));
self.addEventListener("error", (event) => report(event.message));

const pixels = (x) => Math.round(100 * x) / 100;

async function openCamera() {
  const cameras = (await navigator.mediaDevices.enumerateDevices())
    .filter((device) => device.kind === "videoinput");
  if (wanted >= cameras.length) {
    throw new Error(settings.has("film")
      ? `${settings.get("film")} is no film that Chromium reads`
      : `there are ${cameras.length} cameras; camera ${wanted} was asked for`);
  }
  const { deviceId, label } = cameras[wanted];
  const stream = await navigator.mediaDevices.getUserMedia({
    video: {
      deviceId: { exact: deviceId },
      width: { ideal: size.width },
      height: { ideal: size.height },
      frameRate: { ideal: 30 },
    },
  }).catch((error) => {
    throw new Error(`camera ${wanted} (${label}): ${error.message}`);
  });
  return { track: stream.getVideoTracks()[0], label };
}

// Of the middles of the cells, eight pixels above the lower edge.
function barOf({ data, width, height }) {
  let number = 0;
  for (let cell = 0; cell < cells; ++cell) {
    const x = Math.floor((cell + 0.5) * width / cells);
    if (data[4 * ((height - 8) * width + x) + 1] > 127) number += 2 ** cell;
  }
  return number;
}

(async () => {
  const { track, label } = await openCamera();
  const mesh = await openFaceMesh(1);
  const frames = new MediaStreamTrackProcessor({ track, maxBufferSize: 1 }).readable.getReader();
  const canvas = new OffscreenCanvas(1, 1);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  for (;;) {
    const { value: frame, done } = await frames.read();
    if (done) throw new Error(`camera ${wanted} (${label}) has gone`);
    const time = performance.timeOrigin + performance.now();
    const width = frame.displayWidth, height = frame.displayHeight;
    if (canvas.width !== width || canvas.height !== height)
      Object.assign(canvas, { width, height });
    context.drawImage(frame, 0, 0);
    const captured = frame.timestamp / 1000;
    frame.close();
    const image = context.getImageData(0, 0, width, height);
    const bar = cells > 0 ? { bar: barOf(image) } : {};
    const faces = await mesh.look(image);
    const points = (faces[0] ?? []).map(
      (p) => [pixels(p.x * width), pixels(p.y * height), pixels(p.z * width)]);
    const milliseconds = performance.timeOrigin + performance.now() - time;
    post("../face", JSON.stringify(
      { camera: label, width, height, time: captured, milliseconds, ...bar, points }));
  }
})();
