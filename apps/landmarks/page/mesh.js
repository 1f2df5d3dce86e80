// MediaPipe's face mesh: look(image) gives the faces in it, each 478 points in shares of the image's
// width (x, z) and height (y). reset() forgets where the faces were.
async function openFaceMesh(maxNumFaces) {
  const mesh = new FaceMesh({
    locateFile: (file) => new URL(`../packages/face_mesh/${file}`, location.href).href,
  });
  mesh.setOptions({ maxNumFaces, refineLandmarks: true, useCpuInference: true, selfieMode: false });
  let faces = [];
  mesh.onResults((results) => { faces = results.multiFaceLandmarks ?? []; });
  await mesh.initialize();
  const look = async (image) => {
    faces = [];
    await mesh.send({ image });
    return faces;
  };
  return { look, reset: () => mesh.reset() };
}
