#include "splat/media/live_video.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/media/video_stream.h"

namespace cosplat {
namespace {

constexpr std::string_view kV4l2 = "v4l2:";

class V4l2Output : public LiveVideo {
 public:
  V4l2Output(const std::string& to, int width, int height)
      : to_(to), yuv_(to, width, height), bytes_(size_t(width & ~1) * (height & ~1) * 3 / 2) {
    const std::string device = to.substr(kV4l2.size());
    descriptor_ = open(device.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) Fail(std::strerror(errno));
    try {
      SetFormat(width & ~1, height & ~1);
    } catch (const Error&) {
      close(descriptor_);
      throw;
    }
  }
  ~V4l2Output() override { close(descriptor_); }

  // One write is one frame.
  void Write(const Image8& rgb, int64_t) override {
    const AVFrame& frame = *yuv_.Of(rgb);
    uint8_t* to = bytes_.data();
    for (int plane = 0; plane < 3; ++plane) {
      const int width = plane == 0 ? frame.width : frame.width / 2;
      const int height = plane == 0 ? frame.height : frame.height / 2;
      for (int y = 0; y < height; ++y, to += width)
        std::memcpy(to, frame.data[plane] + ptrdiff_t(y) * frame.linesize[plane], size_t(width));
    }
    for (size_t done = 0; done < bytes_.size();) {
      const ssize_t count = write(descriptor_, bytes_.data() + done, bytes_.size() - done);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0)
        throw Error(to_, std::string("takes no more frames: ") + std::strerror(errno));
      done += size_t(count);
    }
  }

 private:
  [[noreturn]] void Fail(const std::string& problem) const {
    throw Error(to_, problem + " (`modprobe v4l2loopback exclusive_caps=1` makes such a device)");
  }

  void SetFormat(int width, int height) const {
    struct stat status {};
    if (fstat(descriptor_, &status) != 0) Fail(std::strerror(errno));
    if (S_ISFIFO(status.st_mode)) return;
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    v4l2_pix_format& pixels = format.fmt.pix;
    pixels.width = uint32_t(width);
    pixels.height = uint32_t(height);
    pixels.pixelformat = V4L2_PIX_FMT_YUV420;
    pixels.field = V4L2_FIELD_NONE;
    pixels.bytesperline = uint32_t(width);
    pixels.sizeimage = uint32_t(bytes_.size());
    pixels.colorspace = V4L2_COLORSPACE_SMPTE170M;
    if (!S_ISCHR(status.st_mode) || ioctl(descriptor_, VIDIOC_S_FMT, &format) != 0)
      Fail("is no video output");
    if (pixels.width != uint32_t(width) || pixels.height != uint32_t(height) ||
        pixels.pixelformat != V4L2_PIX_FMT_YUV420)
      Fail("takes no images of " + SizeText(width, height) + ", but of " +
           SizeText(int(pixels.width), int(pixels.height)) + ": another program uses it");
  }

  std::string to_;
  libav::Yuv420 yuv_;
  std::vector<uint8_t> bytes_;  // of a frame
  int descriptor_ = -1;
};

class AddressOutput : public LiveVideo {
 public:
  AddressOutput(const std::string& to, int width, int height, double frames_per_second)
      : stream_(to,
                to.starts_with("rtmp") ? "flv" : "mpegts",
                to,
                width,
                height,
                frames_per_second,
                libav::VideoStream::For::kLive) {}
  void Write(const Image8& rgb, int64_t number) override { stream_.Write(rgb, number); }

 private:
  libav::VideoStream stream_;
};

}  // namespace

std::unique_ptr<LiveVideo> OpenLiveVideo(const std::string& to,
                                         int width,
                                         int height,
                                         double frames_per_second) {
  if (to.starts_with(kV4l2)) return std::make_unique<V4l2Output>(to, width, height);
  if (to.find("://") == std::string::npos && !to.starts_with("file:"))
    throw Error(to,
                "expected v4l2:DEVICE, or an address such as rtmp://HOST/KEY or srt://HOST:PORT");
  for (const char* ending : {".avi", ".mkv", ".mov", ".mp4", ".webm"})
    if (to.starts_with("file:") && LowerCase(to).ends_with(ending))
      throw Error(to, "is written as MPEG-TS, which ends in .ts");
  return std::make_unique<AddressOutput>(to, width, height, frames_per_second);
}

}  // namespace cosplat
