// Held-out views: renders written next to their ground truth, and metrics computed from them.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "avatar/play/player.h"
#include "flame/topology.h"
#include "flame/track.h"
#include "splat/base/image.h"
#include "splat/eval/lpips.h"
#include "splat/eval/metrics.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

struct TestSummary {
  size_t views = 0, empty_views = 0;  // measured, and those that show nothing (HasContent)
  double psnr = 0, ssim = 0;          // of 0 views: not figures
  std::optional<double> psnr_mask, psnr_head, psnr_mouth;
  // Inside the mask, of views in which the head is turned from the camera by at most these degrees,
  // and by more than those before.
  std::map<double, double> psnr_turned;
  std::map<std::string, double> lpips;  // by network
  // Results of images other than the run's own, ours_N_NAME (splats given to `render`, fitted
  // frames), as text.
  std::map<std::string, std::string> others;
  std::vector<std::string> dropped;  // earlier measurements that were discarded, one line each
};

// Where a posed avatar is in an image, and how it is turned: what is measured apart.
struct HeadView {
  std::map<std::string, Crop> regions;  // "mouth", a box around it; "head", above the chin
  std::optional<double> turned;         // degrees, DegreesTurned
};
HeadView HeadViewOf(const std::vector<float>& vertices,
                    const AvatarModel& avatar,
                    const MeshTopology& topology,
                    const FlameModel& flame,
                    const TrackedFrame& frame);

// Writes <set>/ours_N<suffix>/{renders,gt}/000ii.png and, if `truth` has alpha or pixels to ignore,
// masks/000ii.png. Both images are composited over the background. `set` is "test", or "train" for
// training views; `suffix` marks splats other than the run's own.
class TestImageWriter {
 public:
  TestImageWriter(const std::string& folder,
                  const std::string& set,
                  int iteration,
                  std::array<float, 3> background,
                  const std::string& suffix = "");
  const std::string& path() const { return path_; }
  const std::array<float, 3>& background() const { return background_; }
  // Empty regions are left out. ignored: as in TrainFrame.
  void Write(const RenderedImage& rendered,
             const Image8& truth,
             const HeadView& head = {},
             const Image8& ignored = {});
  // Writes regions.json if there were any.
  void Finish();

 private:
  std::string path_;
  std::array<float, 3> background_;
  int next_ = 0;
  std::map<std::string, std::map<std::string, Crop>> regions_;  // by name and image
  std::map<std::string, double> turned_;                        // by image
};

// Reads test/ours_*/ of a run, writes results.json and per_view.json for all of them, and returns
// the means of ours_<iteration>. Throws Error if that folder is missing.
//
// With `lpips`, also writes LPIPS_<net>, and again as LPIPS, the name that other tools expect. An
// earlier LPIPS measurement is kept if the images are unchanged. `progress` is called with the
// number of views done and the total. Views that show nothing have no figures and are in no mean.
TestSummary EvaluateTestImages(const std::string& folder,
                               int iteration,
                               Lpips* lpips,
                               const std::function<void(int done, int total)>& progress = {});

// Writes the right halves of a test/ours_N of a run to test/ours_N_exposed, each with the exposure
// that brings the left half closest to the ground truth (NeRF-W's protocol, Martin-Brualla et al.
// 2021, section 4.1), inside its mask if it has one. Throws Error if there are no images.
void WriteExposed(const std::string& folder);

// "PSNR 29.31 dB  SSIM 0.9012  LPIPS (squeeze) 0.1479  (7 views)", or why there are no figures.
std::string ToString(const TestSummary& summary);

// Renders tracked frames of an avatar next to their ground truth, for training and `render`.
class AvatarTestImages {
 public:
  // Keeps a reference to `flame`, which must outlive it. The model must have its mesh.
  AvatarTestImages(AvatarModel model, const FlameModel& flame, PlayerSettings settings = {});

  // Renders the frame over the writer's background and writes it with `truth` and its regions.
  void WriteTestImage(const TrackedFrame& frame, const Image8& truth, TestImageWriter& writer);

  Player& player() { return player_; }

 private:
  const FlameModel& flame_;
  Player player_;
  MeshTopology topology_;
  RenderedImage image_;
};

}  // namespace cosplat
