// Films a head before the camera, and says what the film still needs: an avatar knows only what it
// was shown.
import { canvasFor, encode } from "./frames.js";

// Of MediaPipe's 478 points.
const POINT = { right: 234, left: 454, brow: 10, chin: 152, lipUp: 13, lipDown: 14, mouthRight: 78, mouthLeft: 308, lids: [[159, 145, 33, 133], [386, 374, 362, 263]] };
const TURN = 12, NOD = 8;  // degrees
const DARK = 45;  // of 255
const SHARP = 0.5;  // of the median's contrast
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
const degrees = (y, x) => (180 / Math.PI) * Math.atan2(y, x);

function lookOf(points) {
  const at = (name) => points[POINT[name]];
  const across = [at("left")[0] - at("right")[0], at("left")[2] - at("right")[2]];
  const down = [at("chin")[1] - at("brow")[1], at("chin")[2] - at("brow")[2]];
  const width = distance(at("mouthLeft"), at("mouthRight"));
  return {
    turn: degrees(across[1], across[0]),
    nod: degrees(down[1], down[0]),
    open: distance(at("lipUp"), at("lipDown")) / width,
    smile: width / distance(at("left"), at("right")),
    lids: POINT.lids.reduce((sum, [up, low, a, b]) => sum + distance(points[up], points[low]) / distance(points[a], points[b]) / 2, 0),
  };
}

const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];
const STRAIGHT = 10;  // frames
const TALK = 6;  // times that the mouth opens

// Each: what to say, and whether it is in a look beside the straight ones' mean.
const WISHES = [
  ["Look straight into the camera", (look, rest, film) => film.rest.length >= STRAIGHT],
  ["Turn your head to one side", (look, rest) => look.turn - rest.turn > TURN],
  ["and to the other", (look, rest) => look.turn - rest.turn < -TURN],
  ["Look up", (look, rest) => Math.abs(look.nod - rest.nod) > NOD],
  ["Smile", (look, rest) => look.smile > 1.12 * rest.smile],
  ["Open your mouth wide", (look) => look.open > 0.4],
  ["Blink", (look, rest) => look.lids < 0.5 * rest.lids],
  ["Talk a little", (look, rest, film) => film.opened >= TALK],
];
export const wishes = WISHES.map(([text]) => text);

export class Film {
  constructor() {
    this.seen = WISHES.map(() => false);
    this.rest = [];
    this.contrasts = [];
    this.opened = 0;
    this.sides = new Array(8).fill(false);  // of the ring: where the head was turned to
  }
  // Of a frame's points: what is new is noted. Gives the look beside the straight one.
  note(points) {
    const look = lookOf(points);
    if (this.rest.length < STRAIGHT) this.rest.push(look);
    const rest = Object.fromEntries(Object.keys(look).map((key) => [key, median(this.rest.map((each) => each[key]))]));
    const open = look.open > 0.15;
    if (open && !this.wasOpen) ++this.opened;
    this.wasOpen = open;
    for (const [i, [, test]] of WISHES.entries()) this.seen[i] ||= test(look, rest, this);
    const turn = look.turn - rest.turn, nod = look.nod - rest.nod;
    if (Math.hypot(turn / TURN, nod / NOD) > 1) this.sides[Math.floor((degrees(nod / NOD, turn / TURN) + 382.5) / 45) % 8] = true;
    return { turn, nod };
  }
  // Why a frame is of no use, or "". pixels: ImageData around the face.
  fault({ data, width }) {
    let sum = 0, contrast = 0;
    for (let i = 0; i + 4 * width + 4 < data.length; i += 4) {
      sum += data[i + 1];
      contrast += Math.abs(data[i + 1] - data[i + 5]) + Math.abs(data[i + 1] - data[i + 1 + 4 * width]);
    }
    const mean = (4 * sum) / data.length;
    if (mean < DARK) return "It is too dark";
    const sharp = contrast / (sum + 1);
    this.contrasts.push(sharp);
    return sharp < SHARP * median(this.contrasts) ? "Too fast: that was blurred" : "";
  }
}

function draw(ring, film) {
  const context = ring.getContext("2d"), half = ring.width / 2;
  context.clearRect(0, 0, ring.width, ring.height);
  context.lineWidth = 14;
  for (const [i, seen] of film.sides.entries()) {
    context.strokeStyle = seen ? "#3a7" : "#fff8";
    context.beginPath();
    const middle = (Math.PI / 4) * i;
    context.arc(half, half, half - 12, middle - 0.36, middle + 0.36);
    context.stroke();
  }
}

const SMALL = 96;  // px, of a face that is looked at for its sharpness

// video: shows the camera. use(number, bytes): a frame that counts. Ends once all was seen, after
// `most` frames, or when `signal` is aborted. Returns how many frames there are.
export async function film({ video, finder, ring, say, list, use, most = 240, least = 120, signal }) {
  const film = new Film();
  const whole = canvasFor(video), face = document.createElement("canvas");
  face.width = face.height = SMALL;
  const context = whole.getContext("2d"), small = face.getContext("2d", { willReadFrequently: true });
  const begun = performance.now();
  let count = 0;
  while (!signal.aborted && count < most && !(count >= least && film.seen.every(Boolean))) {
    await new Promise((resolve) => requestAnimationFrame(resolve));
    if (video.ended || video.srcObject?.getVideoTracks()[0]?.readyState === "ended") throw new Error("the camera has gone");
    context.drawImage(video, 0, 0, whole.width, whole.height);
    const { faces } = await finder.find(await createImageBitmap(whole), performance.now() - begun);
    if (faces.length === 0) {
      say("No face is seen");
      continue;
    }
    const xs = faces[0].map(([x]) => x), ys = faces[0].map(([, y]) => y);
    const [x, y] = [Math.min(...xs), Math.min(...ys)];
    small.drawImage(whole, x, y, Math.max(...xs) - x, Math.max(...ys) - y, 0, 0, SMALL, SMALL);
    const fault = film.fault(small.getImageData(0, 0, SMALL, SMALL));
    if (fault) {
      say(fault);
      continue;
    }
    film.note(faces[0]);
    const next = film.seen.indexOf(false);
    say(`${next < 0 ? "Go on a little" : WISHES[next][0]} (${count} frames)`);
    for (const [i, item] of [...list.children].entries()) item.classList.toggle("seen", film.seen[i]);
    draw(ring, film);
    await use(count++, await encode(whole));
  }
  return count;
}
