// Held-out views: images written beside their images, and the figures over them.
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
  size_t views = 0;
  double psnr = 0, ssim = 0;
  std::optional<double> psnr_mask, psnr_mouth;
  std::map<std::string, double> other_psnr;  // of splats that are not the run's own: ours_N_NAME
  std::map<std::string, double> lpips;       // by net
  std::vector<std::string> dropped;  // what was measured earlier and is not kept, a line each
};

// Writes <set>/ours_N<suffix>/{renders,gt}/000ii.png (`set`: "test", or "train" for views that were
// trained on; a suffix for splats that are not the run's own) and, when `truth` has
// alpha, masks/000ii.png; both images over the background.
class TestImageWriter {
 public:
  TestImageWriter(const std::string& folder,
                  const std::string& set,
                  int iteration,
                  std::array<float, 3> background,
                  const std::string& suffix = "");
  const std::string& path() const { return path_; }
  const std::array<float, 3>& background() const { return background_; }
  void Write(const RenderedImage& rendered, const Image8& truth, const Rectangle* mouth = nullptr);
  // Writes regions.json when there were mouth rectangles.
  void Finish();

 private:
  std::string path_;
  std::array<float, 3> background_;
  int next_ = 0;
  std::string regions_;
};

// Reads test/ours_*/ of a run, writes results.json and per_view.json with all of them, returns the
// means of ours_<iteration>, or of the highest when that is negative. Throws Error when it is
// absent.
//
// With `lpips`, LPIPS_<net> is written as well, and once more as LPIPS, where other tools look for
// it. LPIPS that was measured earlier is kept if it is of the same images. `progress` is told the
// number of views done and of all.
TestSummary EvaluateTestImages(const std::string& folder,
                               int iteration = -1,
                               Lpips* lpips = nullptr,
                               const std::function<void(int done, int total)>& progress = {});

// "PSNR 29.31 dB  SSIM 0.9012  LPIPS (squeeze) 0.1479  (7 views)".
std::string ToString(const TestSummary& summary);

// Draws tracked frames of an avatar beside their images: used while training and by `render`.

class AvatarTestImages {
 public:
  // Keeps a reference to `flame`. The model must have its mesh.
  AvatarTestImages(AvatarModel model, const FlameModel& flame, PlayerSettings settings = {});

  // Renders the frame over the writer's background and writes it beside `truth`, with the mouth's
  // rectangle.
  void WriteTestImage(const TrackedFrame& frame, const Image8& truth, TestImageWriter& writer);

  Player& player() { return player_; }

 private:
  Player player_;
  MeshTopology topology_;
  RenderedImage image_;
};

}  // namespace cosplat
