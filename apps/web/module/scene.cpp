// Static scenes for the page: a file -> splats -> pictures from an orbiting camera. The functions
// are called by apps/web/src/scene.js; what fails returns 0 and leaves its line in
// cosplat_scene_error.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>

#include "apps/viewer/orbit_camera.h"
#include "avatar/play/image_bytes.h"
#include "avatar/plugin/cosplat.h"
#include "avatar/plugin/splats.h"
#include "splat/base/error.h"
#include "splat/io/splat_file.h"
#include "splat/render/rasterizer.h"

struct cosplat_scene {
  explicit cosplat_scene(const std::string& path)
      : gaussians(ReadAloud(path)),
        orbit(cosplat::viewer::BeforeSplats(path, gaussians)),
        rasterizer(cosplat::MakeCpuRasterizer()),
        tape(rasterizer->MakeTape(false)) {}

  // What was made of odd values, or left out, is said in the browser's console.
  static cosplat::Gaussians ReadAloud(const std::string& path) {
    std::vector<std::string> notes;
    cosplat::Gaussians read = cosplat::ReadSplats(path, &notes);
    for (const std::string& note : notes)
      std::fprintf(stderr, "cosplat: %s\n", cosplat::Error(path, note).what());
    return read;
  }

  cosplat::Gaussians gaussians;
  cosplat::viewer::OrbitCamera orbit;
  std::unique_ptr<cosplat::Rasterizer> rasterizer;
  std::unique_ptr<cosplat::RenderTape> tape;
  cosplat::RenderedImage image;
  cosplat::ViewSplats splats;
};

namespace {

std::string scene_error;

template <class Action>
bool Try(const Action& action) {
  try {
    action();
    return true;
  } catch (const std::bad_alloc&) {
    scene_error = "out of memory";
  } catch (const std::exception& error) {
    scene_error = error.what();
  }
  return false;
}

}  // namespace

extern "C" {

const char* cosplat_scene_error() { return scene_error.c_str(); }

cosplat_scene* cosplat_scene_open(const char* path) {
  std::unique_ptr<cosplat_scene> scene;
  Try([&] { scene = std::make_unique<cosplat_scene>(path); });
  return scene.release();
}

void cosplat_scene_close(cosplat_scene* scene) { delete scene; }

uint32_t cosplat_scene_count(const cosplat_scene* scene) {
  return uint32_t(scene->gaussians.size());
}

void cosplat_scene_orbit(cosplat_scene* scene, float right, float up) {
  scene->orbit.Orbit(right, up);
}
void cosplat_scene_pan(cosplat_scene* scene, float right, float down) {
  scene->orbit.Pan(right, down);
}
void cosplat_scene_zoom(cosplat_scene* scene, float steps) { scene->orbit.Zoom(steps); }
void cosplat_scene_reset(cosplat_scene* scene) { scene->orbit.Reset(); }

// As cosplat_get_splats, by the camera for pictures of width by height pixels.
uint32_t cosplat_scene_splats(cosplat_scene* scene,
                              uint32_t width,
                              uint32_t height,
                              float blur_variance,
                              cosplat_splats* splats) {
  return Try([&] {
    const cosplat::Gaussians& gaussians = scene->gaussians;
    cosplat::plugin::WriteSplats(cosplat::ViewOf(gaussians),
                                 gaussians.basis,
                                 gaussians.degree,
                                 scene->orbit.At(int(width), int(height)),
                                 blur_variance,
                                 scene->splats,
                                 *splats);
  });
}

// Fills picture->pixels, of picture->width by height.
uint32_t cosplat_scene_render(cosplat_scene* scene, const cosplat_picture* picture) {
  return Try([&] {
    const cosplat::Camera camera = scene->orbit.At(int(picture->width), int(picture->height));
    cosplat::RenderSettings settings;
    settings.degree = scene->gaussians.degree;
    if (picture->alpha == COSPLAT_ALPHA_OPAQUE)
      std::copy_n(picture->background, 3, settings.background.begin());
    scene->rasterizer->Forward(cosplat::ViewOf(scene->gaussians),
                               scene->gaussians.basis,
                               camera,
                               settings,
                               scene->image,
                               *scene->tape);
    cosplat::WriteImageBytes(scene->image,
                             {static_cast<cosplat::AlphaMode>(picture->alpha), false},
                             static_cast<uint8_t*>(picture->pixels),
                             ptrdiff_t(4) * picture->width);
  });
}

}  // extern "C"
