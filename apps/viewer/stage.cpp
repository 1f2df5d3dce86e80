#include "apps/viewer/stage.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "apps/viewer/mesh_view.h"
#include "avatar/play/image_bytes.h"
#include "splat/base/error.h"
#include "splat/gaussians.h"

namespace cosplat::viewer {
namespace {

constexpr std::array<float, 3> kNoBackground{0, 0, 0};

const std::array<float, 3>& BackgroundOf(const Shot& shot) {
  return shot.transparent ? kNoBackground : shot.background;
}
AlphaMode AlphaOf(const Shot& shot) {
  return shot.transparent ? AlphaMode::kStraight : AlphaMode::kOpaque;
}

}  // namespace

View ViewFromString(const std::string& text, const std::string& field) {
  const auto found = std::find(kViewNames.begin(), kViewNames.end(), text);
  if (found != kViewNames.end()) return View(found - kViewNames.begin());
  throw Error(field, "is '" + text + "', expected splats, ellipsoids, triangles or wire");
}

Stage::Stage(Content content, const SplatRenderers& renderers) : content_(std::move(content)) {
  if (content_.avatar) {
    Content::Avatar& avatar = *content_.avatar;
    player_ = std::make_unique<Player>(
        std::move(avatar.model), avatar.flame, PlayerSettings{false, renderers.avatar});
    const size_t faces = player_->avatar().mesh.faces.size();
    counts_ = {CountColors(CountPerFace(player_->avatar().embedding.triangle, faces)), false};
    wire_ = {std::vector<Rgb>(faces, kNoneColor), true};
  } else if (content_.levels) {
    level_renderer_ = std::make_unique<LevelRenderer>(std::move(*content_.levels));
  } else {
    SortByDegree(content_.scene);
    if (renderers.scene) {
      scene_renderer_ = renderers.scene(content_.scene);
      return;
    }
    rasterizer_ = MakeCpuRasterizer();
    tape_ = rasterizer_->MakeTape();
  }
}

WorldGaussians Stage::Posed(const Shot& shot) {
  if (level_renderer_) return ViewOf(level_renderer_->Select(shot.camera, {0}));
  if (!player_) return ViewOf(content_.scene);
  const AvatarModel& model = player_->avatar();
  return PosedView(model.gaussians, player_->GaussiansOf(placed_), model.color_frame);
}

const RenderedImage& Stage::Levels(const Shot& shot) {
  FrameBudget* const budget = shot.pace == Pace::kMoving    ? &moving_
                              : shot.pace == Pace::kResting ? &resting_
                                                            : nullptr;
  LevelLimits limits;
  if (budget) {
    limits.max = budget->max();
  } else {
    limits.coarseness = 0;
  }
  const auto start = std::chrono::steady_clock::now();
  const int degree = level_renderer_->levels().layout.degree;
  level_renderer_->Draw(shot.camera, {BackgroundOf(shot), degree}, limits, image_);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  if (budget) budget->Drawn(level_renderer_->drawn(), took.count());
  return image_;
}

const RenderedImage& Stage::Splats(const Shot& shot) {
  if (player_) return player_->Draw(placed_, shot.camera, BackgroundOf(shot));
  if (level_renderer_) return Levels(shot);
  const Gaussians& scene = content_.scene;
  const RenderSettings settings{BackgroundOf(shot), scene.degree};
  if (scene_renderer_) {
    scene_renderer_->Draw(shot.camera, settings, image_);
  } else {
    rasterizer_->Forward(ViewOf(scene), scene.basis, shot.camera, settings, image_, *tape_);
  }
  return image_;
}

void Stage::Surfaces(const Shot& shot, Image8& out) {
  buffer_.Clear(shot.camera.width, shot.camera.height);
  if (shot.view == View::kEllipsoids) {
    DrawEllipsoids(Posed(shot), shot.camera, buffer_);
  } else {
    DrawMesh(player_->VerticesOf(placed_),
             player_->avatar().mesh.faces,
             shot.view == View::kWire ? wire_ : counts_,
             shot.camera,
             buffer_);
  }
  Resolve(buffer_, shot.transparent ? nullptr : &shot.background, out);
}

void Stage::Prepare(const Shot& shot) {
  if (shot.camera.width < 1 || shot.camera.height < 1)
    throw Error(content_.title, "image", "has no pixels");
  if (NeedsMesh(shot.view) && !player_)
    throw Error(content_.title,
                "view",
                std::string(kViewNames[size_t(shot.view)]) +
                    " is only available for avatars; this is a scene");
  if (player_) player_->Pose(shot.face, placed_);
}

bool Stage::DrawsOnDevice(const Shot& shot) const {
  return shot.view == View::kSplats && (player_ ? player_->DrawsOnDevice() : bool(scene_renderer_));
}

void Stage::DrawToStay(const Shot& shot, std::unique_ptr<DeviceImage>& out) {
  Prepare(shot);
  const std::array<float, 3>& background = BackgroundOf(shot);
  if (player_) return player_->DrawToStay(placed_, shot.camera, background, AlphaOf(shot), out);
  scene_renderer_->DrawToStay(shot.camera, {background, content_.scene.degree}, AlphaOf(shot), out);
}

void Stage::Draw(const Shot& shot, Image8& out) {
  Prepare(shot);
  if (shot.view != View::kSplats) return Surfaces(shot, out);
  const RenderedImage& image = Splats(shot);
  out.width = image.width;
  out.height = image.height;
  out.channels = 4;
  out.data.resize(4 * out.pixels());
  WriteImageBytes(image, {AlphaOf(shot)}, out.data.data(), 4 * ptrdiff_t(out.width));
}

}  // namespace cosplat::viewer
