#include "apps/cosplat/run/voice_drive.h"

#include <string_view>

#include "apps/cosplat/run/notes.h"
#include "avatar/voice/voice_face.h"

namespace cosplat {

std::string SoundFileOf(const std::string& drive) {
  constexpr std::string_view kScheme = "audio:";
  const std::string file = drive.starts_with(kScheme) ? drive.substr(kScheme.size()) : "";
  return file == "-" ? "" : file;
}

ScoreRecording LoadVoice(const std::string& path, uint64_t seed) {
  const Sound sound = ReadSound(path, kSoundRate, 1);
  ScoreRecording recording = RecordingOfVoice(path, sound.samples, seed);
  recording.notes = sound.notes;
  return recording;
}

std::optional<Sound> VideoSoundOf(const std::string& drive) {
  constexpr int kRate = 48000, kChannels = 2;
  const std::string file = SoundFileOf(drive);
  if (file.empty()) return {};
  return ReadSound(file, kRate, kChannels);
}

Recording LoadDrive(const std::string& drive, const LiveSourceOptions& options) {
  const std::string sound = SoundFileOf(drive);
  Recording recording =
      sound.empty() ? LoadRecording(drive, options) : RecordingOf(LoadVoice(sound), drive, options);
  PrintNotes(recording.notes);
  return recording;
}

}  // namespace cosplat
