// Video by FFmpeg's libraries, shown as a player shows it: upright, with square pixels, in one
// size.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <optional>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/media/frame_cuts.h"
#include "splat/media/hdr.h"
#include "splat/media/image_io.h"
#include "splat/media/libav.h"

namespace cosplat {
namespace {

namespace av = libav;

constexpr double kMaxStretched = 8;  // anamorphic formats stay below 2

// FFmpeg's display matrix maps (p, q) of the stored image to x = a p + c q, y = b p + d q of the
// shown one, rows downwards; {a, b, u, c, d, v, ...}. Angles between quarter turns go to the
// nearest. As EXIF numbers orientations (Upright).
int OrientationOf(const int32_t* matrix) {
  const double a = matrix[0], b = matrix[1], c = matrix[3], d = matrix[4];
  const bool exchanged = std::abs(a) + std::abs(d) < std::abs(b) + std::abs(c);
  const bool columns_reversed = (exchanged ? c : a) < 0, rows_reversed = (exchanged ? b : d) < 0;
  const int reversed = rows_reversed ? (columns_reversed ? 3 : 4) : (columns_reversed ? 2 : 1);
  return exchanged ? 4 + reversed : reversed;
}

// What a container says of a track beside its packets; null if it does not, or in too few bytes.
template <class T>
const T* SideData(const AVStream& stream, AVPacketSideDataType type, size_t count = 1) {
  const uint8_t* data = nullptr;
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
  const AVPacketSideData* side = av_packet_side_data_get(
      stream.codecpar->coded_side_data, stream.codecpar->nb_coded_side_data, type);
  const size_t size = side != nullptr ? side->size : 0;
  if (side != nullptr) data = side->data;
#else
  size_t size = 0;
  data = av_stream_get_side_data(&stream, type, &size);
#endif
  return size >= count * sizeof(T) ? reinterpret_cast<const T*>(data) : nullptr;
}

bool IsInterlaced(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 29, 100)
  return (frame.flags & AV_FRAME_FLAG_INTERLACED) != 0;
#else
  return frame.interlaced_frame != 0;
#endif
}

// Whether pieces of lines differ from both neighbours, which are alike: fields of two times, of
// what moves. Pieces, since single pixels of noise do, too.
template <class T>
bool IsCombed(const AVFrame& frame, int depth) {
  constexpr int kPiece = 4;  // px
  const int least = 12 << (depth - 8);
  const ptrdiff_t row = frame.linesize[0] / ptrdiff_t(sizeof(T));
  const T* luma = reinterpret_cast<const T*>(frame.data[0]);
  size_t combed = 0, seen = 0;
  for (int y = 1; y + 1 < frame.height; y += 3) {
    int run = 0;
    for (int x = 0; x < frame.width; ++x, ++seen) {
      const int above = luma[(y - 1) * row + x], below = luma[(y + 1) * row + x];
      const int here = luma[y * row + x];
      const bool differs =
          std::abs(above - below) < least &&
          (here - std::max(above, below) > least || std::min(above, below) - here > least);
      run = differs ? run + 1 : 0;
      combed += run >= kPiece;
    }
  }
  return 1000 * combed > seen;
}
bool IsCombed(const AVFrame& frame) {
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(AVPixelFormat(frame.format));
  if (format == nullptr || (format->flags & AV_PIX_FMT_FLAG_PLANAR) == 0) return false;
  const int depth = format->comp[0].depth;
  return depth > 8 ? IsCombed<uint16_t>(frame, depth) : IsCombed<uint8_t>(frame, depth);
}

// Of the first component, which is brightness, or red or green; nothing of a palette's numbers.
std::optional<BrightnessPlane> BrightnessOf(const AVFrame& frame) {
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(AVPixelFormat(frame.format));
  if (format == nullptr || (format->flags & (AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM |
                                             AV_PIX_FMT_FLAG_BE | AV_PIX_FMT_FLAG_FLOAT)) != 0)
    return {};
  const AVComponentDescriptor& first = format->comp[0];
  if (first.depth > 16) return {};
  return BrightnessPlane{frame.data[first.plane] + first.offset,
                         frame.linesize[first.plane],
                         first.step,
                         first.depth,
                         first.shift,
                         frame.width,
                         frame.height};
}

bool HasAlpha(const AVFrame& frame) {
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(AVPixelFormat(frame.format));
  return format != nullptr && (format->flags & AV_PIX_FMT_FLAG_ALPHA) != 0;
}

// By more than rounding to a codec's blocks does.
bool ShapesDiffer(int width, int height, int other_width, int other_height) {
  const double one = double(width) / height, other = double(other_width) / other_height;
  return std::abs(one - other) > 0.05 * one;
}

std::string Seconds(double seconds) { return Format("{:.2f}", seconds); }

std::string SizeOf(const AVFrame& frame) { return SizeText(frame.width, frame.height); }

}  // namespace

struct VideoReader::Impl {
  std::string path;
  av::Input input;
  av::Codec codec;
  av::Frame frame{av_frame_alloc()};
  av::Packet packet{av_packet_alloc()};
  av::Scaler scaler;
  std::array<int, 3> scaled{};  // width, height and format that it was made for
  int stream = -1;
  bool drained = false;
  int undecodable = 0;    // packets
  double read_until = 0;  // seconds, over all tracks
  int next = 0;           // index of the frame that ReadFrame() decodes next

  // What the first pass found in all frames.
  int count = 0;
  double frames_per_second = 0;
  int orientation = 1;                      // EXIF's number
  int width = 0, height = 0;                // shown, before it is turned
  int stored_width = 0, stored_height = 0;  // of the first frame
  bool alpha = false;
  bool interlaced = false;      // frames that say so are: their lines are of two times
  std::optional<HdrToSdr> hdr;  // what frames are read by
  std::vector<std::string> notes;
  std::vector<int> cuts;
  std::mutex mutex;

  void Open();
  bool Decode();
  void FirstPass();
  void SetSize();
  void SetRate(int64_t first, int64_t last);
  Image8 Converted();
  void SetColors();
};

void VideoReader::Impl::Open() {
  next = 0;
  drained = false;
  input = av::OpenInput(path, "video");
  const AVCodec* decoder = nullptr;
  stream = av_find_best_stream(input.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (stream == AVERROR_DECODER_NOT_FOUND)
    throw Error(path, "is encoded in a way that FFmpeg's libraries here cannot decode");
  if (stream < 0) throw Error(path, "cannot be opened as a video: it has no video track");
  const AVStream& track = *input->streams[stream];
  // FFmpeg's own decoders of WebM drop its alpha, which libvpx's keep.
  const AVDictionaryEntry* mode = av_dict_get(track.metadata, "alpha_mode", nullptr, 0);
  if (mode != nullptr && std::strcmp(mode->value, "1") == 0) {
    const bool vp8 = track.codecpar->codec_id == AV_CODEC_ID_VP8;
    const AVCodec* libvpx = avcodec_find_decoder_by_name(vp8 ? "libvpx" : "libvpx-vp9");
    if (libvpx != nullptr && libvpx->id == track.codecpar->codec_id) decoder = libvpx;
  }
  codec.reset(decoder != nullptr ? avcodec_alloc_context3(decoder) : nullptr);
  if (!codec) throw Error(path, "is encoded in a way that FFmpeg's libraries here cannot decode");
  int code = avcodec_parameters_to_context(codec.get(), track.codecpar);
  codec->pkt_timebase = track.time_base;
  codec->thread_count = 0;  // as many as there are cores
  if (code >= 0) code = avcodec_open2(codec.get(), decoder, nullptr);
  if (code < 0) throw Error(path, "cannot be decoded: " + av::ErrorText(code));
}

// The next frame that can be decoded, in the order of showing. What is damaged is left out.
bool VideoReader::Impl::Decode() {
  for (;;) {
    const int code = avcodec_receive_frame(codec.get(), frame.get());
    if (code >= 0) return true;
    if (code == AVERROR_EOF) return false;
    if (code != AVERROR(EAGAIN)) {
      ++undecodable;
      continue;
    }
    if (drained) return false;
    const int read = av_read_frame(input.get(), packet.get());
    if (read < 0) {
      if (read != AVERROR_EOF) ++undecodable;
      drained = true;
      avcodec_send_packet(codec.get(), nullptr);
      continue;
    }
    const int64_t time = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
    if (time != AV_NOPTS_VALUE)
      read_until = std::max(read_until,
                            double(time + packet->duration) *
                                av_q2d(input->streams[packet->stream_index]->time_base));
    if (packet->stream_index == stream && avcodec_send_packet(codec.get(), packet.get()) < 0)
      ++undecodable;
    av_packet_unref(packet.get());
  }
}

// Containers may state any number of frames and any rate, or none, so all of it is decoded once.
void VideoReader::Impl::FirstPass() {
  Open();
  int64_t first = AV_NOPTS_VALUE, last = AV_NOPTS_VALUE;
  std::string other_size;
  int resized = 0, damaged = 0, fields = 0, combed = 0;
  CutFinder finder;
  while (Decode()) {
    if (count++ == 0) SetSize();
    if (frame->width != stored_width || frame->height != stored_height) {
      if (resized++ == 0) other_size = SizeOf(*frame);
    }
    if (frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0) ++damaged;
    if (IsInterlaced(*frame)) ++fields, combed += IsCombed(*frame);
    if (const auto brightness = BrightnessOf(*frame)) finder.Add(*brightness);
    const int64_t time = frame->best_effort_timestamp;
    if (time == AV_NOPTS_VALUE) continue;
    if (first == AV_NOPTS_VALUE || time < first) first = time;
    if (last == AV_NOPTS_VALUE || time > last) last = time;
  }
  if (count == 0) throw Error(path, "has no frame that can be decoded");
  SetRate(first, last);
  cuts = finder.Cuts();
  interlaced = 20 * combed > fields;
  if (interlaced)
    notes.push_back(path +
                    ": is interlaced; every second line of a frame is read, and the others "
                    "are made from these");
  if (resized > 0)
    notes.push_back(path + ": " + std::to_string(resized) + " of " + std::to_string(count) +
                    " frames have another size (" + other_size + ") than the first (" +
                    SizeText(stored_width, stored_height) + "), into which they are scaled");
  if (damaged > 0)
    notes.push_back(path + ": " + std::to_string(damaged) + " of " + std::to_string(count) +
                    " frames are damaged; parts of them are made up");
  // Only a length that the container states: others are guesses from what was read.
  const double length = input->duration_estimation_method == AVFMT_DURATION_FROM_STREAM
                            ? double(input->duration) / AV_TIME_BASE
                            : 0;
  if (frames_per_second > 0 && length - read_until > 1.5 / frames_per_second)
    notes.push_back(path + ": is cut off: it is to be " + Seconds(length) +
                    " s long, and ends at " + Seconds(read_until) + " s");
  if (undecodable > 0)
    notes.push_back(path + ": " + std::to_string(undecodable) +
                    " packets of it cannot be decoded; the " + std::to_string(count) +
                    " frames of the others are used");
}

// From the first frame: the size in square pixels, how it lies, what its pixels are.
void VideoReader::Impl::SetSize() {
  const AVStream& track = *input->streams[stream];
  width = stored_width = frame->width;
  height = stored_height = frame->height;
  const AVRational pixel =
      av_guess_sample_aspect_ratio(input.get(), input->streams[stream], frame.get());
  const double wide = pixel.num > 0 && pixel.den > 0 ? av_q2d(pixel) : 1;
  // No line or column is lost: pixels are only ever stretched.
  if (wide > 1) width = std::max(1, int(std::lround(width * wide)));
  if (wide < 1) height = std::max(1, int(std::lround(height / wide)));
  if (wide > kMaxStretched || wide < 1 / kMaxStretched)
    throw Error(path, Format("says that its pixels are {} times as wide as high", wide));
  const AVFrameSideData* side = av_frame_get_side_data(frame.get(), AV_FRAME_DATA_DISPLAYMATRIX);
  if (const int32_t* matrix = side != nullptr
                                  ? reinterpret_cast<const int32_t*>(side->data)
                                  : SideData<int32_t>(track, AV_PKT_DATA_DISPLAYMATRIX, 9))
    orientation = OrientationOf(matrix);
  alpha = HasAlpha(*frame);
  const auto* dolby = SideData<AVDOVIDecoderConfigurationRecord>(track, AV_PKT_DATA_DOVI_CONF);
  if (dolby != nullptr && dolby->dv_bl_signal_compatibility_id == 0)
    throw Error(path,
                "is Dolby Vision of profile " + std::to_string(dolby->dv_profile) +
                    ", whose colours only its own players know; convert it to SDR");
  const bool pq = frame->color_trc == AVCOL_TRC_SMPTE2084;
  if (!pq && frame->color_trc != AVCOL_TRC_ARIB_STD_B67) return;
  hdr.emplace(pq ? HdrTransfer::kPq : HdrTransfer::kHlg, frame->color_primaries != AVCOL_PRI_BT709);
  notes.push_back(path + ": is HDR video (" + (pq ? "PQ" : "HLG") +
                  "), and read as a screen of the usual range shows it");
}

// The rate that the container states if the frames' time stamps agree; else theirs on average.
void VideoReader::Impl::SetRate(int64_t first, int64_t last) {
  const AVStream& track = *input->streams[stream];
  const double stated = track.avg_frame_rate.den > 0 ? av_q2d(track.avg_frame_rate) : 0;
  const double seconds =
      first != AV_NOPTS_VALUE ? double(last - first) * av_q2d(track.time_base) : 0;
  const double counted = count > 1 && seconds > 0 ? (count - 1) / seconds : 0;
  const double rate = counted > 0 && std::abs(stated - counted) > 0.01 * counted ? counted : stated;
  frames_per_second = std::isfinite(rate) && rate > 0 ? rate : 0;
}

// Which matrix turned the image into what is stored: BT.601 unless the video names another.
void VideoReader::Impl::SetColors() {
  int *to_inverse, *to_table, from_range, to_range, brightness, contrast, saturation;
  if (sws_getColorspaceDetails(scaler.get(),
                               &to_inverse,
                               &from_range,
                               &to_table,
                               &to_range,
                               &brightness,
                               &contrast,
                               &saturation) < 0)
    return;  // its pixels are RGB already
  const bool named =
      frame->colorspace != AVCOL_SPC_UNSPECIFIED && frame->colorspace != AVCOL_SPC_RGB;
  const int* table = sws_getCoefficients(named ? int(frame->colorspace) : SWS_CS_DEFAULT);
  if (frame->color_range != AVCOL_RANGE_UNSPECIFIED)
    from_range = frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0;
  sws_setColorspaceDetails(
      scaler.get(), table, from_range, to_table, to_range, brightness, contrast, saturation);
}

// A frame of another shape than the first keeps its shape: black bars fill the rest, as players
// show it.
Image8 VideoReader::Impl::Converted() {
  const AVPixelFormat to = hdr ? (alpha ? AV_PIX_FMT_RGBA64 : AV_PIX_FMT_RGB48)
                               : (alpha ? AV_PIX_FMT_RGBA : AV_PIX_FMT_RGB24);
  int to_width = width, to_height = height;
  if (ShapesDiffer(stored_width, stored_height, frame->width, frame->height)) {
    const double scale =
        std::min(double(stored_width) / frame->width, double(stored_height) / frame->height);
    to_width = std::clamp(int(std::lround(scale * frame->width * width / stored_width)), 1, width);
    to_height =
        std::clamp(int(std::lround(scale * frame->height * height / stored_height)), 1, height);
  }
  // One field of two has every second line of each plane.
  const int field = interlaced && IsInterlaced(*frame) ? 2 : 1, lines = frame->height / field;
  const std::array<int, 3> kind = {frame->width, lines, frame->format};
  scaler.reset(sws_getCachedContext(scaler.release(),
                                    frame->width,
                                    lines,
                                    AVPixelFormat(frame->format),
                                    to_width,
                                    to_height,
                                    to,
                                    SWS_BICUBIC,
                                    nullptr,
                                    nullptr,
                                    nullptr));
  if (!scaler) throw Error(path, "has pixels of a kind that cannot be converted to RGB");
  if (kind != scaled) SetColors();
  scaled = kind;
  Image8 image(width, height, alpha ? 4 : 3);
  // The scaler may write some bytes beyond the end of a row.
  const int stride = ((hdr ? 2 : 1) * image.channels * to_width + 63) / 64 * 64;
  std::vector<uint8_t> rows(size_t(stride) * to_height + 64);
  uint8_t* const planes[] = {rows.data()};
  const int strides[] = {stride};
  std::array<int, AV_NUM_DATA_POINTERS> from;
  for (size_t i = 0; i < from.size(); ++i) from[i] = field * frame->linesize[i];
  sws_scale(scaler.get(), frame->data, from.data(), 0, lines, planes, strides);
  const int left = (width - to_width) / 2, top = (height - to_height) / 2;
  for (int y = 0; y < to_height; ++y) {
    const uint8_t* row = &rows[size_t(y) * stride];
    uint8_t* pixels = &image.at(left, top + y, 0);
    if (hdr)
      hdr->Convert(
          reinterpret_cast<const uint16_t*>(row), size_t(to_width), image.channels, pixels);
    else
      std::copy_n(row, size_t(image.channels) * to_width, pixels);
  }
  return Upright(image, orientation);
}

VideoReader::VideoReader(const std::string& path) : impl_(std::make_unique<Impl>()) {
  av::Quiet();
  if (!std::filesystem::is_regular_file(path)) throw Error(path, "is not a file");
  impl_->path = path;
  impl_->FirstPass();
  impl_->Open();
}

VideoReader::~VideoReader() = default;

int VideoReader::frame_count() const { return impl_->count; }
double VideoReader::frames_per_second() const { return impl_->frames_per_second; }
bool VideoReader::has_alpha() const { return impl_->alpha; }
const std::vector<std::string>& VideoReader::notes() const { return impl_->notes; }
const std::vector<int>& VideoReader::cuts() const { return impl_->cuts; }

Image8 VideoReader::ReadFrame(int index) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  Impl& video = *impl_;
  const std::string field = "frame " + std::to_string(index);
  if (index < 0 || index >= video.count)
    throw Error(video.path, field, "is missing, the video has " + std::to_string(video.count));
  // Seeking by number is unreliable between key frames; decoding from the start is exact.
  if (index < video.next) video.Open();
  while (video.next <= index) {
    if (!video.Decode()) throw Error(video.path, field, "cannot be decoded");
    ++video.next;
  }
  return video.Converted();
}

}  // namespace cosplat
