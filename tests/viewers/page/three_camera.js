// A camera of three.js that looks as the model's.
import * as THREE from "three";

import { far, near, placed, projection } from "./camera.js";

export function makeRenderer({ canvas, width, height }) {
  const renderer = new THREE.WebGLRenderer({
    canvas, antialias: false, alpha: false, preserveDrawingBuffer: true,
  });
  renderer.setPixelRatio(1);
  renderer.setSize(width, height, false);
  renderer.setClearColor(0x000000, 1);
  return renderer;
}

export function makeCamera() {
  const camera = new THREE.PerspectiveCamera(50, 1, near, far);
  camera.updateProjectionMatrix = () => {};
  return camera;
}

export function aim(camera, view, signs) {
  const { position, right, up, back } = placed(view, signs);
  const basis = new THREE.Matrix4().makeBasis(
    new THREE.Vector3(...right), new THREE.Vector3(...up), new THREE.Vector3(...back));
  camera.position.set(...position);
  camera.quaternion.setFromRotationMatrix(basis);
  camera.updateMatrixWorld(true);
  camera.projectionMatrix.fromArray(projection(view, near, far));
  camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
}
