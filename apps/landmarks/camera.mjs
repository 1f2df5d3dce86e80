// Finds the face that a camera sees, by MediaPipe's face mesh in headless Chromium, until it is
// ended.
//
//   node camera.mjs --chromium PROGRAM --modules FOLDER --camera N|FILM [--bar CELLS]
//
// N counts the machine's cameras from 0; a FILM (.y4m or .mjpeg) is shown in place of one, again and
// again. Prints a line of JSON for each frame that was looked at: `camera`, its name; `width` and
// `height`, pixels; `time`, when it was captured, in milliseconds; `milliseconds`, what finding
// took; and `points`, 478 times [x, y, z] in pixels, z away from the camera, or none. With --bar, `bar` is the
// number that as many black and white cells along the lower edge say, the lowest bit at the left
// (apps/cosplat/run/latency_film.h).
import path from "node:path";
import { parseArgs } from "node:util";
import { fail, open } from "./browser.mjs";

const names = ["chromium", "modules", "camera", "bar"];
const { values: options } = parseArgs({
  options: Object.fromEntries(names.map((name) => [name, { type: "string" }])),
});
const film = /^[0-9]+$/.test(options.camera) ? null : path.resolve(options.camera);
const flags = ["--disable-background-timer-throttling", "--disable-renderer-backgrounding"];
if (film)
  flags.push("--use-fake-device-for-media-stream", `--use-file-for-fake-video-capture=${film}`);
process.stdout.on("error", () => fail("nobody reads"));
open({
  chromium: options.chromium,
  modules: options.modules,
  page: `camera.html?${new URLSearchParams({
    ...(film ? { camera: 0, film } : { camera: options.camera }),
    ...(options.bar ? { bar: options.bar } : {}),
  })}`,
  flags,
  permissions: ["videoCapture"],
  answer: (url, body, response) => {
    response.writeHead(204).end();
    process.stdout.write(`${body}\n`);
  },
});
