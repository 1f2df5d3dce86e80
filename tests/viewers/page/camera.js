// Cameras of a reader's world from those of the model (world axes of OpenCV: right, down, forward).
//
// `signs`: how the reader shows a point of the model's world, per axis: (1, 1, 1) as the file of a
// PLY has it; (1, -1, -1) of formats that are turned to y up; an odd number of -1 for left-handed
// readers.
export function placed(view, signs) {
  const [position, right, down, forward] = [view.position, view.right, view.down, view.forward].map(
    (vector) => vector.map((value, k) => value * signs[k]),
  );
  return { position, right, up: down.map((x) => -x), back: forward.map((x) => -x), forward };
}

// OpenGL's projection, column-major, of a pinhole camera.
export function projection({ fx, fy, cx, cy, width, height }, near, far) {
  return [
    (2 * fx) / width, 0, 0, 0,
    0, (2 * fy) / height, 0, 0,
    1 - (2 * cx) / width, (2 * cy) / height - 1, (far + near) / (near - far), -1,
    0, 0, (2 * far * near) / (near - far), 0,
  ];
}

export const turnedUp = [1, -1, -1];
export const near = 0.05;
export const far = 2000;
