// What both pages share: they ask for frames until there are no more, and post what they found.
const settings = new URLSearchParams(location.search);
const width = Number(settings.get("width")), height = Number(settings.get("height"));

const report = (error) =>
  fetch("../failed", { method: "POST", body: `${location.pathname}: ${error?.stack ?? error}` });
self.addEventListener("unhandledrejection", (event) => report(event.reason));
self.addEventListener("error", (event) => report(event.message));

// The packages take a frame's time from the clock, and smooth and track by it: a video's own pace
// makes the result independent of this machine's.
const millisecondsPerFrame = 40;

async function answerFrames(job, look) {
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  let result = null;
  for (let frame = 0; ; ++frame) {
    const reply = await fetch(`../${job}`, { method: "POST", body: result });
    if (reply.status === 204) return;
    context.drawImage(await createImageBitmap(await reply.blob()), 0, 0);
    performance.now = () => 1000 + frame * millisecondsPerFrame;
    result = await look(context.getImageData(0, 0, width, height));
  }
}
