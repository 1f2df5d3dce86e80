// A camera moves an avatar, without anything from elsewhere: MediaPipe's points, by FaceFinder, as the
// scores of `cosplat webcam`.
import { FaceFinder } from "../../src/trainer.js";

const SIZE = { width: 640, height: 480 };

// element: a <cosplat-avatar>. Resolves when it is hidden; rejects when the camera has gone.
export async function drive(element, video, say) {
  const stream = await navigator.mediaDevices.getUserMedia({ video: { ...SIZE, facingMode: "user" } });
  const [track] = stream.getVideoTracks();
  let finder = null;
  try {
    video.classList.remove("plain");
    video.srcObject = stream;
    await video.play();
    say("Loading what finds your face");
    finder = await FaceFinder.open({ faces: 1 });
    element.setAttribute("drive", "frames");
    say("Look straight into the camera");
    let seen = 0, since = performance.now();
    while (element.checkVisibility() && track.readyState === "live") {
      await new Promise((resolve) => requestAnimationFrame(resolve));
      const time = performance.now();
      const image = await createImageBitmap(video), { width, height } = image;
      const { faces } = await finder.find(image, time);
      const now = performance.now();
      element.remote?.sendPoints({ camera: track.label, width, height, time, milliseconds: now - time, points: faces[0] ?? [] });
      seen += faces.length > 0;
      if (now - since < 1000) continue;
      say(seen > 0 ? `${((1e3 * seen) / (now - since)).toFixed(0)} faces per second` : "No face is seen", seen === 0);
      seen = 0;
      since = now;
    }
    if (element.checkVisibility()) throw new Error(`${track.label} has gone`);
  } finally {
    for (const each of stream.getTracks()) each.stop();
    finder?.close();
  }
}
