// For pages.mjs: what webcam.js uses of @mediapipe/tasks-vision, with a face of its own.
export const FilesetResolver = { forVisionTasks: async () => ({}) };

export const FaceLandmarker = {
  createFromOptions: async () => ({
    detectForVideo(video, now) {
      if (!(video.videoWidth > 0)) throw new Error("the video has no picture");
      const turn = 0.3 * Math.sin(now / 700);
      const [c, s] = [Math.cos(turn), Math.sin(turn)];
      return {
        faceBlendshapes: [
          {
            categories: [
              { categoryName: "_neutral", score: 0 },
              { categoryName: "jawOpen", score: 0.5 - 0.5 * Math.cos(now / 300) },
            ],
          },
        ],
        // Column-major, about y.
        facialTransformationMatrixes: [{ rows: 4, columns: 4, data: [c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0, 0, -40, 1] }],
      };
    },
  }),
};
