#include "splat/media/sound_track.h"

#include <algorithm>

#include "splat/base/error.h"

namespace cosplat::libav {
namespace {

constexpr int64_t kBitsPerSecond = 160000;

}  // namespace

void SoundTrack::Check(int code) const {
  if (code < 0) throw Error(name_, "its sound cannot be written: " + ErrorText(code));
}

SoundTrack::SoundTrack(const std::string& name, AVFormatContext& output, Sound sound)
    : name_(name), output_(output), sound_(std::move(sound)) {
  const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_AAC);
  if (encoder == nullptr)
    throw Error(name, "its sound cannot be written: FFmpeg has no encoder of AAC");
  codec_.reset(avcodec_alloc_context3(encoder));
  codec_->sample_fmt = AV_SAMPLE_FMT_FLTP;
  codec_->sample_rate = sound_.rate;
  codec_->bit_rate = kBitsPerSecond;
  codec_->time_base = {1, sound_.rate};
  av_channel_layout_default(&codec_->ch_layout, sound_.channels);
  if ((output.oformat->flags & AVFMT_GLOBALHEADER) != 0)
    codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  Check(avcodec_open2(codec_.get(), encoder, nullptr));
  frame_->format = codec_->sample_fmt;
  frame_->sample_rate = sound_.rate;
  frame_->nb_samples = codec_->frame_size;
  Check(av_channel_layout_copy(&frame_->ch_layout, &codec_->ch_layout));
  Check(av_frame_get_buffer(frame_.get(), 0));
  stream_ = avformat_new_stream(&output, nullptr);
  stream_->time_base = codec_->time_base;
  Check(avcodec_parameters_from_context(stream_->codecpar, codec_.get()));
}

void SoundTrack::Encode(const AVFrame* samples) {
  Check(EncodeInto(output_, *stream_, *codec_, samples, *packet_));
}

void SoundTrack::WriteUntil(double seconds) {
  const auto channels = size_t(sound_.channels);
  const auto total = int64_t(sound_.samples.size() / channels);
  while (written_ < total && double(written_) < seconds * sound_.rate) {
    Check(av_frame_make_writable(frame_.get()));
    const int64_t count = std::min<int64_t>(codec_->frame_size, total - written_);
    for (size_t c = 0; c < channels; ++c) {
      auto* out = reinterpret_cast<float*>(frame_->extended_data[c]);
      for (int64_t i = 0; i < count; ++i)
        out[i] = sound_.samples[size_t(written_ + i) * channels + c];
    }
    frame_->nb_samples = int(count);
    frame_->pts = written_;
    Encode(frame_.get());
    written_ += count;
  }
}

void SoundTrack::Finish() { Encode(nullptr); }

}  // namespace cosplat::libav
