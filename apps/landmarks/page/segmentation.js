// MediaPipe's selfie segmentation: look(image) gives a byte per pixel, 255 where the person is.
async function openSegmentation(width, height) {
  const segmentation = new SelfieSegmentation({
    locateFile: (file) => new URL(`../packages/selfie_segmentation/${file}`, location.href).href,
  });
  segmentation.setOptions({ modelSelection: 0, useCpuInference: true, selfieMode: false });
  let matte = null;
  segmentation.onResults((results) => { matte = results.segmentationMask; });
  await segmentation.initialize();
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  const look = async (image) => {
    await segmentation.send({ image });
    context.clearRect(0, 0, width, height);
    context.drawImage(matte, 0, 0, width, height);
    // Not convertToBlob: it waits for the browser to be idle, a second at a time in a page that draws
    // nothing.
    const { data } = context.getImageData(0, 0, width, height);
    return Uint8Array.from({ length: width * height }, (_, i) => data[4 * i + 3]);
  };
  return { look };
}
