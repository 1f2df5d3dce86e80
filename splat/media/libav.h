// FFmpeg's libraries for video and sound: owners of its objects, errors as text.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/dovi_meta.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>

#include "splat/base/error.h"

namespace cosplat::libav {

template <auto kFree>
struct FreeByAddress {
  template <class T>
  void operator()(T* object) const {
    kFree(&object);
  }
};
struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
using Input = std::unique_ptr<AVFormatContext, FreeByAddress<avformat_close_input>>;
using Codec = std::unique_ptr<AVCodecContext, FreeByAddress<avcodec_free_context>>;
using Frame = std::unique_ptr<AVFrame, FreeByAddress<av_frame_free>>;
using Packet = std::unique_ptr<AVPacket, FreeByAddress<av_packet_free>>;
using Scaler = std::unique_ptr<SwsContext, FreeScaler>;

// A file of this name, even if the name has a colon, which would be taken for a protocol's.
inline std::string FileUrl(const std::string& path) { return "file:" + path; }

inline std::string ErrorText(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return text;
}

// Opens a file and looks into its tracks. what: it is to be, for the Error that is thrown.
inline Input OpenInput(const std::string& path, const char* what) {
  AVFormatContext* opened = nullptr;
  int code = avformat_open_input(&opened, FileUrl(path).c_str(), nullptr, nullptr);
  Input input(opened);
  if (code >= 0) code = avformat_find_stream_info(opened, nullptr);
  if (code < 0)
    throw Error(path, std::string("cannot be opened as a ") + what + ": " + ErrorText(code));
  return input;
}

// Encodes a frame into a track of the output; null: what the encoder still holds. Returns FFmpeg's
// code.
inline int EncodeInto(AVFormatContext& output,
                      AVStream& track,
                      AVCodecContext& codec,
                      const AVFrame* frame,
                      AVPacket& packet) {
  int code = avcodec_send_frame(&codec, frame);
  while (code >= 0) {
    code = avcodec_receive_packet(&codec, &packet);
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return 0;
    if (code < 0) return code;
    av_packet_rescale_ts(&packet, codec.time_base, track.time_base);
    packet.stream_index = track.index;
    code = av_interleaved_write_frame(&output, &packet);
    if (code >= 0) code = output.pb->error;
  }
  return code;
}

// Failures are reported as Error; nothing is written to stderr.
inline void Quiet() { av_log_set_level(AV_LOG_QUIET); }

}  // namespace cosplat::libav
