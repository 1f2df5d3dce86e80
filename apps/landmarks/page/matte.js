(async () => {
  const segmentation = new SelfieSegmentation({
    locateFile: (file) => new URL(`../packages/selfie_segmentation/${file}`, location.href).href,
  });
  segmentation.setOptions({ modelSelection: 0, useCpuInference: true, selfieMode: false });
  let matte = null;
  segmentation.onResults((results) => { matte = results.segmentationMask; });
  await segmentation.initialize();
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d");
  await answerFrames("matte", async (image) => {
    await segmentation.send({ image });
    context.clearRect(0, 0, width, height);
    context.drawImage(matte, 0, 0, width, height);
    return canvas.convertToBlob({ type: "image/png" });
  });
})();
