// Draws what the viewer shows: a model, a face, a camera and a view -> RGBA bytes.
//
// Content (loaded by the command) -> Stage; Shot (Session) -> Draw -> image, in the window's
// render thread (apps/viewer/render_worker.h) or, headless, in the command itself.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/mesh_view.h"
#include "apps/viewer/orbit_camera.h"
#include "apps/viewer/view.h"
#include "avatar/play/player.h"
#include "splat/render/scene_renderer.h"

namespace cosplat::viewer {

// A scene, or an avatar with the model that it is posed by.
struct Content {
  struct Avatar {
    AvatarModel model;  // with its mesh
    FlameModel flame;
    FlameParams rest;  // its root when nothing drives it; no expression
  };
  std::string title;                         // for people: the file or folder
  Gaussians scene;                           // empty for an avatar
  std::optional<Avatar> avatar;              // nothing for a scene
  std::array<float, 3> background{1, 1, 1};  // sRGB that it was evaluated on
  StartView start;

  size_t gaussian_count() const { return avatar ? avatar->model.size() : scene.size(); }
};

// Everything that an image depends on.
struct Shot {
  View view = View::kSplats;
  FlameParams face;  // of an avatar
  Camera camera;
  std::array<float, 3> background{1, 1, 1};
  bool transparent = false;  // no background: the image has alpha
};
bool SameShot(const Shot& a, const Shot& b);

// Who draws splats (avatar/play/avatar_renderer.h, splat/render/device.h); empty: the CPU, as it
// does all else.
struct SplatRenderers {
  AvatarRendererMaker avatar;
  SceneRendererMaker scene;
};

class Stage {
 public:
  // Throws Error for what its renderer does not draw.
  explicit Stage(Content content, const SplatRenderers& renderers = {});
  Stage(const Stage&) = delete;  // the player refers to the content's FLAME model
  Stage& operator=(const Stage&) = delete;

  // RGBA, straight alpha (255 over a background). Keeps the memory of `out`. Throws Error when the
  // shot's parameters are not finite, its image has no pixels, or its view needs a mesh and there
  // is none. One call at a time.
  void Draw(const Shot& shot, Image8& out);
  // Whether a device draws this.
  bool DrawsOnDevice(const Shot& shot) const;
  // The same image, which stays there. For what it DrawsOnDevice; `out`: null, or of this stage.
  void DrawToStay(const Shot& shot, std::unique_ptr<DeviceImage>& out);

 private:
  void Prepare(const Shot& shot);
  const RenderedImage& Splats(const Shot& shot);
  void Surfaces(const Shot& shot, Image8& out);
  WorldGaussians Posed();

  Content content_;  // without the avatar's model, which is the player's
  std::unique_ptr<SceneRenderer> scene_renderer_;  // null: the two below
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
  std::unique_ptr<Player> player_;
  PlacedAvatar placed_;
  MeshPaint counts_, wire_;
  SurfaceBuffer buffer_;
};

}  // namespace cosplat::viewer
