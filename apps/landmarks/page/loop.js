// What both pages share: they ask for frames until there are no more, and post what they found.
const settings = new URLSearchParams(location.search);
const width = Number(settings.get("width")), height = Number(settings.get("height"));

const report = (error) =>
  fetch("../failed", { method: "POST", body: `${location.pathname}: ${error?.stack ?? error}` });
self.addEventListener("unhandledrejection", (event) => report(event.reason));
self.addEventListener("error", (event) => report(event.message));

// Frames that are further apart do not follow each other.
const longestStep = 200;  // milliseconds

// look(image, follows) gives what is posted; follows: whether the frame before was just before.
async function answerFrames(look) {
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  let result = null, last = -Infinity;
  for (;;) {
    const reply = await fetch(`../${location.hostname.split(".")[0]}`, { method: "POST", body: result });
    if (reply.status === 204) return;
    context.drawImage(await createImageBitmap(await reply.blob()), 0, 0);
    // The packages take a frame's time from the clock, and smooth and track by it: the video's own
    // makes the result independent of this machine's.
    const time = Number(reply.headers.get("x-milliseconds"));
    performance.now = () => 1000 + time;
    result = await look(context.getImageData(0, 0, width, height), time - last <= longestStep);
    last = time;
  }
}
