// cosplat_spoil_photographs SCENE OUT DIVISOR HOW: copies a COLMAP scene with images of 1/DIVISOR
// of their size, whose training views (all but every 8th by name) are spoiled: `gains` multiplies
// each channel of a photograph by a random factor from 0.7 to 1.3; `rectangles` paints three random
// rectangles on each and writes masks of them; `clean` does neither.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/rng.h"
#include "splat/io/dataset.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

constexpr float kGain = 0.3f;
constexpr int kRectangles = 3;
constexpr float kLargestSide = 0.4f;  // of the image's

void MultiplyByGains(Rng& rng, Image8& image) {
  std::array<float, 3> gains;
  for (float& gain : gains) gain = 1 + kGain * (2 * rng.Uniform() - 1);
  for (size_t i = 0; i < image.data.size(); ++i)
    image.data[i] = uint8_t(std::min(255.0f, float(image.data[i]) * gains[i % 3] + 0.5f));
}

// Returns the mask: black where it has painted.
Image8 PaintRectangles(Rng& rng, Image8& image) {
  Image8 mask(image.width, image.height, 1, 255);
  for (int k = 0; k < kRectangles; ++k) {
    const int width = 1 + int(kLargestSide * rng.Uniform() * float(image.width - 1));
    const int height = 1 + int(kLargestSide * rng.Uniform() * float(image.height - 1));
    const int left = int(rng.Below(uint64_t(image.width - width + 1)));
    const int top = int(rng.Below(uint64_t(image.height - height + 1)));
    const std::array<uint8_t, 3> color{
        uint8_t(rng.Below(256)), uint8_t(rng.Below(256)), uint8_t(rng.Below(256))};
    for (int y = top; y < top + height; ++y)
      for (int x = left; x < left + width; ++x) {
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = color[size_t(c)];
        mask.at(x, y, 0) = 0;
      }
  }
  return mask;
}

void Spoil(const std::string& source, const std::string& out, int divisor, const std::string& how) {
  if (how != "gains" && how != "rectangles" && how != "clean")
    throw Error("HOW", "is '" + how + "', expected gains, rectangles or clean");
  const SceneData scene = LoadScene(source, {.resolution = divisor, .eval = true});
  MakeDirectories(out + "/images");
  fs::copy(source + "/sparse", out + "/sparse", fs::copy_options::recursive);
  Rng rng{7};
  for (const auto* views : {&scene.train, &scene.test})
    for (const SceneView& view : *views) {
      const Image8 file = ReadImage(view.image_path);
      Image8 image = ResizeByArea(file, view.camera.width, view.camera.height);
      const fs::path name = fs::path(view.name).replace_extension(".png");
      if (views == &scene.train && how == "gains") MultiplyByGains(rng, image);
      if (views == &scene.train && how == "rectangles") {
        MakeDirectories(out + "/masks");
        WriteImage((fs::path(out) / "masks" / name).string(), PaintRectangles(rng, image));
      }
      // PNG, which loses nothing, under the name that the cameras have.
      const std::vector<uint8_t> png = EncodeImage(name.string(), image);
      WriteFileAtomically((fs::path(out) / "images" / view.name).string(),
                          std::string(png.begin(), png.end()));
    }
}

}  // namespace
}  // namespace cosplat

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: cosplat_spoil_photographs SCENE OUT DIVISOR HOW\n");
    return 2;
  }
  try {
    cosplat::Spoil(argv[1], argv[2], std::max(1, std::atoi(argv[3])), argv[4]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
