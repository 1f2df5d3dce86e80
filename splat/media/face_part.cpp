#include "splat/media/face_part.h"

#include <algorithm>
#include <vector>

#include "splat/media/image_filters.h"

namespace cosplat {
namespace {

struct Box {
  int left, top, right, bottom;  // px, the last ones excluded
};

Box PixelsOf(const FaceBox& face, int width, int height) {
  const auto at = [](double x, int size) { return int(std::clamp(x, 0., double(size))); };
  return {
      at(face.left, width), at(face.top, height), at(face.right, width), at(face.bottom, height)};
}

// The part with most pixels, within `box` if it has any there.
int MainPart(const ConnectedParts& parts, const Image8& matte, const std::optional<FaceBox>& face) {
  const auto most = [&](const Box& box) {
    std::vector<size_t> pixels(size_t(parts.count) + 1, 0);
    for (int y = box.top; y < box.bottom; ++y)
      for (int x = box.left; x < box.right; ++x)
        ++pixels[size_t(parts.labels[size_t(y) * matte.width + x])];
    pixels[0] = 0;
    const auto highest = std::max_element(pixels.begin(), pixels.end());
    return *highest == 0 ? 0 : int(highest - pixels.begin());
  };
  int part = face ? most(PixelsOf(*face, matte.width, matte.height)) : 0;
  if (part == 0) part = most({0, 0, matte.width, matte.height});
  return part;
}

// Holes that touch the face's box, or are smaller than this share of it, are filled.
constexpr double kSmallHole = 0.02;

void FillHoles(const FaceBox& face, Image8& inside, Image& matte) {
  Image8 outside = inside;
  for (uint8_t& value : outside.data) value = value == 0 ? 1 : 0;
  const ConnectedParts holes = PartsOf(outside);
  const int width = inside.width, height = inside.height;
  const Box box = PixelsOf(face, width, height);
  std::vector<char> open(size_t(holes.count) + 1, 0), in_face = open;
  std::vector<double> pixels(open.size(), 0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto hole = size_t(holes.labels[size_t(y) * width + x]);
      ++pixels[hole];
      if (x == 0 || y == 0 || x == width - 1 || y == height - 1) open[hole] = 1;
      if (x >= box.left && x < box.right && y >= box.top && y < box.bottom) in_face[hole] = 1;
    }
  const double small = kSmallHole * double(box.right - box.left) * (box.bottom - box.top);
  for (size_t i = 0; i < inside.data.size(); ++i) {
    const auto hole = size_t(holes.labels[i]);
    if (hole == 0 || open[hole] || !(in_face[hole] || pixels[hole] < small)) continue;
    inside.data[i] = 1;
    matte.data[i] = 1;
  }
}

}  // namespace

void LeaveToOthers(const FaceBox& face, const std::vector<FaceBox>& others, Image8& matte) {
  if (others.empty()) return;
  const auto distance = [](const FaceBox& box, int x, int y) {  // squared
    const double width = box.right - box.left, height = box.bottom - box.top;
    const double dx = x + 0.5 - (box.left + box.right) / 2;
    const double dy = y + 0.5 - (box.top + box.bottom) / 2;
    return (dx * dx + dy * dy) / std::max(width * height, 1e-6);
  };
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      const double ours = distance(face, x, y);
      for (const FaceBox& other : others)
        if (distance(other, x, y) < ours) matte.at(x, y, 0) = 0;
    }
}

Image PersonOf(const Image8& matte, const std::optional<FaceBox>& face, int reach) {
  Image8 inside(matte.width, matte.height, 1);
  for (size_t i = 0; i < matte.data.size(); ++i) inside.data[i] = matte.data[i] >= 128;
  const ConnectedParts parts = PartsOf(inside);
  const int part = MainPart(parts, matte, face);
  Image main(matte.width, matte.height, 1);
  for (size_t i = 0; i < main.data.size(); ++i)
    main.data[i] = part != 0 && parts.labels[i] == part ? 1.f : 0.f;
  // Soft hair goes further than that part, as far as the network sees any: not to other parts.
  Image8 any(matte.width, matte.height, 1);
  Image others(matte.width, matte.height, 1);
  for (size_t i = 0; i < any.data.size(); ++i) {
    any.data[i] = float(matte.data[i]) > 255 * kClearMatte;
    others.data[i] = parts.labels[i] != 0 && main.data[i] == 0 ? 1.f : 0.f;
  }
  const ConnectedParts soft = PartsOf(any);
  std::vector<char> kept(size_t(soft.count) + 1, 0);
  for (size_t i = 0; i < main.data.size(); ++i)
    if (main.data[i] > 0) kept[size_t(soft.labels[i])] = 1;
  const Image near = Dilated(main, reach), near_others = Dilated(others, reach);
  Image person(matte.width, matte.height, 1);
  for (size_t i = 0; i < main.data.size(); ++i) {
    inside.data[i] = main.data[i] > 0;
    const bool ours = near.data[i] > 0 || near_others.data[i] == 0;
    if (kept[size_t(soft.labels[i])] && ours && others.data[i] == 0)
      person.data[i] = float(matte.data[i]) / 255;
  }
  if (face) FillHoles(*face, inside, person);
  return person;
}

}  // namespace cosplat
