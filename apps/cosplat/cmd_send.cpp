// cosplat send: sends a recorded sequence to a live avatar, as a tracker would.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/packet_output.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/voice_drive.h"
#include "avatar/live/json_frame.h"
#include "avatar/live/score_recording.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/base/rng.h"

namespace cosplat {
namespace {

struct SendOptions {
  std::string sequence, to, flame;
  double frames_per_second = 0, drop_percent = 0, bad_percent = 0;
  bool loop = false;
  unsigned seed = 0;
  bool quiet = false;
};

// The frames of a sequence, as they are sent.
struct Sequence {
  struct Frame {
    int64_t timestep = 0;
    JsonFrame packet;  // without number and time
  };
  double frames_per_second = 0;
  std::vector<Frame> frames;
  BlendshapeMap map;  // of FLAME parameters as scores
};

// A packet that receivers must reject, for one of several reasons.
std::string Spoilt(const std::string& packet, Rng& rng) {
  switch (rng.Below(5)) {
    case 0:  // truncated
      return packet.substr(0, packet.size() / 2);
    case 1:  // non-finite
      return packet.substr(0, packet.size() - 1) + ", \"jaw\": [NaN, 0, 0]}";
    case 2:  // one number too few
      return packet.substr(0, packet.size() - 1) + ", \"neck\": [0, 0]}";
    case 3:  // too long
      return packet + std::string(20'000, ' ');
    default: {  // noise on a single line
      std::string noise(64, '\0');
      for (char& c : noise) c = char(' ' + rng.Below(200));
      return noise;
    }
  }
}

struct Counts {
  long sent = 0, dropped = 0, bad = 0, lost = 0;
};

void Send(const SendOptions& o, Sequence& sequence, PacketOutput& output, Counts& counts) {
  using Seconds = std::chrono::duration<double>;
  const double length = double(sequence.frames.back().timestep + 1) / sequence.frames_per_second;
  const auto start = std::chrono::steady_clock::now();
  Rng rng{o.seed};
  uint64_t number = 0;
  ProgressBar bar("send", int(sequence.frames.size()), o.quiet || o.to.empty() || o.loop);
  for (uint64_t round = 0; round == 0 || o.loop; ++round)
    for (auto& [timestep, packet] : sequence.frames) {
      packet.time = double(round) * length + double(timestep) / sequence.frames_per_second;
      packet.sequence = number++;
      std::this_thread::sleep_until(start + Seconds(*packet.time));
      const std::string line = output.PacketOf(packet, sequence.map);
      bar.Update(int(number), "frames");
      const float chance = 100 * rng.Uniform();
      if (chance < o.drop_percent) {
        ++counts.dropped;
        continue;
      }
      const bool bad = chance < o.drop_percent + o.bad_percent;
      counts.bad += bad;
      counts.lost += !output.Write(bad ? Spoilt(line, rng) : line);
      ++counts.sent;
    }
}

Sequence LoadSequence(const SendOptions& o) {
  LiveSourceOptions options;
  options.frames_per_second = o.frames_per_second;
  FlameModel flame;
  if (!o.flame.empty()) {
    flame = LoadFlameModel(o.flame);
    options.flame = &flame;
  }
  const Recording recording = LoadDrive(o.sequence, options);
  Sequence sequence;
  sequence.frames_per_second = recording.frames_per_second;
  sequence.map = GeneralBlendshapeMap(options.flame);
  for (const RecordedFrame& frame : recording.frames) {
    sequence.frames.push_back({frame.timestep, {}});
    sequence.frames.back().packet.params = frame.params;
  }
  const std::string sound = SoundFileOf(o.sequence);
  if (sound.empty() && !IsScoreRecording(o.sequence)) return sequence;
  const ScoreRecording scores = sound.empty() ? LoadScores(o.sequence) : LoadVoice(sound);
  for (size_t i = 0; i < scores.frames.size(); ++i)
    sequence.frames[i].packet.blendshapes = scores.frames[i].scores;
  return sequence;
}

void Run(const SendOptions& o) {
  if (o.drop_percent + o.bad_percent > 100)
    throw Error("--drop and --bad", "add up to more than 100 percent");
  Sequence sequence = LoadSequence(o);
  PacketOutput output(o.to);
  Counts counts;
  Send(o, sequence, output, counts);
  if (o.quiet || o.to.empty()) return;
  std::printf("%ld packets sent to %s, %ld of them corrupted; %ld dropped\n",
              counts.sent,
              o.to.c_str(),
              counts.bad,
              counts.dropped);
  if (counts.lost > 0)
    std::printf("%ld were refused: is a receiver listening there?\n", counts.lost);
}

}  // namespace

void AddSend(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("send", "play a recorded sequence to a live avatar, as a tracker does");
  const auto o = std::make_shared<SendOptions>();
  command
      ->add_option(
          "sequence",
          o->sequence,
          "tracked video, .npz, landmarks file with scores, .csv of Live Link Face, or audio:FILE")
      ->required();
  command->add_option(
      "--to",
      o->to,
      "udp://HOST:PORT or vmc://HOST:PORT, which carries the head and blendshape scores, of FLAME "
      "parameters those of jaw, gaze and, with --flame, lids; lines on standard output if not "
      "given");
  command->add_option(
      "--flame", o->flame, "FLAME model; needed for metrical-tracker's and INSTA's tracks only");
  command->add_option("--fps", o->frames_per_second, "frames per second; 0: its own, or 25")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--loop", o->loop, "again and again, until it is interrupted");
  command->add_option("--drop", o->drop_percent, "percent of the frames to leave out")
      ->check(CLI::Range(0.0, 100.0));
  command->add_option("--bad", o->bad_percent, "percent of the packets to spoil")
      ->check(CLI::Range(0.0, 100.0));
  command->add_option("--seed", o->seed, "seed for --drop and --bad");
  command->add_flag("--quiet", o->quiet, "print nothing but errors and, without --to, the frames");
  command->callback([o] { Run(*o); });
}

}  // namespace cosplat
