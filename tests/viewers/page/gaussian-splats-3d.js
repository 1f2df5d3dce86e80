// mkkellogg's GaussianSplats3D on three.js.
import * as THREE from "three";
import * as GaussianSplats3D from "@mkkellogg/gaussian-splats-3d";

import { turnedUp } from "./camera.js";
import { aim, makeCamera, makeRenderer } from "./three_camera.js";

export async function open(job) {
  const renderer = makeRenderer(job);
  const camera = makeCamera();
  const viewer = new GaussianSplats3D.Viewer({
    selfDrivenMode: false, renderer, camera, useBuiltInControls: false,
    sharedMemoryForWorkers: false, gpuAcceleratedSort: false, integerBasedSort: false,
    halfPrecisionCovariancesOnGPU: false, sphericalHarmonicsDegree: 2,
    sceneRevealMode: GaussianSplats3D.SceneRevealMode.Instant, ignoreDevicePixelRatio: true,
    logLevel: GaussianSplats3D.LogLevel.Error,
  });
  const format = GaussianSplats3D.SceneFormat[job.format === "spz" ? "Spz" : "Ply"];
  const signs = job.format === "spz" ? turnedUp : [1, 1, 1];
  aim(camera, job.views[0], signs);
  await viewer.addSplatScene(job.url, {
    format, showLoadingUI: false, progressiveLoad: false, splatAlphaRemovalThreshold: 0,
  });
  return {
    canvas: job.canvas,
    look: (view) => aim(camera, view, signs),
    draw: async () => {
      viewer.update();
      viewer.render();
    },
  };
}
