// Opens one file in one reader, lets it draw every view until its picture stands still, and sends the
// PSNR against ours with the picture to view.mjs.
const parameters = new URLSearchParams(location.search);
const job = await (await fetch(`/job?${parameters}`)).json();
const { width, height } = job;

const canvas = document.createElement("canvas");
canvas.width = width;
canvas.height = height;
canvas.style.width = `${width}px`;
canvas.style.height = `${height}px`;
document.body.append(canvas);

const sleep = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));
const flat = document.createElement("canvas");
flat.width = width;
flat.height = height;
const context = flat.getContext("2d", { willReadFrequently: true });

function pixelsOf(image) {
  context.fillStyle = "#000";
  context.fillRect(0, 0, width, height);
  context.drawImage(image, 0, 0, width, height);
  return context.getImageData(0, 0, width, height).data;
}

// Readers sort in workers and draw before they have: a picture counts once it has stood still.
async function settled(reader) {
  let last = null;
  for (let still = 0, start = performance.now(); performance.now() - start < 120000;) {
    await reader.draw();
    const pixels = pixelsOf(reader.canvas).slice();
    const same = last && pixels.every((value, i) => value === last[i]);
    const black = !pixels.some((value, i) => i % 4 < 3 && value > 8);
    still = same && !black ? still + 1 : 0;
    if (still >= 4) return pixels;
    last = pixels;
    await sleep(250);
  }
  return last;
}

// Mean squared difference of red, green and blue, in dB.
function psnr(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; ++i) if (i % 4 < 3) sum += (a[i] - b[i]) ** 2;
  return 10 * Math.log10((255 * 255) / (sum / (a.length * 0.75)));
}

async function run() {
  const { open } = await import(`/page/${job.reader}.js`);
  const reader = await open({ ...job, canvas });
  const views = [];
  for (const [index, view] of job.views.entries()) {
    reader.look(view);
    const picture = await settled(reader);
    context.putImageData(new ImageData(picture, width, height), 0, 0);
    const png = flat.toDataURL("image/png");
    const ours = await createImageBitmap(await (await fetch(view.image)).blob());
    views.push({ psnr: psnr(picture, pixelsOf(ours)), png });
    await fetch(`/progress?view=${index}`);
  }
  return { views };
}

let result;
try {
  result = await run();
} catch (error) {
  result = { error: String(error?.stack ?? error) };
}
await fetch("/result", { method: "POST", body: JSON.stringify(result) });
