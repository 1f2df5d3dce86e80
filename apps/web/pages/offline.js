// The page of `cosplat export --html`: everything is in it, also the player.
import { configure } from "../src/index.js";
import { gallery, partsOfPage } from "./gallery.js";

const textOf = (id) => document.getElementById(id).textContent;
const urlOf = (id) => URL.createObjectURL(new Blob([textOf(id)], { type: "text/javascript" }));
function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

configure({ offline: { worker: urlOf("worker"), wasm: bytesOf(textOf("wasm")) } });
const { title, flameName, ...files } = JSON.parse(textOf("model"));
const model = Object.fromEntries(
  Object.entries(files).map(([kind, { name, base64 }]) => [kind, new File([bytesOf(base64)], name)]),
);
gallery({ title, flameName, ...model }, partsOfPage());
