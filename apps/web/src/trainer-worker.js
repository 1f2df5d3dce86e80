// An avatar is made in this worker, by dist/trainer*.mjs: `cosplat avatar` of images in the module's
// file system. Messages, of trainer.js:
//
//   in   {open: {threads, modules}}, {file: {path, bytes}}, {run: [arguments]}, {found: [files]}
//   out  {opened}, {line}, {progress}, {avatar: bytes}, {files: [{path, bytes}]}, {ask}, {ended: {code, problem, memory}}
//
// ask: the page is to find faces and mattes. Where memory is shared this worker waits for it in the
// middle of the run; otherwise the run ends, and begins again with what was found.
const ASKED = 75;  // main.cpp's exit code
const KEPT = /^\/me\/(head\.npz|landmarks\.json|mattes\/|track\/(image|mask|flame_params)|avatar\/(checkpoint|config\.ini))/;
const BYTES_OF_FACES = 1 << 16;  // two faces' 478 points as text, and room

let module = null, asked = 0, known = [], arguments_ = [], problem = "";
const sent = new Map();  // the time at which a file was last written that was sent

function eachFile(folder, use) {
  const { FS } = module;
  for (const name of FS.readdir(folder)) {
    if (name.startsWith(".")) continue;
    const path = `${folder}/${name}`, stat = FS.stat(path);
    if (FS.isDir(stat.mode)) eachFile(path, use);
    else use(path, Number(stat.mtime));
  }
}

// What a later run goes on from, and the avatar.
function sendNew() {
  if (!module.FS.analyzePath("/me").exists) return;
  const files = [];
  eachFile("/me", (path, time) => {
    const avatar = path === "/me/avatar/avatar.glb";
    if (sent.get(path) === time || (!avatar && !KEPT.test(path))) return;
    sent.set(path, time);
    const bytes = module.FS.readFile(path);
    if (avatar) postMessage({ avatar: bytes });
    else files.push({ path, bytes });
  });
  if (files.length > 0) postMessage({ files });
}

// A progress bar of the command: "title [===   ] 12/300  detail  4.0 it/s  1:12 left".
const BAR = /^(?:\x1b\[K)?(\S.*?) \[=* *\] (\d+)\/(\d+)\s+(.*?)\s+[\d.]+ it\/s\s+(\d+):(\d+) left$/;
function say(line) {
  const bar = BAR.exec(line);
  if (bar) {
    const [, title, done, total, detail, minutes, seconds] = bar;
    postMessage({ progress: { title, done: +done, total: +total, detail, seconds: 60 * +minutes + +seconds } });
  } else if (line.replace("\x1b[K", "")) {
    problem = line.replace("\x1b[K", "");
    postMessage({ line: problem });
  }
  sendNew();
}

// Characters, since a bar is drawn over itself.
function lineReader() {
  let bytes = [];
  return (byte) => {
    if (byte !== 10 && byte !== 13) return bytes.push(byte);
    const line = new TextDecoder().decode(new Uint8Array(bytes));
    bytes = [];
    if (line) say(line);
  };
}

// Where the page writes what it found: [state, bytes of the faces' text], then the text, then mattes.
function waitForPage(request) {
  const { width, height, times, mattes } = request;
  const textBytes = times.length * BYTES_OF_FACES;
  const memory = new SharedArrayBuffer(8 + textBytes + (mattes ? times.length * width * height : 0));
  postMessage({ ask: { ...request, memory, textBytes } });
  const state = new Int32Array(memory, 0, 2);
  Atomics.wait(state, 0, 0);
  if (state[0] < 0) return null;
  const text = new Uint8Array(memory, 8, state[1]).slice();
  const matte = (k) => new Uint8Array(memory, 8 + textBytes + k * width * height, width * height);
  return [
    { name: "faces.json", bytes: text },
    ...(mattes ? times.map((_, k) => ({ name: `${k}.matte`, bytes: matte(k) })) : []),
  ];
}

// In place of apps/landmarks/detect.mjs.
function findFaces(argv) {
  const option = (name) => argv[argv.indexOf(`--${name}`) + 1];
  const folder = option("frames"), call = asked++;
  const write = (files) => {
    for (const { name, bytes } of files) module.FS.writeFile(`${folder}/${name}`, bytes);
    return 0;
  };
  if (known[call]) return write(known[call]);
  const times = JSON.parse(module.FS.readFile(`${folder}/times.json`, { encoding: "utf8" }));
  const images = times.map((_, k) => module.FS.readFile(`${folder}/${k}.jpg`));
  const mattes = option("jobs").includes("matte");
  const request = { images, times, mattes, width: Number(option("width")), height: Number(option("height")) };
  if (typeof SharedArrayBuffer === "function") {
    const found = waitForPage(request);
    return found ? write(found) : 1;
  }
  postMessage({ ask: request });
  return -1;
}

function run() {
  asked = 0;
  problem = "";
  let code = 1;
  try {
    code = module.callMain([...arguments_]);
  } catch (error) {
    problem = error?.message ?? String(error);
  }
  sendNew();
  if (code !== ASKED) postMessage({ ended: { code, problem: code === 0 ? "" : problem, memory: module.HEAPU8.length } });
}

async function open({ threads, modules }) {
  const name = threads > 1 ? "trainer-threads" : "trainer";
  const { default: create } = await import(new URL(`${name}.mjs`, modules).href);
  module = await create({
    threads: threads - 1,
    locateFile: (file) => new URL(file, modules).href,
    print: say,
    program: findFaces,
  });
  module.FS.getStream(2).tty.ops.put_char = (_, byte) => put(byte);
  const put = lineReader();
  postMessage({ opened: true });
}

function write({ path, bytes }) {
  const folder = path.slice(0, path.lastIndexOf("/"));
  if (folder) module.FS.mkdirTree(folder);
  module.FS.writeFile(path, bytes);
  sent.set(path, Number(module.FS.stat(path).mtime));
}

self.onmessage = async ({ data }) => {
  try {
    if (data.open) await open(data.open);
    else if (data.file) write(data.file);
    else if (data.found) {
      known.push(data.found);
      run();
    } else if (data.run) {
      arguments_ = data.run;
      known = [];
      run();
    }
  } catch (error) {
    postMessage({ ended: { code: 1, problem: error?.message ?? String(error) } });
  }
};
