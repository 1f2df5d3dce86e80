#include "splat/media/sound.h"

extern "C" {
#include <libavutil/channel_layout.h>
#include <libavutil/opt.h>
#include <libswresample/swresample.h>
}

#include <algorithm>
#include <utility>

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/media/libav.h"

namespace cosplat {
namespace {

using Resampler = std::unique_ptr<SwrContext, libav::FreeByAddress<swr_free>>;

class SoundFile {
 public:
  SoundFile(const std::string& path, int rate, int channels) : path_(path) {
    libav::Quiet();
    input_ = libav::OpenInput(path, "sound");
    const AVCodec* decoder = nullptr;
    track_ = av_find_best_stream(input_.get(), AVMEDIA_TYPE_AUDIO, -1, -1, &decoder, 0);
    if (track_ == AVERROR_STREAM_NOT_FOUND) throw Error(path, "has no audio track");
    codec_.reset(track_ >= 0 ? avcodec_alloc_context3(decoder) : nullptr);
    if (!codec_)
      throw Error(path, "is encoded in a way that FFmpeg's libraries here cannot decode");
    int code = avcodec_parameters_to_context(codec_.get(), input_->streams[track_]->codecpar);
    if (code >= 0) code = avcodec_open2(codec_.get(), decoder, nullptr);
    if (code < 0) throw Error(path, "cannot be decoded: " + libav::ErrorText(code));
    sound_.rate = rate;
    sound_.channels = channels;
  }

  Sound Read() {
    while (av_read_frame(input_.get(), packet_.get()) >= 0) {
      if (packet_->stream_index == track_) Decode(packet_.get());
      av_packet_unref(packet_.get());
    }
    Decode(nullptr);
    Convert(nullptr);
    if (sound_.samples.empty()) throw Error(path_, "has no sound that can be decoded");
    NoteCut();
    return std::move(sound_);
  }

 private:
  void Decode(const AVPacket* packet) {
    if (avcodec_send_packet(codec_.get(), packet) < 0) return;
    while (avcodec_receive_frame(codec_.get(), frame_.get()) >= 0) {
      if (!std::exchange(begun_, true)) BeginLater(frame_->best_effort_timestamp);
      Convert(frame_.get());
    }
  }

  // time: the first samples'. They begin with the file, of which a video's picture may begin first.
  void BeginLater(int64_t time) {
    const int64_t start = input_->start_time;
    if (time == AV_NOPTS_VALUE || start == AV_NOPTS_VALUE) return;
    const double late =
        double(time) * av_q2d(input_->streams[track_]->time_base) - double(start) / AV_TIME_BASE;
    constexpr double kMaxLate = 600;  // s; beyond it the time is none
    if (late > 0 && late < kMaxLate)
      silence_ = size_t(late * sound_.rate) * size_t(sound_.channels);
    sound_.samples.resize(silence_);
  }

  // Of the track, where the file states it: other lengths are guesses. 0: it does not.
  double StatedSeconds() const {
    const AVStream& track = *input_->streams[track_];
    if (input_->duration_estimation_method != AVFMT_DURATION_FROM_STREAM) return 0;
    if (track.duration != AV_NOPTS_VALUE) return double(track.duration) * av_q2d(track.time_base);
    return input_->nb_streams == 1 ? double(input_->duration) / AV_TIME_BASE : 0;
  }

  void NoteCut() {
    constexpr double kShare = 0.05, kSeconds = 0.2;
    const double stated = StatedSeconds();
    const double read = double(sound_.samples.size() - silence_) / sound_.channels / sound_.rate;
    if (stated - read > std::max(kSeconds, kShare * stated))
      sound_.notes.push_back(
          Format("is cut off or damaged: it is to be {:.1f} s long, {:.1f} s can be decoded",
                 stated,
                 read));
  }

  // Null: what the resampler still holds.
  void Convert(const AVFrame* frame) {
    if (frame != nullptr && (!resampler_ || Differs(*frame))) {
      Convert(nullptr);
      OpenResampler(*frame);
    }
    if (!resampler_) return;
    const int count = frame != nullptr ? frame->nb_samples : 0;
    const int most = swr_get_out_samples(resampler_.get(), count);
    const size_t channels = size_t(sound_.channels), before = sound_.samples.size();
    sound_.samples.resize(before + size_t(most) * channels);
    auto* out = reinterpret_cast<uint8_t*>(sound_.samples.data() + before);
    auto** in = frame != nullptr ? const_cast<const uint8_t**>(frame->extended_data) : nullptr;
    const int written = swr_convert(resampler_.get(), &out, most, in, count);
    sound_.samples.resize(before + size_t(std::max(written, 0)) * channels);
  }

  bool Differs(const AVFrame& frame) const {
    return frame.sample_rate != rate_ || frame.format != format_ ||
           frame.ch_layout.nb_channels != channels_;
  }

  void OpenResampler(const AVFrame& frame) {
    rate_ = frame.sample_rate;
    format_ = frame.format;
    channels_ = frame.ch_layout.nb_channels;
    AVChannelLayout to, from;
    av_channel_layout_default(&to, sound_.channels);
    // Files of several unnamed channels, as some recorders write them.
    if (frame.ch_layout.order == AV_CHANNEL_ORDER_UNSPEC)
      av_channel_layout_default(&from, channels_);
    else
      from = frame.ch_layout;
    SwrContext* opened = nullptr;
    int code = swr_alloc_set_opts2(&opened,
                                   &to,
                                   AV_SAMPLE_FMT_FLT,
                                   sound_.rate,
                                   &from,
                                   AVSampleFormat(format_),
                                   rate_,
                                   0,
                                   nullptr);
    resampler_.reset(opened);
    // The mean of channels that carry one voice is as loud as each, not louder than 1.
    if (code >= 0) code = av_opt_set_double(opened, "rematrix_maxval", 1, 0);
    if (code >= 0) code = swr_init(opened);
    if (code < 0) throw Error(path_, "cannot be resampled: " + libav::ErrorText(code));
  }

  std::string path_;
  libav::Input input_;
  libav::Codec codec_;
  libav::Frame frame_{av_frame_alloc()};
  libav::Packet packet_{av_packet_alloc()};
  Resampler resampler_;
  bool begun_ = false;
  size_t silence_ = 0;  // samples before the track begins
  int track_ = -1, rate_ = 0, format_ = 0, channels_ = 0;
  Sound sound_;
};

}  // namespace

Sound ReadSound(const std::string& path, int rate, int channels) {
  return SoundFile(path, rate, channels).Read();
}

}  // namespace cosplat
