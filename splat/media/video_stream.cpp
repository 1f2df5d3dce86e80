#include "splat/media/video_stream.h"

#include <cmath>

#include "splat/base/error.h"

namespace cosplat::libav {
namespace {

void SetQuality(const AVCodec& encoder, VideoStream::For purpose, Codec& codec, AVDictionary** to) {
  const bool live = purpose == VideoStream::For::kLive;
  codec->thread_count = 1;  // the bytes depend on it
  if (live) {
    codec->gop_size = int(std::lround(2 * av_q2d(codec->framerate)));  // who comes later waits
    codec->max_b_frames = 0;
  }
  if (encoder.id == AV_CODEC_ID_H264) {
    av_dict_set(to, "preset", "veryfast", 0);
    av_dict_set(to, "crf", live ? "21" : "15", 0);
    if (live) av_dict_set(to, "tune", "zerolatency", 0);
  } else {
    codec->flags |= AV_CODEC_FLAG_QSCALE;
    codec->global_quality = (live ? 4 : 2) * FF_QP2LAMBDA;
  }
}

// H.264, which everything plays, where the distribution's FFmpeg has an encoder of it; else MPEG-4.
Codec OpenEncoder(
    int width, int height, double frames_per_second, bool global_header, VideoStream::For purpose) {
  for (const char* name : {"libx264", "mpeg4"}) {
    const AVCodec* encoder = avcodec_find_encoder_by_name(name);
    if (encoder == nullptr) continue;
    Codec codec(avcodec_alloc_context3(encoder));
    codec->width = width;
    codec->height = height;
    codec->framerate = av_d2q(frames_per_second, 65535);
    codec->time_base = av_inv_q(codec->framerate);
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->colorspace = AVCOL_SPC_SMPTE170M;  // BT.601, which the scaler writes
    codec->color_range = AVCOL_RANGE_MPEG;
    if (global_header) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* options = nullptr;
    SetQuality(*encoder, purpose, codec, &options);
    const int code = avcodec_open2(codec.get(), encoder, &options);
    av_dict_free(&options);
    if (code >= 0) return codec;
  }
  return nullptr;
}

}  // namespace

Yuv420::Yuv420(const std::string& name, int width, int height)
    : name_(name), width_(width), height_(height) {
  frame_->format = AV_PIX_FMT_YUV420P;
  frame_->width = width & ~1;
  frame_->height = height & ~1;
  const bool held = width > 1 && height > 1 && av_frame_get_buffer(frame_.get(), 0) >= 0;
  if (held)
    scaler_.reset(sws_getContext(frame_->width,
                                 frame_->height,
                                 AV_PIX_FMT_RGB24,
                                 frame_->width,
                                 frame_->height,
                                 AV_PIX_FMT_YUV420P,
                                 SWS_BICUBIC,
                                 nullptr,
                                 nullptr,
                                 nullptr));
  if (!scaler_) throw Error(name, "cannot hold frames of " + SizeText(width, height));
}

AVFrame* Yuv420::Of(const Image8& rgb) {
  if (rgb.width != width_ || rgb.height != height_ || rgb.channels != 3)
    throw Error(name_,
                "frame " + std::to_string(written_),
                "has size " + SizeText(rgb.width, rgb.height) + "x" + std::to_string(rgb.channels) +
                    ", expected " + SizeText(width_, height_) + "x3");
  if (const int code = av_frame_make_writable(frame_.get()); code < 0)
    throw Error(name_, "video cannot be written: " + ErrorText(code));
  const uint8_t* const planes[] = {rgb.data.data()};
  const int strides[] = {3 * rgb.width};
  sws_scale(scaler_.get(), planes, strides, 0, frame_->height, frame_->data, frame_->linesize);
  ++written_;
  return frame_.get();
}

void VideoStream::Check(int code) const {
  if (code < 0) throw Error(name_, "video cannot be written: " + ErrorText(code));
}

VideoStream::VideoStream(const std::string& name,
                         const std::string& container,
                         const std::string& url,
                         int width,
                         int height,
                         double frames_per_second,
                         For purpose,
                         std::optional<Sound> sound)
    : name_(name), yuv_(name, width, height) {
  Quiet();
  AVFormatContext* opened = nullptr;
  Check(avformat_alloc_output_context2(&opened, nullptr, container.c_str(), url.c_str()));
  output_.reset(opened);
  codec_ = OpenEncoder(width & ~1,
                       height & ~1,
                       frames_per_second,
                       (opened->oformat->flags & AVFMT_GLOBALHEADER) != 0,
                       purpose);
  if (!codec_)
    throw Error(name, "video cannot be written: FFmpeg has no encoder of H.264 or MPEG-4");
  stream_ = avformat_new_stream(opened, nullptr);
  stream_->time_base = codec_->time_base;
  stream_->avg_frame_rate = codec_->framerate;
  Check(avcodec_parameters_from_context(stream_->codecpar, codec_.get()));
  if (sound) sound_.emplace(name, *opened, std::move(*sound));
  Check(avio_open(&opened->pb, url.c_str(), AVIO_FLAG_WRITE));
  if (purpose == For::kLive) opened->flags |= AVFMT_FLAG_FLUSH_PACKETS;
  Check(avformat_write_header(opened, nullptr));
}

void VideoStream::Encode(const AVFrame* image) {
  Check(EncodeInto(*output_, *stream_, *codec_, image, *packet_));
}

void VideoStream::Write(const Image8& rgb, int64_t number) {
  AVFrame* frame = yuv_.Of(rgb);
  frame->pts = number;
  Encode(frame);
  if (sound_) sound_->WriteUntil(double(number + 1) * av_q2d(codec_->time_base));
}

void VideoStream::Finish() {
  Encode(nullptr);
  if (sound_) sound_->Finish();
  Check(av_write_trailer(output_.get()));
  Check(avio_closep(&output_->pb));
}

}  // namespace cosplat::libav
