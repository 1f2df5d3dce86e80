(async () => {
  const mesh = await openFaceMesh(2);
  await answerFrames(async (image, follows) => {
    if (!follows) mesh.reset();  // or the face is looked for where it was
    const faces = await mesh.look(image);
    return JSON.stringify(faces.map((face) => face.map((p) => [p.x * width, p.y * height])));
  });
})();
