// For another page, which has this one as a frame: finds faces, and mattes, in what it posts.
//
//   {id, image: ImageBitmap, milliseconds, mattes}  ->  {id, faces, matte}
//
// faces: each a list of [x, y, z] in pixels of the image; matte: a byte per pixel, if asked for. A
// frame whose time is not within 200 ms after the one before does not follow it.
const longestStep = 200;  // milliseconds
const maxFaces = Number(new URLSearchParams(location.search).get("faces") ?? 2);
const canvas = new OffscreenCanvas(1, 1);
const context = canvas.getContext("2d", { willReadFrequently: true });
let segmentation = null, last = -Infinity;

async function find(mesh, { image, milliseconds, mattes }) {
  const { width, height } = image;
  if (canvas.width !== width || canvas.height !== height) {
    Object.assign(canvas, { width, height });
    segmentation = null;
  }
  context.drawImage(image, 0, 0);
  image.close();
  const pixels = context.getImageData(0, 0, width, height);
  // The packages take a frame's time from the clock, and smooth and track by it.
  performance.now = () => 1000 + milliseconds;
  if (milliseconds < last || milliseconds - last > longestStep) mesh.reset();
  last = milliseconds;
  const found = await mesh.look(pixels);
  const faces = found.map((face) => face.map((p) => [p.x * width, p.y * height, p.z * width]));
  if (!mattes) return { faces };
  segmentation ??= await openSegmentation(width, height);
  return { faces, matte: await segmentation.look(pixels) };
}

// Where it cannot, MediaPipe opens a dialog, and finds nothing.
function needWebGl() {
  const shown = document.createElement("canvas"), gl = shown.getContext("webgl2") ?? shown.getContext("webgl");
  if (!gl) throw new Error("this browser has no WebGL, which finding faces needs: allow it the graphics card (\"hardware acceleration\"), or take another browser");
  gl.getExtension("WEBGL_lose_context")?.loseContext();
}

(async () => {
  needWebGl();
  const mesh = await openFaceMesh(maxFaces);
  let queue = Promise.resolve();
  self.addEventListener("message", ({ data, source }) => {
    queue = queue.then(() => find(mesh, data)).then(
      (found) => source.postMessage({ id: data.id, ...found }, found.matte ? { transfer: [found.matte.buffer] } : undefined),
      (error) => source.postMessage({ id: data.id, error: error?.message ?? String(error) }),
    );
  });
  parent.postMessage({ ready: true });
})().catch((error) => parent.postMessage({ error: error?.message ?? String(error) }));
