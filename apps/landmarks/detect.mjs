// Runs MediaPipe's face mesh and selfie segmentation over images, in headless Chromium.
//
//   node detect.mjs --chromium PROGRAM --modules FOLDER --jobs face,matte --width W --height H
//                   --frames FOLDER
//
// FOLDER of frames has 0.jpg ... N-1.jpg of one size, and times.json: when each was taken, in
// increasing milliseconds. faces.json (per frame a list of faces, each a list of [x, y] in pixels)
// and 0.matte ... (a byte per pixel, rows from the top) are written beside them, by the job that
// is asked for. FOLDER of modules is npm's node_modules. Prints "frame K" for each frame that all
// jobs have seen.
//
// Each item of --jobs is a page that asks for a frame, and posts what it found with the next request.
// Pages of one job share its frames, which should not follow each other then. The pages have
// different origins, so that Chromium gives each a process, and they run on several cores.
import fs from "node:fs";
import path from "node:path";
import { parseArgs } from "node:util";
import { open, stop } from "./browser.mjs";

const names = ["chromium", "modules", "frames", "jobs", "width", "height"];
const { values: options } = parseArgs({
  options: Object.fromEntries(names.map((name) => [name, { type: "string" }])),
});
const times = JSON.parse(fs.readFileSync(path.join(options.frames, "times.json")));
const count = times.length;
const pages = options.jobs.split(",").map((job) => ({ job, frame: null }));
const next = Object.fromEntries(pages.map(({ job }) => [job, 0]));
const found = { ...next };
const faces = new Array(count);

// A frame for `page`, and what it found in the one before.
function answer(page, result, response) {
  const { job, frame } = page;
  if (result.length > 0) {
    if (job === "face") faces[frame] = JSON.parse(result.toString());
    else fs.writeFileSync(path.join(options.frames, `${frame}.matte`), result);
    const before = Math.min(...Object.values(found));
    ++found[job];
    const all = Math.min(...Object.values(found));
    if (all > before) console.log(`frame ${all}`);
  }
  if (next[job] < count) {
    page.frame = next[job]++;
    response.setHeader("content-type", "image/jpeg");
    response.setHeader("x-milliseconds", times[page.frame]);
    response.end(fs.readFileSync(path.join(options.frames, `${page.frame}.jpg`)));
    return;
  }
  response.writeHead(204).end();
  if (Object.values(found).every((each) => each === count)) {
    fs.writeFileSync(path.join(options.frames, "faces.json"), JSON.stringify(faces));
    stop(0);
  }
}

const { chromium, modules, jobs, width, height } = options;
open({
  chromium,
  modules,
  page: `index.html?${new URLSearchParams({ jobs, width, height })}`,
  answer: (url, body, response) => {
    const page = pages[Number(/^\/page-([0-9]+)$/.exec(url)?.[1])];
    if (page) answer(page, body, response);
    else response.writeHead(404).end();
  },
});
