// cosplat voice: a voice as the motion of a face, to a live avatar or into a file.
//
// a microphone's program, standard input or a sound file -> VoiceFace -> lines, datagrams or a
// .csv.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/packet_output.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/voice_drive.h"
#include "avatar/live/json_frame.h"
#include "avatar/voice/voice_face.h"
#include "splat/base/error.h"
#include "splat/base/process.h"

namespace cosplat {
namespace {

struct VoiceOptions {
  std::string sound, to, out;
  unsigned seed = 0;
  bool quiet = false;
};

// What records a microphone: the sound servers' own programs, in the order of their delay.
std::vector<std::string> MicrophoneCommand() {
  const std::vector<std::vector<std::string>> recorders{
      {"parec", "--rate=16000", "--channels=1", "--format=s16le", "--latency-msec=20", "--raw"},
      {"arecord", "-q", "-t", "raw", "-f", "S16_LE", "-r", "16000", "-c", "1"},
      {"pw-record", "--rate=16000", "--channels=1", "--format=s16", "-"}};
  for (std::vector<std::string> command : recorders)
    if (const std::string program = FindProgram(command[0]); !program.empty()) {
      command[0] = program;
      return command;
    }
  throw Error("the microphone",
              "needs parec (Debian: pulseaudio-utils), arecord (alsa-utils) or pw-record "
              "(pipewire-bin)");
}

// Frames, at the pace at which they were spoken.
class Speaker {
 public:
  explicit Speaker(const VoiceOptions& o) : output_(o.to), face_(o.seed) {}

  void Say(std::span<const float> samples) {
    frames_.clear();
    face_.Push(samples, frames_);
    Send(frames_);
  }
  void Finish() {
    frames_.clear();
    face_.Finish(frames_);
    Send(frames_);
  }
  void Send(std::vector<ScoredFrame>& frames) {
    using Seconds = std::chrono::duration<double>;
    for (ScoredFrame& frame : frames) {
      JsonFrame packet;
      packet.sequence = uint64_t(frame.timestep);
      packet.time = double(frame.timestep) / VoiceFace::kFramesPerSecond;
      packet.params.pose[0] = TurnOf(frame.head);
      packet.blendshapes = std::move(frame.scores);
      // Of a file, or of a pipe that holds more than was said by now.
      std::this_thread::sleep_until(start_ + Seconds(*packet.time - kAhead));
      output_.Write(output_.PacketOf(packet, {}));
    }
  }

 private:
  static constexpr double kAhead = 0.1;  // seconds; microphones deliver some together
  PacketOutput output_;
  VoiceFace face_;
  std::vector<ScoredFrame> frames_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Sound files begin so; as samples they would be heard as a noise and then, of another rate or of
// two channels, as another voice.
void RefuseFile(const char* begin, size_t size) {
  for (const char* magic : {"RIFF", "OggS", "fLaC", "ID3", "\x1a\x45\xdf\xa3", ".snd", "FORM"})
    if (size >= 4 && std::memcmp(begin, magic, std::strlen(magic)) == 0)
      throw Error("standard input",
                  "is a sound file; expected samples of 16 bits, 16000 per second, one channel: "
                  "ffmpeg -i FILE -f s16le -ar 16000 -ac 1 -");
}

// Little-endian samples of 16 bits, until the descriptor's end.
void SayDescriptor(int descriptor, const std::string& name, bool quiet, Speaker& speaker) {
  constexpr int kSilentSeconds = 5;
  std::vector<char> bytes(8192);
  std::vector<float> samples;
  size_t held = 0;  // bytes of a sample that is not whole
  int64_t heard = 0;
  bool silent = true;
  for (;;) {
    const ssize_t count = read(descriptor, bytes.data() + held, bytes.size() - held);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    const size_t size = held + size_t(count);
    if (heard == 0) RefuseFile(bytes.data(), size);
    samples.clear();
    for (size_t i = 0; i + 1 < size; i += 2) {
      const auto low = uint8_t(bytes[i]), high = uint8_t(bytes[i + 1]);
      samples.push_back(float(int16_t(uint16_t(low | (high << 8)))) / 32768);
      silent = silent && samples.back() == 0;
    }
    const int64_t before = heard;
    heard += int64_t(samples.size());
    held = size % 2;
    if (held != 0) bytes[0] = bytes[size - 1];
    if (silent && !quiet && before < kSilentSeconds * kSoundRate &&
        heard >= kSilentSeconds * kSoundRate)
      std::fprintf(
          stderr, "%s: nothing but zeros for %d s: is it muted?\n", name.c_str(), kSilentSeconds);
    speaker.Say(samples);
  }
  if (heard == 0) throw Error(name, "has no sound");
  speaker.Finish();
}

ScoreRecording LoadVoiceAloud(const VoiceOptions& o) {
  ScoreRecording recording = LoadVoice(o.sound, o.seed);
  for (const std::string& note : recording.notes) PrintNotes({o.sound + ": " + note});
  return recording;
}

void Listen(const VoiceOptions& o) {
  Speaker speaker(o);
  if (o.sound == "-") return SayDescriptor(STDIN_FILENO, "standard input", o.quiet, speaker);
  if (!o.sound.empty()) {
    ScoreRecording recording = LoadVoiceAloud(o);
    return speaker.Send(recording.frames);
  }
  const std::vector<std::string> command = MicrophoneCommand();
  if (!o.quiet)
    std::fprintf(
        stderr, "the microphone, by %s\n", std::filesystem::path(command[0]).filename().c_str());
  ChildProcess recorder(command, {}, ChildProcess::Errors::kAsOurs);
  SayDescriptor(recorder.output(), "the microphone", o.quiet, speaker);
  throw Error(command[0], ExitText(recorder.Wait()));
}

void Run(const VoiceOptions& o) {
  if (o.out.empty()) return Listen(o);
  if (o.sound.empty() || o.sound == "-")
    throw Error("--out", "needs a sound file; what is live goes to --to");
  if (!o.to.empty()) throw Error("--out", "excludes --to: one or the other");
  if (std::filesystem::path(o.out).extension() != ".csv")
    throw Error(o.out, "is no .csv, Live Link Face's table");
  RefuseInput("-o", o.out, o.sound);
  const ScoreRecording recording = LoadVoiceAloud(o);
  WriteLiveLinkRecording(recording, o.out);
  if (!o.quiet)
    std::printf("%zu frames at %.0f per second: %s\n",
                recording.frames.size(),
                recording.frames_per_second,
                o.out.c_str());
}

}  // namespace

void AddVoice(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("voice", "move a face by a voice: send it to a live avatar, or write it");
  const auto o = std::make_shared<VoiceOptions>();
  command->add_option("sound",
                      o->sound,
                      "a sound or video file; - for samples on standard input (16 bits, 16000 per "
                      "second, one channel); the microphone if not given");
  command->add_option(
      "--to", o->to, "udp://HOST:PORT or vmc://HOST:PORT; lines on standard output if not given");
  command->add_option("-o,--out",
                      o->out,
                      "of a file: write Live Link Face's table (.csv), which every drive takes");
  command->add_option("--seed", o->seed, "of blinks and the head's sway");
  command->add_flag("--quiet", o->quiet, "print nothing but errors and, without --to, the frames");
  command->callback([o] { Run(*o); });
}

}  // namespace cosplat
