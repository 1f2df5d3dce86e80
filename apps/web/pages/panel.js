// What the pages share: the model to show, the line below it, and the controls of a face.
import { usePlayCanvas } from "../src/playcanvas.js";

// ?playcanvas=URL: PlayCanvas' engine, so that the GPU may draw. What goes wrong is told by the element.
export async function findEngine() {
  const url = new URLSearchParams(location.search).get("playcanvas");
  if (url) usePlayCanvas(await import(new URL(url, document.baseURI)));
}

// The model: by the page's query (?avatar=URL[&flame=URL] or ?splats=URL), or else of `cosplat serve`.
// Null: none, so that the user has to choose files.
export async function findModel() {
  const query = new URLSearchParams(location.search);
  if (query.has("avatar")) return { title: query.get("avatar"), avatar: query.get("avatar"), flame: query.get("flame") };
  if (query.has("splats")) return { title: query.get("splats"), splats: query.get("splats") };
  try {
    const response = await fetch("/model.json");
    return response.ok ? await response.json() : null;
  } catch {
    return null;
  }
}

export function make(tag, properties = {}, ...children) {
  const { style, ...others } = properties;
  const element = Object.assign(document.createElement(tag), others);
  if (style) element.setAttribute("style", style);
  element.append(...children);
  return element;
}

export const labelled = (text, control) => make("label", {}, text, control);

// For pictures from where the head was not filmed.
function filmedFrom({ filmedYaw, filmedPitch }) {
  const [right, left, down, up] = [...filmedYaw, ...filmedPitch].map((radians) => ((radians * 180) / Math.PI).toFixed(0));
  return `a guess: the head was filmed from ${right} to ${left} degrees to its left, and from ${down} to ${up} upwards`;
}

// An element in `stage` that shows the model, with its speed and what goes wrong.
export function show(model, stage, status, attributes = {}) {
  const element = document.createElement(model.splats ? "cosplat-splats" : "cosplat-avatar");
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (model.drive && !attributes.drive) element.setAttribute("drive", model.drive);
  const renderer = new URLSearchParams(location.search).get("renderer");
  if (renderer) element.setAttribute("renderer", renderer);
  const speed = make("p", { className: "speed" });
  const say = (text, problem = false) => {
    status.textContent = text;
    status.classList.toggle("problem", problem);
  };
  let beyond = 0;
  element.addEventListener("stats", ({ detail }) => {
    const threads = `${detail.threads} thread${detail.threads > 1 ? "s" : ""}`;
    const by = detail.renderer === "gpu" ? "GPU" : threads;
    speed.textContent = `${detail.framesPerSecond.toFixed(0)} frames/s, ${detail.milliseconds.toFixed(1)} ms each, ${by}`;
    const guessed = (detail.health?.beyondFilm ?? 0) > beyond;
    beyond = detail.health?.beyondFilm ?? 0;
    if (guessed) speed.textContent += `; ${filmedFrom(element.remote.properties)}`;
  });
  element.addEventListener("error", ({ message }) => say(message, true));
  element.addEventListener("load", ({ detail }) => say(`${detail.gaussianCount.toLocaleString("en")} Gaussians`));
  if (typeof (model.splats ?? model.avatar) === "string") {
    element.setAttribute("src", model.splats ?? model.avatar);
    if (model.flame) element.setAttribute("flame", model.flame);
  } else {
    element.load(model.splats ?? model.avatar, model.flame);
  }
  say("loading");
  stage.replaceChildren(element, speed);
  return element;
}

// Files instead of a model that was found: calls use(model).
export function fileChooser(use) {
  const [model, flame] = [".glb,.ply,.spz,.sog,.splat,.zip", ".pkl,.npz"].map((accept) => make("input", { type: "file", accept }));
  const open = () => {
    const [file] = model.files;
    if (!file) return;
    if (!file.name.endsWith(".glb")) use({ title: file.name, splats: file });
    else use({ title: file.name, avatar: file, flame: flame.files[0] });
  };
  model.onchange = flame.onchange = open;
  return make("fieldset", {}, make("legend", { textContent: "Files" }), labelled("avatar, splats", model), labelled("FLAME model, if not in it", flame));
}

const SHOWN_EXPRESSIONS = 8;

// Sliders that set the face while no drive does; and a motion, so that something happens.
export function faceControls(element) {
  const sliders = {};
  const slider = (name, most, least = -most) => {
    const input = make("input", { type: "range", min: least, max: most, step: most / 100, value: 0 });
    input.oninput = () => apply();
    sliders[name] = input;
    return labelled(name, input);
  };
  const value = (name) => Number(sliders[name].value);
  const moves = make("input", { type: "checkbox", checked: true });
  const apply = (t = null) => {
    const wave = (rate, size) => (t === null ? 0 : size * Math.sin(rate * t));
    const expression = Array.from({ length: SHOWN_EXPRESSIONS }, (_, k) => value(`expression ${k}`) + wave(0.7 + 0.31 * k, 0.8));
    const eye = [value("look down"), value("look left"), 0];
    element.setParameters({
      expression,
      neck: [value("nod") + wave(0.9, 0.06), value("turn") + wave(0.6, 0.25), 0],
      jaw: [value("jaw") + (t === null ? 0 : 0.1 - 0.1 * Math.cos(2.5 * t)), 0, 0],
      leftEye: eye,
      rightEye: eye,
    });
  };
  const frame = (now) => {
    if (!moves.checked || !element.isConnected) return;
    apply(now / 1e3);
    requestAnimationFrame(frame);
  };
  moves.onchange = () => (moves.checked ? requestAnimationFrame(frame) : apply());
  const reset = make("button", { type: "button", textContent: "Rest" });
  reset.onclick = () => {
    for (const input of Object.values(sliders)) input.value = 0;
    moves.checked = false;
    apply();
  };
  const names = Array.from({ length: SHOWN_EXPRESSIONS }, (_, k) => slider(`expression ${k}`, 3));
  const controls = make(
    "fieldset",
    {},
    make("legend", { textContent: "Face" }),
    labelled("motion", moves),
    slider("jaw", 0.4, 0),
    slider("turn", 0.8),
    slider("nod", 0.4),
    slider("look left", 0.4),
    slider("look down", 0.3),
    ...names,
    reset,
  );
  return {
    controls,
    start: () => {
      moves.checked = true;
      requestAnimationFrame(frame);
    },
    stop: () => (moves.checked = false),
  };
}

// The drive: a socket's address or a recording.
export function driveControls(element, stopFace) {
  const address = make("input", { type: "text", placeholder: "ws://localhost:9501", value: element.getAttribute("drive") ?? "" });
  const recording = make("input", { type: "file", accept: ".npz" });
  address.onchange = () => {
    stopFace();
    if (address.value) element.setAttribute("drive", address.value);
    else element.removeAttribute("drive");
  };
  recording.onchange = async () => {
    stopFace();
    try {
      await element.setPolicy({ loop: true });
      await element.remote.setDrive(recording.files[0]);
    } catch (error) {
      element.report(error);
    }
  };
  return make("fieldset", {}, make("legend", { textContent: "Drive" }), labelled("socket", address), labelled("recording", recording));
}

export function lookControls(element) {
  const preview = make("input", { type: "checkbox" });
  preview.onchange = () => element.setAttribute("resolution", preview.checked ? "0.5" : "1");
  const background = make("select", {}, ...["transparent", "#ffffff", "#000000", "#00b140"].map((value) => make("option", { value, textContent: value })));
  background.onchange = () => element.setAttribute("background", background.value);
  return make("fieldset", {}, make("legend", { textContent: "Picture" }), labelled("half-size preview", preview), labelled("background", background));
}
