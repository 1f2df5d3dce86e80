// Spark on three.js.
import * as THREE from "three";
import { SparkRenderer, SplatMesh } from "@sparkjsdev/spark";

import { turnedUp } from "./camera.js";
import { aim, makeCamera, makeRenderer } from "./three_camera.js";

export async function open(job) {
  const renderer = makeRenderer(job);
  const scene = new THREE.Scene();
  const camera = makeCamera();
  // By itself it adds 0.3 square pixels, but takes the opacity back that this adds. As trained: no
  // taking back, splats sorted by depth and drawn to three standard deviations, and 32 bits where it
  // packs to 16 otherwise.
  const spark = new SparkRenderer(job.blur === "trained"
    ? { renderer, preBlurAmount: 0.3, blurAmount: 0, sortRadial: false, maxStdDev: 3,
        accumExtSplats: true }
    : { renderer });
  scene.add(spark);
  const mesh = new SplatMesh({ url: job.url, fileName: job.url, extSplats: job.blur === "trained" });
  await mesh.initialized;
  scene.add(mesh);
  const signs = job.format === "spz" ? turnedUp : [1, 1, 1];
  return {
    canvas: job.canvas,
    look: (view) => aim(camera, view, signs),
    draw: async () => renderer.render(scene, camera),
  };
}
