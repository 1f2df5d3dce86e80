(async () => {
  const mesh = new FaceMesh({
    locateFile: (file) => new URL(`../packages/face_mesh/${file}`, location.href).href,
  });
  mesh.setOptions({
    maxNumFaces: 2, refineLandmarks: true, useCpuInference: true, selfieMode: false,
  });
  let faces = [];
  mesh.onResults((results) => { faces = results.multiFaceLandmarks ?? []; });
  await mesh.initialize();
  await answerFrames(async (image, follows) => {
    if (!follows) mesh.reset();  // or the face is looked for where it was
    faces = [];
    await mesh.send({ image });
    return JSON.stringify(faces.map((face) => face.map((p) => [p.x * width, p.y * height])));
  });
})();
