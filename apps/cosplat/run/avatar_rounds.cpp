#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "apps/cosplat/options/avatar_options.h"
#include "apps/cosplat/run/html_page.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/track_run.h"
#include "avatar/train/refine_by_avatar.h"
#include "flame/eyelids.h"
#include "flame/model.h"
#include "flame/mouth.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Train-avatar's, as if its command line had these.
std::shared_ptr<AvatarOptions> SmallAvatarOptions(const std::string& flame) {
  const auto options = std::make_shared<AvatarOptions>();
  CLI::App command;
  options->DeclareTraining(command);
  std::vector<std::string> arguments{"--flame", flame, "--preset", "quick", "--iterations", "800"};
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
  command.parse(arguments);
  options->Settle(command);
  options->ResolveBackground(Background::kRandom);
  return options;
}

}  // namespace

std::vector<double> RefineByAvatars(const std::string& flame_file,
                                    TrackedVideo& video,
                                    const std::function<Image8(const TrackedFrame&)>& image,
                                    int rounds,
                                    bool quiet) {
  if (rounds == 0) return {};
  const auto options = SmallAvatarOptions(flame_file);
  FlameModel flame = WithMouth(LoadFlameModel(flame_file));
  TrackedVideo track = video;
  if (TracksEyelids(track)) {
    flame = WithEyelids(std::move(flame));
    EyelidsToExpression(flame, track);
  }
  AvatarRefinement settings;
  settings.avatar = options->avatar;
  settings.train = [&](float unit) { return options->ToSettings(unit); };
  settings.fit.draws = 12;
  settings.fit.place_prior = 5e-7;
  settings.fit.face_prior = 5e-8;
  settings.rounds = rounds;
  const std::vector<double> psnr =
      RefineByAvatar(flame, track, image, settings, ShowProgress("avatars", "steps", quiet));
  EyelidsFromExpression(flame, track);
  video = std::move(track);
  return psnr;
}

std::string AvatarRoundsText(const std::vector<double>& psnr) {
  if (psnr.empty()) return "not refined by small avatars, which takes mattes and 20 frames";
  std::string text = Format("frames that small avatars had not seen: {:.2f} dB", psnr[0]);
  for (size_t round = 1; round < psnr.size(); ++round)
    text += Format(", {:.2f} dB", psnr[round]) + " after round " + std::to_string(round);
  const size_t best = size_t(std::max_element(psnr.begin(), psnr.end()) - psnr.begin());
  if (best + 1 < psnr.size())
    text += best == 0 ? "; none is kept" : "; kept is round " + std::to_string(best);
  return text;
}

}  // namespace cosplat
