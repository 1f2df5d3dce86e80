// Renders what the viewer shows: a model, a face, a camera and a view -> RGBA bytes.
//
// Content (loaded by the command) -> Stage; Shot (Session) -> Draw -> image, in the window's render
// thread (apps/viewer/render_worker.h) or, headless, in the command itself.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/mesh_view.h"
#include "apps/viewer/orbit_camera.h"
#include "avatar/play/player.h"
#include "splat/levels/frame_budget.h"
#include "splat/levels/level_renderer.h"
#include "splat/render/scene_renderer.h"

namespace cosplat::viewer {

enum class View { kSplats, kEllipsoids, kTriangles, kWire };
constexpr int kViewCount = 4;
constexpr std::array<const char*, kViewCount> kViewNames{
    "splats", "ellipsoids", "triangles", "wire"};  // in the order of View

// Triangles and wire show the mesh, which scenes do not have.
constexpr bool NeedsMesh(View view) { return view == View::kTriangles || view == View::kWire; }

// Throws Error, naming `field`, if `text` is none of the names.
View ViewFromString(const std::string& text, const std::string& field);

// A scene, or an avatar with the FLAME model that poses it.
struct Content {
  struct Avatar {
    AvatarModel model;  // with its mesh
    FlameModel flame;
    FlameParams rest;  // its root if nothing drives it; no expression
  };
  std::string title;                         // displayed name: the file or folder
  Gaussians scene;                           // empty for an avatar, or with levels
  std::optional<SceneLevels> levels;         // of a scene that is too large to be drawn whole
  std::optional<Avatar> avatar;              // nullopt for a scene
  std::array<float, 3> background{1, 1, 1};  // sRGB, used in evaluation
  StartView start;

  size_t gaussian_count() const {
    return avatar ? avatar->model.size() : levels ? levels->size() : scene.size();
  }
};

// How long drawing may take, by leaving out detail of a scene with levels.
enum class Pace {
  kExact,    // as long as it takes
  kResting,  // half a second, for the next drag may be waiting
  kMoving    // 40 ms
};

// All inputs of an image.
struct Shot {
  View view = View::kSplats;
  FlameParams face;  // for an avatar
  Camera camera;
  std::array<float, 3> background{1, 1, 1};
  bool transparent = false;  // no background: the image has alpha
  Pace pace = Pace::kExact;  // of a scene with levels, in the view kSplats

  bool operator==(const Shot&) const = default;
};

// Renderers for splats (avatar/play/avatar_renderer.h, splat/render/device.h). If empty, splats are
// rendered on the CPU, as all other views always are.
struct SplatRenderers {
  AvatarRendererMaker avatar;
  SceneRendererMaker scene;
};

class Stage {
 public:
  // Throws Error if the renderer does not support the content.
  explicit Stage(Content content, const SplatRenderers& renderers = {});
  Stage(const Stage&) = delete;  // the player refers to the content's FLAME model
  Stage& operator=(const Stage&) = delete;

  // RGBA, straight alpha (255 over a background). Reuses the memory of `out`. Throws Error if the
  // shot's parameters are non-finite, its image has no pixels, or its view needs a mesh and there
  // is none. Not thread-safe.
  void Draw(const Shot& shot, Image8& out);
  // Whether a shot's pace has an effect in this view.
  bool KeepsPace(View view) const { return level_renderer_ && view == View::kSplats; }
  // Whether this shot is rendered on a device.
  bool DrawsOnDevice(const Shot& shot) const;
  // Renders the same image but leaves it on the device. Only if DrawsOnDevice; `out`: null, or an
  // image of this stage.
  void DrawToStay(const Shot& shot, std::unique_ptr<DeviceImage>& out);

 private:
  void Prepare(const Shot& shot);
  const RenderedImage& Splats(const Shot& shot);
  const RenderedImage& Levels(const Shot& shot);
  void Surfaces(const Shot& shot, Image8& out);
  WorldGaussians Posed(const Shot& shot);

  Content content_;  // without the avatar's model, which is moved into the player
  std::unique_ptr<LevelRenderer> level_renderer_;  // of a scene with levels
  FrameBudget resting_{500}, moving_{40};
  std::unique_ptr<SceneRenderer> scene_renderer_;  // if both are null, the next two are used
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
  std::unique_ptr<Player> player_;
  PosedAvatar placed_;
  MeshPaint counts_, wire_;
  SurfaceBuffer buffer_;
};

}  // namespace cosplat::viewer
