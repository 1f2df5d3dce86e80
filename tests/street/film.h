// Videos with the properties that phones, browsers and cameras give them, made by FFmpeg's
// libraries.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "splat/base/files.h"
#include "splat/media/image_io.h"
#include "splat/media/libav.h"

namespace cosplat::test {

// Red above green on the left, blue above white on the right, of equal sizes.
inline Image8 FourColors(int width, int height) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool right = 2 * x >= width, below = 2 * y >= height;
      uint8_t* pixel = &image.data[3 * (size_t(y) * width + x)];
      pixel[0] = right == below ? 220 : 20;
      pixel[1] = below ? 220 : 20;
      pixel[2] = right ? 220 : 20;
    }
  }
  return image;
}

struct FilmFrame {
  int width = 64, height = 48;
  int64_t milliseconds = 0;
  uint8_t alpha = 255;
};

struct Film {
  std::string path;  // .webm, .mkv, .mp4, .avi
  std::string encoder = "mpeg4";
  AVRational pixel{1, 1};
  bool alpha = false;
  bool states_rate = true;
  bool interlaced = false;
  AVColorTransferCharacteristic transfer = AVCOL_TRC_UNSPECIFIED;
  int dolby_vision_profile = 0;  // if any: without a compatible base
  // In place of FourColors, in this format.
  AVPixelFormat format = AV_PIX_FMT_YUV420P;
  std::function<void(AVFrame&)> fill = nullptr;
  std::vector<FilmFrame> frames;
};

inline void Succeeds(int code, const char* what) {
  ASSERT_GE(code, 0) << what << ": " << libav::ErrorText(code);
}

// Encodes FourColors at each frame's size; a change of size begins with a new encoder, as a
// browser's.
class FilmWriter {
 public:
  explicit FilmWriter(const Film& film) : film_(film) {
    avformat_alloc_output_context2(&output_, nullptr, nullptr, libav::FileUrl(film.path).c_str());
    stream_ = avformat_new_stream(output_, nullptr);
    stream_->time_base = {1, 1000};
    StartEncoder(film.frames[0]);
    avcodec_parameters_from_context(stream_->codecpar, codec_.get());
    stream_->sample_aspect_ratio = film.pixel;
    if (film.states_rate) stream_->avg_frame_rate = {25, 1};
    if (film.alpha) av_dict_set(&stream_->metadata, "alpha_mode", "1", 0);
    if (film.dolby_vision_profile > 0) SetDolbyVision();
    Succeeds(avio_open(&output_->pb, libav::FileUrl(film.path).c_str(), AVIO_FLAG_WRITE), "open");
    Succeeds(avformat_write_header(output_, nullptr), "header");
  }
  ~FilmWriter() {
    Drain(nullptr);
    av_write_trailer(output_);
    avio_closep(&output_->pb);
    avformat_free_context(output_);
  }
  void Write(const FilmFrame& frame) {
    if (frame.width != codec_->width || frame.height != codec_->height) {
      Drain(nullptr);
      StartEncoder(frame);
    }
    libav::Frame picture(av_frame_alloc());
    picture->format = codec_->pix_fmt;
    picture->width = frame.width, picture->height = frame.height;
    av_frame_get_buffer(picture.get(), 0);
    if (film_.fill)
      film_.fill(*picture);
    else
      Fill(frame, *picture);
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 29, 100)
    if (film_.interlaced)
      picture->flags |= AV_FRAME_FLAG_INTERLACED | AV_FRAME_FLAG_TOP_FIELD_FIRST;
#else
    picture->interlaced_frame = picture->top_field_first = film_.interlaced;
#endif
    picture->pts = frame.milliseconds;
    Drain(picture.get());
  }

 private:
  void StartEncoder(const FilmFrame& frame) {
    const AVCodec* encoder = avcodec_find_encoder_by_name(film_.encoder.c_str());
    codec_.reset(avcodec_alloc_context3(encoder));
    codec_->width = frame.width, codec_->height = frame.height;
    codec_->time_base = film_.states_rate ? AVRational{1, 25} : AVRational{1, 1000};
    if (film_.encoder != "mpeg4") codec_->time_base = {1, 1000};
    codec_->pix_fmt = film_.alpha ? AV_PIX_FMT_YUVA420P : film_.format;
    codec_->color_trc = film_.transfer;
    if (film_.transfer != AVCOL_TRC_UNSPECIFIED) codec_->color_primaries = AVCOL_PRI_BT2020;
    codec_->sample_aspect_ratio = film_.pixel;
    codec_->bit_rate = 2000000;
    if (output_->oformat->flags & AVFMT_GLOBALHEADER) codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* options = nullptr;  // libvpx takes no alpha with its alternative frames
    if (film_.alpha) av_dict_set(&options, "auto-alt-ref", "0", 0);
    if (film_.encoder == "ffv1")
      codec_->level = 3, codec_->slices = 4;  // else it drops "interlaced"
    Succeeds(avcodec_open2(codec_.get(), encoder, &options), "encoder");
    av_dict_free(&options);
  }
  void SetDolbyVision() {
    size_t size = 0;
    AVDOVIDecoderConfigurationRecord* record = av_dovi_alloc(&size);
    record->dv_version_major = 1;
    record->dv_profile = uint8_t(film_.dolby_vision_profile);
    record->rpu_present_flag = record->bl_present_flag = 1;
    output_->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
    uint8_t* data = reinterpret_cast<uint8_t*>(record);
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
    av_packet_side_data_add(&stream_->codecpar->coded_side_data,
                            &stream_->codecpar->nb_coded_side_data,
                            AV_PKT_DATA_DOVI_CONF,
                            data,
                            size,
                            0);
#else
    av_stream_add_side_data(stream_, AV_PKT_DATA_DOVI_CONF, data, size);
#endif
  }
  void Fill(const FilmFrame& frame, AVFrame& picture) const {
    const Image8 colors = FourColors(frame.width, frame.height);
    const libav::Scaler scaler(sws_getContext(frame.width,
                                              frame.height,
                                              AV_PIX_FMT_RGB24,
                                              frame.width,
                                              frame.height,
                                              AV_PIX_FMT_YUV420P,
                                              SWS_BICUBIC,
                                              nullptr,
                                              nullptr,
                                              nullptr));
    const uint8_t* const planes[] = {colors.data.data()};
    const int strides[] = {3 * frame.width};
    sws_scale(scaler.get(), planes, strides, 0, frame.height, picture.data, picture.linesize);
    if (film_.alpha)
      for (int y = 0; y < frame.height; ++y)
        std::memset(picture.data[3] + y * picture.linesize[3], frame.alpha, size_t(frame.width));
  }
  void Drain(const AVFrame* picture) {
    // The encoder counts in its own time base.
    if (picture != nullptr)
      const_cast<AVFrame*>(picture)->pts =
          av_rescale_q(picture->pts, AVRational{1, 1000}, codec_->time_base);
    Succeeds(avcodec_send_frame(codec_.get(), picture), "send");
    const libav::Packet packet(av_packet_alloc());
    while (avcodec_receive_packet(codec_.get(), packet.get()) >= 0) {
      av_packet_rescale_ts(packet.get(), codec_->time_base, stream_->time_base);
      packet->stream_index = 0;
      Succeeds(av_interleaved_write_frame(output_, packet.get()), "write");
    }
  }

  Film film_;
  AVFormatContext* output_ = nullptr;
  AVStream* stream_ = nullptr;
  libav::Codec codec_;
};

inline void WriteFilm(const Film& film) {
  FilmWriter writer(film);
  for (const FilmFrame& frame : film.frames) writer.Write(frame);
}

// `count` frames at 25 a second.
inline std::vector<FilmFrame> Frames(int count, int width = 64, int height = 48) {
  std::vector<FilmFrame> frames;
  for (int i = 0; i < count; ++i) frames.push_back({width, height, 40 * i, 255});
  return frames;
}

// Replaces a, b, c, d of an MP4's display matrix (ISO 14496-12, tkhd; rows {a, b, u}, {c, d, v},
// ...).
inline void SetDisplayMatrix(const std::string& path, int a, int b, int c, int d) {
  std::vector<char> bytes = ReadFile(path);
  const char name[] = {'t', 'k', 'h', 'd'};
  const auto at = std::search(bytes.begin(), bytes.end(), std::begin(name), std::end(name));
  ASSERT_NE(at, bytes.end());
  const auto put = [&](int entry, int value) {
    for (int k = 0; k < 4; ++k)
      *(at + 44 + 4 * entry + k) = char(uint32_t(value) << 16 >> (24 - 8 * k) & 0xff);
  };
  put(0, a), put(1, b), put(3, c), put(4, d);
  WriteFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace cosplat::test
