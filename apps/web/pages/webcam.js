// A webcam's face -> MediaPipe's face landmarker -> blendshape scores and the head's rotation -> the
// avatar, by the map that its file has (docs/live-input.md).
import "../src/index.js";
import { fileChooser, findEngine, findModel, show } from "./panel.js";

// Where MediaPipe's package and its face landmarker are, unless the page's query or the user says
// otherwise (?package=URL&model=URL). Both are loaded when the camera starts.
const PACKAGE = "https://cdn.jsdelivr.net/npm/@mediapipe/tasks-vision@0.10.14";
const MODEL = "https://storage.googleapis.com/mediapipe-models/face_landmarker/face_landmarker/float16/1/face_landmarker.task";

const byId = (id) => document.getElementById(id);
const query = new URLSearchParams(location.search);
byId("package").value = query.get("package") ?? PACKAGE;
byId("model").value = query.get("model") ?? MODEL;

let element = null;
function use(model) {
  element = show(model, byId("stage"), byId("status"), { drive: "frames" });
}
await findEngine();
const model = await findModel();
if (model?.avatar) use(model);
else byId("panel").prepend(fileChooser((chosen) => chosen.avatar && use(chosen)));

function say(text, problem = false) {
  byId("tracking").textContent = text;
  byId("tracking").classList.toggle("problem", problem);
}

async function openLandmarker() {
  const base = byId("package").value.replace(/\/$/, "");
  const { FaceLandmarker, FilesetResolver } = await import(`${base}/vision_bundle.mjs`);
  const [file] = byId("file").files;
  const baseOptions = file
    ? { modelAssetBuffer: new Uint8Array(await file.arrayBuffer()) }
    : { modelAssetPath: byId("model").value };
  return FaceLandmarker.createFromOptions(await FilesetResolver.forVisionTasks(`${base}/wasm`), {
    baseOptions,
    runningMode: "VIDEO",
    numFaces: 1,
    outputFaceBlendshapes: true,
    outputFacialTransformationMatrixes: true,
  });
}

// Axis times angle of the rotation of a column-major 4x4 matrix (MediaPipe: x right, y up, z to the
// camera; the face looks along +z, and FLAME's does too).
function rotationOf(matrix) {
  const at = (row, column) => matrix[4 * column + row];
  const axis = [at(2, 1) - at(1, 2), at(0, 2) - at(2, 0), at(1, 0) - at(0, 1)];
  const sine = Math.hypot(...axis) / 2;
  const angle = Math.atan2(sine, (at(0, 0) + at(1, 1) + at(2, 2) - 1) / 2);
  return sine < 1e-6 ? [0, 0, 0] : axis.map((x) => (x / (2 * sine)) * angle);
}

function send(result, seq, seconds) {
  const [scores] = result.faceBlendshapes ?? [];
  if (!scores) return false;
  const scored = scores.categories.filter(({ categoryName }) => categoryName !== "_neutral");
  const blendshapes = Object.fromEntries(scored.map(({ categoryName, score }) => [categoryName, score]));
  const [matrix] = result.facialTransformationMatrixes ?? [];
  const frame = { seq, time: seconds, blendshapes };
  if (matrix) frame.neck = rotationOf(matrix.data);
  element?.send(frame);
  return true;
}

async function track(landmarker, video) {
  let seq = 0;
  let seen = 0;
  let since = performance.now();
  for (;;) {
    await new Promise((resolve) => (video.requestVideoFrameCallback ?? requestAnimationFrame).call(video.requestVideoFrameCallback ? video : window, resolve));
    const now = performance.now();
    if (send(landmarker.detectForVideo(video, now), ++seq, now / 1e3)) ++seen;
    if (now - since < 1000) continue;
    say(seen > 0 ? `${((1e3 * seen) / (now - since)).toFixed(0)} faces per second` : "no face is seen", seen === 0);
    seen = 0;
    since = now;
  }
}

byId("start").onclick = async () => {
  byId("start").disabled = true;
  try {
    say("loading MediaPipe");
    const landmarker = await openLandmarker();
    const video = byId("video");
    video.srcObject = await navigator.mediaDevices.getUserMedia({ video: { width: 640, height: 480 } });
    await video.play();
    await track(landmarker, video);
  } catch (error) {
    say(`camera: ${error.message ?? error}`, true);
    byId("start").disabled = false;
  }
};
