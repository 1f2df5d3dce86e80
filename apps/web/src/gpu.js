// Two ways to draw: the module on the CPU, or a splat renderer of the page's on the GPU, which gets the
// posed Gaussians of each frame (src/playcanvas.js). Which of them is measured.
let open = null;

// open(canvas): a promise of a GpuRenderer (index.d.ts); null: there is none.
export function setGpuRenderer(opener) {
  open = opener;
}
export const gpuRenderer = () => open;

// The other way has to take less than this part of the time, or else all stays: what is nearly as fast
// would change with every measurement, and a change is seen.
const WORTH_IT = 0.8;
// Of these pictures the fastest counts, which other work disturbed least.
const PICTURES = 5;
// Measured again when the picture has this many times the pixels, or one part in this many.
const PIXELS = 2;

// current: "cpu" or "gpu"; times: milliseconds of a picture, {cpu, gpu}.
export function fasterRenderer(current, times) {
  const other = current === "cpu" ? "gpu" : "cpu";
  return times[other] < WORTH_IT * times[current] ? other : current;
}

export const outgrown = (measured, pixels) => pixels > PIXELS * measured || measured > PIXELS * pixels;

// Milliseconds of picture i of the remote's view: the posed Gaussians' colours, and the drawing.
export async function drawOnce(remote, gpu, i = 0) {
  const { milliseconds, splats } = await remote.call("timeSplats", [i, gpu.blurVariance]);
  return milliseconds + (await gpu.draw(splats, { finish: true }));
}

// The same for both ways, from the camera's being set until the picture is complete. The face is posed
// for neither.
export async function timeRenderers(remote, gpu) {
  const fastest = async (time) => {
    let least = Infinity;
    await time(0);  // memory, textures, shaders
    for (let i = 1; i <= PICTURES; ++i) least = Math.min(least, await time(i));
    return least;
  };
  return {
    cpu: await fastest((i) => remote.call("timePicture", [i])),
    gpu: await fastest((i) => drawOnce(remote, gpu, i)),
  };
}
