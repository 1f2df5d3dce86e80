#include "apps/cosplat/run/voice_drive.h"

#include "avatar/voice/voice_face.h"
#include "splat/media/sound.h"

namespace cosplat {

std::string SoundFileOf(const std::string& drive) {
  constexpr std::string_view kScheme = "audio:";
  const std::string file = drive.starts_with(kScheme) ? drive.substr(kScheme.size()) : "";
  return file == "-" ? "" : file;
}

ScoreRecording LoadVoice(const std::string& path, uint64_t seed) {
  return RecordingOfVoice(path, ReadSound(path, kSoundRate, 1).samples, seed);
}

Recording LoadDrive(const std::string& drive, const LiveSourceOptions& options) {
  const std::string sound = SoundFileOf(drive);
  return sound.empty() ? LoadRecording(drive, options)
                       : RecordingOf(LoadVoice(sound), drive, options);
}

}  // namespace cosplat
