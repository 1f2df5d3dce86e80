#include "apps/cosplat/run/test_images.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <vector>

#include "avatar/surface/silhouette.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/media/image_io.h"
#include "splat/train/loss/crop_loss.h"
#include "splat/train/loss/loss.h"
#include "splat/train/loss/photograph.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

constexpr const char* kMouth = "mouth";
constexpr const char* kHead = "head";
constexpr const char* kTurned = "turned";
constexpr const char* kLpips = "LPIPS";        // of the network measured last
constexpr const char* kLpipsOfNet = "LPIPS_";  // followed by the network's name

std::vector<std::string> SortedFiles(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".png") names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

// Metrics of one test/ours_N folder, by metric and image name.
using Figures = std::map<std::string, std::map<std::string, double>>;

// `empty`: counts the images that show nothing, which have no figures.
Figures EvaluateFolder(const std::string& folder,
                       Lpips* lpips,
                       const std::function<void()>& count_view,
                       size_t& empty) {
  Figures figures;
  Json regions = Json::object();
  if (fs::exists(folder + "/regions.json")) regions = ReadJson(folder + "/regions.json");
  const std::vector<std::string> names = SortedFiles(folder + "/renders"),
                                 truths = SortedFiles(folder + "/gt");
  if (const auto [render, truth] =
          std::mismatch(names.begin(), names.end(), truths.begin(), truths.end());
      render != names.end() || truth != truths.end()) {
    const bool lacks = render == names.end() || (truth != truths.end() && *truth < *render);
    throw Error(folder + (lacks ? "/renders/" + *truth : "/gt/" + *render),
                "is missing: `cosplat render` makes both");
  }
  for (const std::string& name : names) {
    const Image8 rendered = ReadImage(folder + "/renders/" + name);
    const Image8 truth = ReadImage(folder + "/gt/" + name);
    if (rendered.width != truth.width || rendered.height != truth.height)
      throw Error(folder + "/renders/" + name,
                  "is " + SizeText(rendered.width, rendered.height) + ", that in gt/ " +
                      SizeText(truth.width, truth.height));
    if (!HasContent(truth)) {
      ++empty;
      count_view();
      continue;
    }
    std::optional<Image8> mask;
    if (fs::exists(folder + "/masks/" + name)) mask = ReadImage(folder + "/masks/" + name);
    const auto region = [&](const char* of) -> std::optional<Crop> {
      if (!regions.contains(of) || !regions[of].contains(name)) return {};
      const std::vector<float> r =
          JsonField(folder + "/regions.json", regions)[of][name].Numbers(4);
      return Crop{int(r[0]), int(r[1]), int(r[2]), int(r[3])};
    };
    const ImageMetrics m = CompareImages(rendered, truth, mask ? &*mask : nullptr);
    figures["PSNR"][name] = m.psnr;
    figures["SSIM"][name] = m.ssim;
    const auto add = [&](const char* figure, const std::optional<double>& value) {
      if (value) figures[figure][name] = *value;
    };
    add("PSNR_mask", m.psnr_mask);
    add("PSNR_highlight", m.psnr_highlight);
    if (const auto mouth = region(kMouth)) {
      const Image8 all(truth.width, truth.height, 1, 255);
      add("PSNR_mouth", MaskedPsnr(rendered, truth, Inside(all, *mouth)));
    }
    if (const auto head = region(kHead); mask && head)
      add("PSNR_head", MaskedPsnr(rendered, truth, Inside(*mask, *head)));
    if (regions.contains(kTurned) && regions[kTurned].contains(name))
      figures[kTurned][name] = JsonField(folder + "/regions.json", regions)[kTurned][name].Number();
    if (lpips)
      figures[kLpips][name] = figures[kLpipsOfNet + lpips->net()][name] =
          lpips->Distance(rendered, truth);
    count_view();
  }
  return figures;
}

// An earlier evaluation, by folder. If it cannot be read, it is replaced and `dropped` says why.
std::map<std::string, Figures> ReadEarlier(const std::string& path,
                                           std::vector<std::string>& dropped) {
  std::map<std::string, Figures> earlier;
  if (!fs::exists(path)) return earlier;
  try {
    const JsonField json(path, ReadJson(path));
    for (const auto& [name, figures] : json.raw().items())
      for (const auto& [figure, values] : figures.items())
        for (const auto& [view, value] : values.items())
          earlier[name][figure][view] = json[name][figure][view].Number();
  } catch (const Error& error) {
    dropped.push_back(error.what());
    earlier.clear();
  }
  return earlier;
}

// Adds the LPIPS values that `earlier` has for other networks, if they are of the same images, that
// is if PSNR and SSIM of every view are bit-identical. Returns the names of the values not kept.
std::string KeepLpips(Figures& earlier, Figures& figures) {
  if (figures.empty()) return "";
  const bool same = earlier["PSNR"] == figures["PSNR"] && earlier["SSIM"] == figures["SSIM"];
  std::string dropped;
  for (const auto& [figure, values] : earlier) {
    if (figure.rfind(kLpips, 0) != 0 || figures.count(figure)) continue;
    if (same)
      figures[figure] = values;
    else
      dropped += (dropped.empty() ? "" : ", ") + figure;
  }
  return dropped;
}

double Mean(const std::map<std::string, double>& values) {
  double sum = 0;
  for (const auto& [name, value] : values) sum += value;
  return values.empty() ? 0 : sum / double(values.size());
}

// Around 0 to 15, 30, 45, 60, 90 and 180 degrees.
constexpr std::array<double, 6> kTurnLimits{22, 38, 52, 75, 135, 180};

std::map<double, double> PsnrByTurn(const Figures& figures) {
  std::map<double, std::map<std::string, double>> by_turn;
  for (const auto& [name, degrees] : figures.at(kTurned)) {
    const auto psnr = figures.at("PSNR_mask").find(name);
    const auto limit = std::lower_bound(kTurnLimits.begin(), kTurnLimits.end(), degrees);
    if (psnr != figures.at("PSNR_mask").end() && limit != kTurnLimits.end())
      by_turn[*limit][name] = psnr->second;
  }
  std::map<double, double> means;
  for (const auto& [limit, values] : by_turn) means[limit] = Mean(values);
  return means;
}

void Summarize(const Figures& figures, size_t empty, TestSummary& summary) {
  summary.empty_views = empty;
  summary.views = figures.empty() ? 0 : figures.at("PSNR").size();
  if (summary.views == 0) return;
  summary.psnr = Mean(figures.at("PSNR"));
  summary.ssim = Mean(figures.at("SSIM"));
  if (figures.count("PSNR_mask")) summary.psnr_mask = Mean(figures.at("PSNR_mask"));
  if (figures.count("PSNR_head")) summary.psnr_head = Mean(figures.at("PSNR_head"));
  if (figures.count("PSNR_mouth")) summary.psnr_mouth = Mean(figures.at("PSNR_mouth"));
  if (figures.count(kTurned) && figures.count("PSNR_mask"))
    summary.psnr_turned = PsnrByTurn(figures);
  const size_t prefix = std::string(kLpipsOfNet).size();
  for (const auto& [figure, values] : figures)
    if (figure.rfind(kLpipsOfNet, 0) == 0) summary.lpips[figure.substr(prefix)] = Mean(values);
}

// The folders ours_N that contain images, and the number of images in each.
std::map<std::string, int> CountViews(const std::string& folder) {
  std::map<std::string, int> views;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("ours_", 0) != 0) continue;
    const size_t count = SortedFiles(entry.path().string() + "/renders").size();
    if (count > 0) views[name] = int(count);
  }
  return views;
}

}  // namespace

HeadView HeadViewOf(const std::vector<float>& vertices,
                    const AvatarModel& avatar,
                    const MeshTopology& topology,
                    const FlameModel& flame,
                    const TrackedFrame& frame) {
  const Camera& camera = frame.camera;
  return {{{kMouth,
            MouthBox(vertices, avatar.mesh.vertices, topology, flame.own_vertex_count(), camera)},
           {kHead, {0, 0, camera.width, ChinRow(vertices, flame, camera)}}},
          DegreesTurned(frame.params, frame.camera)};
}

TestImageWriter::TestImageWriter(const std::string& folder,
                                 const std::string& set,
                                 int iteration,
                                 std::array<float, 3> background,
                                 const std::string& suffix)
    : path_(Format("{}/{}/ours_{}{}", folder, set, iteration, suffix)), background_(background) {
  for (const char* sub : {"/renders", "/gt", "/masks"}) {
    std::error_code ignored;
    fs::remove_all(path_ + sub, ignored);  // or images of an earlier run would be counted
  }
  MakeDirectories(path_ + "/renders");
  MakeDirectories(path_ + "/gt");
}

void TestImageWriter::Write(const RenderedImage& rendered,
                            const Image8& truth,
                            const HeadView& head,
                            const Image8& ignored) {
  const std::string name = Format("{:05d}.png", next_++);
  WriteImage(path_ + "/renders/" + name, ToBytes(rendered.ToImage()));
  WriteImage(path_ + "/gt/" + name, OverBackground(truth, background_));
  if (truth.channels == 4 || !ignored.empty()) {
    MakeDirectories(path_ + "/masks");
    Image8 mask(truth.width, truth.height, 1, 255);
    for (size_t i = 0; i < mask.pixels(); ++i) {
      if (truth.channels == 4) mask.data[i] = truth.data[4 * i + 3];
      if (!ignored.empty() && ignored.data[i]) mask.data[i] = 0;
    }
    WriteImage(path_ + "/masks/" + name, mask);
  }
  for (const auto& [region, r] : head.regions)
    if (!r.empty()) regions_[region][name] = r;
  if (head.turned) turned_[name] = *head.turned;
}

void TestImageWriter::Finish() {
  if (regions_.empty() && turned_.empty()) return;
  Json json;
  if (!turned_.empty()) json[kTurned] = turned_;
  for (const auto& [region, images] : regions_)
    for (const auto& [name, r] : images) json[region][name] = {r.x, r.y, r.width, r.height};
  WriteFileAtomically(path_ + "/regions.json", json.dump(1) + "\n");
}

TestSummary EvaluateTestImages(const std::string& folder,
                               int iteration,
                               Lpips* lpips,
                               const std::function<void(int done, int total)>& progress) {
  const std::map<std::string, int> views = CountViews(folder + "/test");
  if (views.empty())
    throw Error(
        folder, "test", "contains no images: train with --eval or run `cosplat render` first");
  const std::string own = Format("ours_{}", iteration);
  if (!views.count(own))
    throw Error(folder, "test", "contains no " + own + ": run `cosplat render` first");
  TestSummary summary;
  auto earlier = ReadEarlier(folder + "/per_view.json", summary.dropped);
  Json results = Json::object(), per_view = Json::object();
  int done = 0, total = 0;
  for (const auto& [name, count] : views) total += count;
  for (const auto& [name, count] : views) {
    size_t empty = 0;
    const auto count_view = [&] {
      if (progress) progress(++done, total);
    };
    Figures figures = EvaluateFolder(folder + "/test/" + name, lpips, count_view, empty);
    results[name] = per_view[name] = Json::object();
    const std::string dropped = KeepLpips(earlier[name], figures);
    if (!dropped.empty())
      summary.dropped.push_back(name + ": " + dropped + " of images that have changed since");
    for (const auto& [figure, values] : figures) {
      results[name][figure] = Mean(values);
      per_view[name][figure] = values;
    }
    if (name == own) {
      Summarize(figures, empty, summary);
    } else if (name != "ours_" + std::to_string(std::atoi(name.c_str() + 5))) {
      TestSummary other;
      Summarize(figures, empty, other);
      summary.others[name] = ToString(other);
    }
  }
  WriteFileAtomically(folder + "/results.json", results.dump(2) + "\n");
  WriteFileAtomically(folder + "/per_view.json", per_view.dump(2) + "\n");
  return summary;
}

void WriteExposed(const std::string& folder) {
  const std::vector<std::string> names = SortedFiles(folder + "/renders");
  if (names.empty())
    throw Error(folder, "contains no images: train with --eval or run `cosplat render` first");
  const std::string out = folder + "_exposed";
  for (const char* sub : {"/renders", "/gt", "/masks"}) {
    std::error_code ignored;
    fs::remove_all(out + sub, ignored);  // or images of an earlier run would be counted
    if (fs::exists(folder + sub)) MakeDirectories(out + sub);
  }
  for (const std::string& name : names) {
    const Image8 rendered = ReadImage(folder + "/renders/" + name);
    const Image8 truth = ReadImage(folder + "/gt/" + name);
    const bool masked = fs::exists(folder + "/masks/" + name);
    const Image8 mask = masked ? ReadImage(folder + "/masks/" + name) : Image8();
    const int middle = rendered.width / 2;
    const auto in_mask = [&](size_t i) { return !masked || mask.data[i] == 255; };
    std::vector<uint8_t> use(rendered.pixels(), 0);
    for (size_t i = 0; i < use.size(); ++i)
      use[i] = int(i % size_t(rendered.width)) < middle && in_mask(i);
    Buffer<float> as_drawn, target;
    CompositeTarget(rendered, {}, as_drawn);
    CompositeTarget(truth, {}, target);
    RenderedImage shown{rendered.width, rendered.height, as_drawn, {}};
    ApplyExposure(FitExposure(as_drawn, target, use), shown.color.view());
    for (size_t i = 0; i < as_drawn.size(); ++i)
      if (!in_mask(i % use.size())) shown.color[i] = as_drawn[i];
    const Crop right{middle, 0, rendered.width - middle, rendered.height};
    const auto write = [&](const char* sub, const Image8& image) {
      WriteImage(out + sub + "/" + name, Cropped(image, right));
    };
    write("/renders", ToBytes(shown.ToImage()));
    write("/gt", truth);
    if (masked) write("/masks", mask);
  }
}

std::string ToString(const TestSummary& s) {
  if (s.views == 0)
    return "no figures: each of the " + std::to_string(s.empty_views) +
           " test images is all of one colour, as under an empty mask";
  std::string out = Format("PSNR {:.2f} dB  SSIM {:.4f}", s.psnr, s.ssim);
  if (s.psnr_mask) out += Format("  inside the mask {:.2f} dB", *s.psnr_mask);
  if (s.psnr_head) out += Format("  head {:.2f} dB", *s.psnr_head);
  if (s.psnr_mouth) out += Format("  mouth {:.2f} dB", *s.psnr_mouth);
  if (s.psnr_turned.size() > 1)
    for (const auto& [limit, psnr] : s.psnr_turned)
      out += Format("  turned to {:.0f} deg {:.2f} dB", limit, psnr);
  for (const auto& [net, value] : s.lpips) out += Format("  LPIPS ({}) {:.4f}", net, value);
  out += "  (" + std::to_string(s.views) + " views";
  if (s.empty_views > 0) out += Format("; {} of one colour are not measured", s.empty_views);
  return out + ")";
}

AvatarTestImages::AvatarTestImages(AvatarModel model,
                                   const FlameModel& flame,
                                   PlayerSettings settings)
    : flame_(flame),
      player_(std::move(model), flame, settings),
      topology_(BuildTopology(
          "avatar", player_.avatar().mesh.faces, int(player_.avatar().mesh.vertices.size() / 3))) {}

void AvatarTestImages::WriteTestImage(const TrackedFrame& frame,
                                      const Image8& truth,
                                      TestImageWriter& writer) {
  player_.RenderOver(frame.params, frame.camera, writer.background(), image_);
  writer.Write(
      image_, truth, HeadViewOf(player_.vertices(), player_.avatar(), topology_, flame_, frame));
}

}  // namespace cosplat
