#include "apps/cosplat/run/frame_source.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <string_view>
#include <utility>

#include "splat/base/data_files.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/media/frame_cuts.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxKeptBytes = size_t(512) << 20;

// Compares runs of digits by their values.
bool CountedBefore(const std::string& a, const std::string& b) {
  size_t i = 0, k = 0;
  const auto digit = [](const std::string& s, size_t at) {
    return at < s.size() && std::isdigit(static_cast<unsigned char>(s[at])) != 0;
  };
  const auto number = [&](const std::string& s, size_t& at) {
    while (at < s.size() && s[at] == '0') ++at;
    const size_t begin = at;
    while (digit(s, at)) ++at;
    return s.substr(begin, at - begin);
  };
  while (i < a.size() && k < b.size()) {
    if (digit(a, i) && digit(b, k)) {
      const std::string x = number(a, i), y = number(b, k);
      if (x != y) return x.size() != y.size() ? x.size() < y.size() : x < y;
    } else if (a[i] != b[k]) {
      return a[i] < b[k];
    } else {
      ++i, ++k;
    }
  }
  return std::pair(a.size() - i, std::string_view(a)) <
         std::pair(b.size() - k, std::string_view(b));
}

std::vector<std::string> ImagesIn(const std::string& folder) {
  std::vector<std::string> images;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (IsImageName(entry.path().string())) images.push_back(entry.path().string());
  }
  std::sort(images.begin(), images.end(), CountedBefore);
  return images;
}

// Of four channels. Codecs make 254 of 255.
bool ShowsThrough(const Image8& image) {
  for (size_t i = 3; i < image.data.size(); i += 4)
    if (image.data[i] < 128) return true;
  return false;
}

}  // namespace

FrameSource::FrameSource(const std::string& path, Bars bars) {
  Open(path);
  in_file_ = {0, 0, width_, height_};
  EndAt(in_file_);
  if (bars == Bars::kFind) EndAt(FindPicture());
}

void FrameSource::Open(const std::string& path) {
  if (!fs::is_directory(path)) {
    video_ = std::make_unique<VideoReader>(path);
    files_ = {path};
    const Image8 first = video_->ReadFrame(0);
    width_ = first.width, height_ = first.height;
    frames_per_second_ = video_->frames_per_second();
    has_alpha_ = video_->has_alpha();
    return;
  }
  files_ = ImagesIn(path);
  if (files_.empty()) throw Error(path, "holds no images");
  std::map<std::string, std::string> names;
  for (const std::string& file : files_)
    if (const auto [at, added] = names.insert({fs::path(file).stem().string(), file}); !added)
      throw Error(file,
                  "and " + fs::path(at->second).filename().string() +
                      " would be one frame: take one of them out");
  for (const std::string& image : files_) {
    const ImageInfo info = ReadImageInfo(image).Upright();
    has_alpha_ = has_alpha_ || info.channels == 4;
    if (width_ == 0) width_ = info.width, height_ = info.height;
    if (info.width != width_ || info.height != height_)
      throw Error(image,
                  "is " + SizeText(info.width, info.height) + ", the images before it are " +
                      SizeText(width_, height_));
  }
}

int FrameSource::count() const { return video_ ? video_->frame_count() : int(files_.size()); }

std::optional<uint32_t> FrameSource::Checksum() const {
  if (checksum_ || !fs::is_regular_file(files_[0])) return checksum_;
  uint32_t sum = 0;
  for (const std::string& file : files_) sum = Crc32OfFile(file, sum);
  return checksum_ = sum;
}

std::vector<std::string> FrameSource::notes() const {
  std::vector<std::string> notes = video_ ? video_->notes() : std::vector<std::string>();
  if (HasBars())
    notes.push_back(Format("the picture is {} at {}, {} of {}: the bars beside it are left out",
                           SizeText(picture_.width, picture_.height),
                           picture_.x,
                           picture_.y,
                           SizeText(in_file_.width, in_file_.height)));
  return notes;
}

std::vector<int> FrameSource::Cuts() const {
  if (video_) return video_->cuts();
  constexpr int kAtOnce = 16;
  CutFinder finder;
  for (int begin = 0; begin < count(); begin += kAtOnce) {
    std::vector<Image8> images(size_t(std::min(kAtOnce, count() - begin)));
    tbb::parallel_for(
        size_t(0), images.size(), [&](size_t i) { images[i] = ReadWhole(begin + int(i)); });
    for (const Image8& image : images)
      finder.Add({&image.data[1],  // green
                  ptrdiff_t(image.channels) * image.width,
                  image.channels,
                  8,
                  0,
                  image.width,
                  image.height});
  }
  return finder.Cuts();
}

std::string FrameSource::Name(int frame) const {
  return video_ ? std::to_string(frame) : fs::path(files_.at(size_t(frame))).stem().string();
}

// The middle without bars is enough, where no title is; what bars there are is found in three.
Crop FrameSource::FindPicture() const {
  std::vector<Image8> frames{ReadWhole(count() / 2)};
  if (PictureBetweenBars(frames) == in_file_) return in_file_;
  for (const int sixth : {1, 5}) frames.push_back(ReadWhole(sixth * count() / 6));
  return PictureBetweenBars(frames).value_or(in_file_);
}

bool FrameSource::HasBars() const { return picture_ != in_file_; }

void FrameSource::EndAt(const Crop& picture) {
  picture_ = picture;
  width_ = picture.width, height_ = picture.height;
  kept_.clear();
  kept_bytes_ = 0;
}

Image8 FrameSource::ReadAll(int frame) const {
  Image8 image = video_ ? video_->ReadFrame(frame) : ReadUpright(files_.at(size_t(frame)));
  return HasBars() ? Cropped(image, picture_) : image;
}

void FrameSource::CropTo(const FrameCrop& crop) {
  crop_ = crop;
  width_ = crop.width, height_ = crop.height;
  kept_.clear();
  kept_bytes_ = 0;
}

Image8 FrameSource::Part(const Image8& image) const {
  return crop_ ? ResizeByArea(Cropped(image, crop_->part), width_, height_) : image;
}

Image8 FrameSource::ReadWhole(int frame) const { return RgbOf(ReadAll(frame)); }

Image8 FrameSource::Read(int frame) const {
  if (!crop_) return ReadWhole(frame);
  const std::lock_guard lock(mutex_);
  if (const auto kept = kept_.find(frame); kept != kept_.end()) return kept->second;
  Image8 image = Part(ReadWhole(frame));
  if (kept_bytes_ + image.data.size() <= kMaxKeptBytes) {
    kept_bytes_ += image.data.size();
    kept_[frame] = image;
  }
  return image;
}

std::optional<Image8> FrameSource::Matte(int frame) const {
  if (!has_alpha_) return {};
  const Image8 whole = ReadAll(frame);
  if (whole.channels != 4 || !ShowsThrough(whole)) return {};
  return ChannelOf(Part(whole), 3);
}

void ForFrames(const FrameSource& frames,
               const std::vector<int>& which,
               const std::function<void(size_t i, const Image8&)>& use,
               const std::function<void(int done)>& progress) {
  constexpr size_t kAhead = 16;
  for (size_t begin = 0; begin < which.size(); begin += kAhead) {
    std::vector<Image8> images;
    const size_t end = std::min(begin + kAhead, which.size());
    for (size_t i = begin; i < end; ++i) images.push_back(frames.Read(which[i]));
    tbb::parallel_for(begin, end, [&](size_t i) { use(i, images[i - begin]); });
    if (progress) progress(int(end));
  }
}

}  // namespace cosplat
