// The gallery: a model with its controls. Used by index.html and by the offline page.
import { driveControls, faceControls, fileChooser, lookControls, make, show } from "./panel.js";

export function gallery(model, { title, stage, panel, status }) {
  const open = (chosen) => gallery(chosen, { title, stage, panel, status });
  if (!model || (model.flameName && !model.flame)) {
    title.textContent = model?.title ?? "CoSplat";
    status.textContent = model
      ? `This avatar needs its FLAME model, ${model.flameName}: choose the file.`
      : "Choose an avatar (.glb), or splats (.ply, .spz, .sog, .splat).";
    return panel.replaceChildren(model ? flameChooser(model, open) : fileChooser(open), status);
  }
  title.textContent = model.title;
  document.title = `${model.title} · CoSplat`;
  const element = show(model, stage, status);
  element.addEventListener("error", ({ message }) => {
    const [, flameName] = (!model.flame && /flame_path: is needed: .*'(.*)'/.exec(message)) || [];
    if (flameName) open({ ...model, flameName });
  });
  const parts = [status];
  if (model.avatar) {
    const face = faceControls(element);
    if (!model.drive) element.addEventListener("load", face.start, { once: true });
    parts.push(face.controls, driveControls(element, face.stop));
  }
  panel.replaceChildren(...parts, lookControls(element));
}

function flameChooser(model, open) {
  const input = make("input", { type: "file", accept: ".pkl,.npz" });
  input.onchange = () => open({ ...model, flame: input.files[0] });
  return make("label", {}, "FLAME model", input);
}

export const partsOfPage = () =>
  Object.fromEntries(["title", "stage", "panel", "status"].map((id) => [id, document.getElementById(id)]));
