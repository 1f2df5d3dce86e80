// Makes dist/codecs.mjs with its .wasm, dist/finder/ (MediaPipe, for trainer.js), and dist/offline.html, into which `cosplat export --html` puts a
// model: the gallery with the player of one thread in one file.
import fs from "node:fs";
import path from "node:path";

import { build } from "esbuild";

const here = import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname);
const read = (file) => fs.readFileSync(path.join(here, file), "utf8");

function copy(from, to) {
  const target = path.join(here, "dist", to);
  fs.mkdirSync(path.dirname(target), { recursive: true });
  fs.copyFileSync(path.join(here, from), target);
}
async function bundle(file, format) {
  const options = { bundle: true, format, minify: true, write: false, logLevel: "error", target: "es2022", logOverride: { "empty-import-meta": "silent" } };
  const { outputFiles } = await build({ ...options, entryPoints: [path.join(here, file)] });
  return outputFiles[0].text;
}
// A script's text must not end the script.
const inScript = (text) => text.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
const held = (id, text) => `<script type="text/plain" id="${id}">${inScript(text)}</script>`;

fs.writeFileSync(path.join(here, "dist/codecs.mjs"), await bundle("codecs.js", "esm"));
copy("node_modules/@jsquash/webp/codec/dec/webp_dec.wasm", "webp_dec.wasm");

// The page that finds faces, and what it loads where WebAssembly has SIMD, as the trainer needs.
for (const file of ["finder.html", "finder.js", "mesh.js", "segmentation.js"]) copy(`../landmarks/page/${file}`, `finder/page/${file}`);
for (const name of ["face_mesh", "selfie_segmentation"]) {
  const folder = `node_modules/@mediapipe/${name}`;
  for (const file of fs.readdirSync(path.join(here, folder)))
    if (/\.(js|wasm|data|binarypb|tflite)$/.test(file) && !file.includes("solution_wasm")) copy(`${folder}/${file}`, `finder/packages/${name}/${file}`);
}

const body = read("pages/index.html");
const main = body.slice(body.indexOf("<main>"), body.indexOf("</main>") + "</main>".length);
const page = `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8" />
<meta name="viewport" content="width=device-width, initial-scale=1" />
<title>CoSplat</title>
<style>
${read("pages/style.css")}</style>
</head>
<body>
${main}
${held("worker", await bundle("pages/offline-worker.js", "iife"))}
${held("wasm", fs.readFileSync(path.join(here, "dist/player.wasm")).toString("base64"))}
<script type="text/plain" id="model">@MODEL@</script>
<script type="module">${inScript(await bundle("pages/offline.js", "esm"))}</script>
</body>
</html>
`;
fs.writeFileSync(path.join(here, "dist/offline.html"), page);

// What a page without a network needs (service-worker.js).
const below = (folder) => fs.readdirSync(path.join(here, folder), { recursive: true }).map((name) => `${folder}/${name}`);
const needed = [...below("dist"), ...below("src").filter((name) => name.endsWith(".js")), ...below("pages")]
  .filter((name) => fs.statSync(path.join(here, name)).isFile() && !name.includes("playcanvas") && !name.endsWith("studio-files.json"));
fs.writeFileSync(path.join(here, "dist/studio-files.json"), JSON.stringify(needed));
