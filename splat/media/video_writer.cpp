// MP4 files by FFmpeg's libraries.
#include <cmath>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"
#include "splat/media/libav.h"

namespace cosplat {
namespace {

namespace av = libav;

struct CloseOutput {
  void operator()(AVFormatContext* output) const {
    if (output->pb != nullptr) avio_closep(&output->pb);
    avformat_free_context(output);
  }
};
using Output = std::unique_ptr<AVFormatContext, CloseOutput>;

// H.264, which everything plays, where the distribution's FFmpeg has an encoder of it; else MPEG-4.
// Both at a quality at which frames are hard to tell from what was written.
av::Codec OpenEncoder(int width, int height, double frames_per_second, bool global_header) {
  for (const char* name : {"libx264", "mpeg4"}) {
    const AVCodec* encoder = avcodec_find_encoder_by_name(name);
    if (encoder == nullptr) continue;
    av::Codec codec(avcodec_alloc_context3(encoder));
    codec->width = width;
    codec->height = height;
    codec->framerate = av_d2q(frames_per_second, 65535);
    codec->time_base = av_inv_q(codec->framerate);
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->colorspace = AVCOL_SPC_SMPTE170M;  // BT.601, which the scaler writes
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->thread_count = 1;  // the bytes depend on it
    if (global_header) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* options = nullptr;
    if (encoder->id == AV_CODEC_ID_H264) {
      av_dict_set(&options, "preset", "veryfast", 0);
      av_dict_set(&options, "crf", "15", 0);
    } else {
      codec->flags |= AV_CODEC_FLAG_QSCALE;
      codec->global_quality = 2 * FF_QP2LAMBDA;
    }
    const int code = avcodec_open2(codec.get(), encoder, &options);
    av_dict_free(&options);
    if (code >= 0) return codec;
  }
  return nullptr;
}

}  // namespace

struct VideoWriter::Impl {
  std::string path, temporary;
  int width = 0;
  int height = 0;
  int written = 0;
  Output output;
  av::Codec codec;
  av::Frame frame{av_frame_alloc()};
  av::Packet packet{av_packet_alloc()};
  av::Scaler scaler;
  AVStream* stream = nullptr;

  // `code`: what a function of FFmpeg returned.
  void Check(int code) const {
    if (code < 0) throw Error(path, "video cannot be written: " + av::ErrorText(code));
  }
  void Open(double frames_per_second);
  void Encode(const AVFrame* image);
};

void VideoWriter::Impl::Open(double frames_per_second) {
  AVFormatContext* opened = nullptr;
  Check(avformat_alloc_output_context2(&opened, nullptr, "mp4", av::FileUrl(temporary).c_str()));
  output.reset(opened);
  // 4:2:0 needs even sizes: an odd last row or column is dropped.
  codec = OpenEncoder(width & ~1,
                      height & ~1,
                      frames_per_second,
                      (opened->oformat->flags & AVFMT_GLOBALHEADER) != 0);
  if (!codec)
    throw Error(path, "video cannot be written: FFmpeg has no encoder of H.264 or MPEG-4");
  stream = avformat_new_stream(opened, nullptr);
  stream->time_base = codec->time_base;
  stream->avg_frame_rate = codec->framerate;
  Check(avcodec_parameters_from_context(stream->codecpar, codec.get()));
  Check(avio_open(&opened->pb, av::FileUrl(temporary).c_str(), AVIO_FLAG_WRITE));
  Check(avformat_write_header(opened, nullptr));
  frame->format = codec->pix_fmt;
  frame->width = codec->width;
  frame->height = codec->height;
  Check(av_frame_get_buffer(frame.get(), 0));
  scaler.reset(sws_getContext(frame->width,
                              frame->height,
                              AV_PIX_FMT_RGB24,
                              frame->width,
                              frame->height,
                              codec->pix_fmt,
                              SWS_BICUBIC,
                              nullptr,
                              nullptr,
                              nullptr));
  if (!scaler) throw Error(path, "cannot hold frames of " + SizeText(width, height));
}

// A null image: what the encoder still holds.
void VideoWriter::Impl::Encode(const AVFrame* image) {
  Check(avcodec_send_frame(codec.get(), image));
  for (;;) {
    const int code = avcodec_receive_packet(codec.get(), packet.get());
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
    Check(code);
    av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
    packet->stream_index = stream->index;
    Check(av_interleaved_write_frame(output.get(), packet.get()));
    Check(output->pb->error);
  }
}

VideoWriter::VideoWriter(const std::string& path, int width, int height, double frames_per_second)
    : impl_(std::make_unique<Impl>()) {
  av::Quiet();
  const std::filesystem::path target(path);
  if (target.extension() != ".mp4") throw Error(path, "unknown video extension, expected .mp4");
  if (width < 2 || height < 2 || !(frames_per_second > 0))
    throw Error(path,
                "cannot hold frames of " + SizeText(width, height) + " at " +
                    std::to_string(frames_per_second) + " per second");
  impl_->path = path;
  impl_->temporary = TemporaryPath(path);
  impl_->width = width;
  impl_->height = height;
  try {
    impl_->Open(frames_per_second);
  } catch (const Error&) {
    impl_->output.reset();
    std::error_code ignored;
    std::filesystem::remove(impl_->temporary, ignored);
    throw;
  }
}

VideoWriter::~VideoWriter() {
  impl_->output.reset();
  std::error_code ignored;
  std::filesystem::remove(impl_->temporary, ignored);  // already gone after Finish()
}

void VideoWriter::Write(const Image8& rgb) {
  Impl& video = *impl_;
  if (rgb.width != video.width || rgb.height != video.height || rgb.channels != 3)
    throw Error(video.path,
                "frame " + std::to_string(video.written),
                "has size " + SizeText(rgb.width, rgb.height) + "x" + std::to_string(rgb.channels) +
                    ", expected " + SizeText(video.width, video.height) + "x3");
  video.Check(av_frame_make_writable(video.frame.get()));
  const uint8_t* const planes[] = {rgb.data.data()};
  const int strides[] = {3 * rgb.width};
  sws_scale(video.scaler.get(),
            planes,
            strides,
            0,
            video.frame->height,
            video.frame->data,
            video.frame->linesize);
  video.frame->pts = video.written++;
  video.Encode(video.frame.get());
}

void VideoWriter::Finish() {
  Impl& video = *impl_;
  if (video.written == 0) throw Error(video.path, "video could not be written: it has no frame");
  video.Encode(nullptr);
  video.Check(av_write_trailer(video.output.get()));
  video.Check(avio_closep(&video.output->pb));
  std::error_code code;
  std::filesystem::rename(video.temporary, video.path, code);
  if (code) throw Error(video.path, "cannot be written: " + code.message());
}

}  // namespace cosplat
