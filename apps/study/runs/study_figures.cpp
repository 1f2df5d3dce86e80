#include "apps/study/runs/study_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr const char* kLpips = "LPIPS_";  // followed by the network's name
constexpr const char* kSogSize = "sog_mb";

std::set<std::string> KeysIn(const std::vector<StudyPoint>& points) {
  std::set<std::string> keys;
  for (const StudyPoint& point : points)
    for (const StudyLine& line : point.lines)
      for (const StudyFigures& figures : line.checkpoints)
        for (const auto& [key, value] : figures) keys.insert(key);
  return keys;
}

std::vector<StudyFigure> Present(std::vector<StudyFigure> figures,
                                 const std::set<std::string>& keys) {
  const auto absent = [&](const StudyFigure& figure) { return keys.count(figure.key) == 0; };
  figures.erase(std::remove_if(figures.begin(), figures.end(), absent), figures.end());
  return figures;
}

std::string Fixed(double value, int decimals) {
  if (decimals == 0) return WithThousands(size_t(value + 0.5));
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

}  // namespace

std::vector<StudyFigure> QualitiesIn(const std::vector<StudyPoint>& points) {
  const std::set<std::string> keys = KeysIn(points);
  std::vector<StudyFigure> figures = Present({{"PSNR", "PSNR", "dB", 2},
                                              {"PSNR_mask", "PSNR inside the mask", "dB", 2},
                                              {"PSNR_mouth", "PSNR of the mouth", "dB", 2},
                                              {"SSIM", "SSIM", "", 4}},
                                             keys);
  const std::string prefix = kLpips;
  for (const std::string& key : keys)
    if (key.rfind(prefix, 0) == 0)
      figures.push_back({key, "LPIPS (" + key.substr(prefix.size()) + ")", "", 4, true});
  return figures;
}

std::vector<StudyFigure> CostsIn(const std::vector<StudyPoint>& points) {
  return Present({{"gaussians", "Gaussians", "", 0, true},
                  {"ply_mb", "PLY size", "MB", 2, true},
                  {kSogSize, "SOG size", "MB", 2, true},
                  {"glb_mb", "avatar file", "MB", 2, true},
                  {"cpu_seconds", "training time", "processor s", 1, true},
                  {"fps", "drawing speed", "frames/s", 0, false}},
                 KeysIn(points));
}

std::string QualityKeyFor(const StudyFigure& quality, const StudyFigure& cost) {
  if (cost.key != kSogSize) return quality.key;
  if (quality.key == "PSNR") return "sog_psnr";
  return quality.key == "SSIM" ? "sog_ssim" : "";
}

std::string ToString(const std::optional<Estimate>& estimate, int decimals) {
  if (!estimate) return "-";
  const std::string mean = Fixed(estimate->mean, decimals);
  if (estimate->count < 2) return mean;
  return mean + " ± " + Fixed(estimate->error, decimals);
}

std::string SignedText(const std::optional<Estimate>& difference, int decimals) {
  if (!difference) return "-";
  Estimate positive = *difference;
  positive.mean = std::abs(positive.mean);
  return (difference->mean < 0 ? "−" : "+") + ToString(positive, decimals);
}

}  // namespace cosplat
