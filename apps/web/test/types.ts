// The declarations, used as a program would use them.
import { type Health, openAvatar, openScene, RemoteAvatar } from "../src/index.js";
import { usePlayCanvas } from "../src/playcanvas.js";
import { AvatarTrainer } from "../src/trainer.js";

const avatar = await openAvatar("avatar.glb", "flame.npz", { threads: 2 });
avatar.setParameters({ expression: [1, 2], jaw: new Float32Array([0.1, 0, 0]), time: 0 });
avatar.setCamera(avatar.orbitCamera(512, 512, { azimuth: 0.5 }));
const pixels: Uint8ClampedArray = avatar.render(512, 512, { alpha: "opaque", background: [1, 1, 1] });
avatar.send({ seq: 0, blendshapes: { jawOpen: pixels.length } });

const remote = await RemoteAvatar.open(new Blob([]), null);
const health: Health = await remote.health();
remote.setView({ width: health.accepted, background: null });
(await openScene("scene.ply")).orbit(0.1, 0);

usePlayCanvas({}, { deviceTypes: ["webgl2"] });
const opacity: number = avatar.splats(0).colors[3];
const element = document.createElement("cosplat-avatar");
element.addEventListener("error", (event) => console.log(event.message));
element.setAttribute("renderer", opacity > 0 ? "gpu" : element.drawing);
element.send("{}");
const trainer = await AvatarTrainer.open({ threads: 1 });
trainer.addFrame(0, new Uint8Array(1));
await trainer.make(["--quality", "draft"]);
// @ts-expect-error: there is no such joint
element.setParameters({ chin: [0, 0, 0] });
