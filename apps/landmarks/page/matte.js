(async () => {
  const segmentation = await openSegmentation(width, height);
  await answerFrames((image) => segmentation.look(image));
})();
