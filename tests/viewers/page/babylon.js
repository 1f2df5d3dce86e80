// Babylon.js, whose world is left-handed.
import { Engine } from "@babylonjs/core/Engines/engine.js";
import { Scene } from "@babylonjs/core/scene.js";
import { Color4 } from "@babylonjs/core/Maths/math.color.js";
import { Matrix, Vector3 } from "@babylonjs/core/Maths/math.vector.js";
import { FreeCamera } from "@babylonjs/core/Cameras/freeCamera.js";
import { ImportMeshAsync } from "@babylonjs/core/Loading/sceneLoader.js";
import "@babylonjs/core/Meshes/GaussianSplatting/gaussianSplattingMesh.js";
import "@babylonjs/loaders/SPLAT/index.js";
import "@babylonjs/loaders/glTF/2.0/index.js";
import { GaussianSplattingMaterial } from "@babylonjs/core/Materials/GaussianSplatting/gaussianSplattingMaterial.js";
import * as fflate from "fflate";

import { far, near, placed } from "./camera.js";

// How Babylon shows a point of each format (camera.js).
const shown = { ply: [1, -1, 1], sog: [1, -1, 1], spz: [1, 1, -1], glb: [-1, -1, -1] };

export async function open(job) {
  // It projects to pixels of half the size before it adds 0.3 of their area, a quarter of what 3DGS
  // trains with.
  if (job.blur === "trained") GaussianSplattingMaterial.KernelSize = 1.2;
  const engine = new Engine(job.canvas, false, { preserveDrawingBuffer: true, alpha: false });
  const scene = new Scene(engine);
  scene.clearColor = new Color4(0, 0, 0, 1);
  const camera = new FreeCamera("camera", Vector3.Zero(), scene);
  camera.minZ = near;
  camera.maxZ = far;
  await ImportMeshAsync(job.url, scene, {
    pluginExtension: `.${job.format}`,
    pluginOptions: { splat: { fflate, spzLibraryUrl: undefined, disableAutoCameraLimits: true } },
  });
  scene.activeCamera = camera;
  return {
    canvas: job.canvas,
    look: (view) => {
      const { position, up, forward } = placed(view, shown[job.format]);
      camera.position = new Vector3(...position);
      camera.upVector = new Vector3(...up);
      camera.setTarget(camera.position.add(new Vector3(...forward)));
      const { fx, fy, cx, cy, width, height } = view;
      camera.freezeProjectionMatrix(Matrix.FromValues(
        (2 * fx) / width, 0, 0, 0,
        0, (2 * fy) / height, 0, 0,
        (2 * cx) / width - 1, 1 - (2 * cy) / height, (far + near) / (far - near), 1,
        0, 0, (-2 * far * near) / (far - near), 0));
    },
    draw: async () => {
      engine.beginFrame();
      scene.render();
      engine.endFrame();
    },
  };
}
