// "audio:FILE" beside the recordings of avatar/live/recording.h: the sound of a file as the motion
// of a face.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "avatar/live/recording.h"
#include "avatar/live/score_recording.h"
#include "splat/media/sound.h"

namespace cosplat {

// The file of "audio:FILE"; empty for other drives, and for "audio:" and "audio:-", which are live.
std::string SoundFileOf(const std::string& drive);

// The scores of what a sound or video file says. Throws Error as ReadSound and RecordingOfVoice do.
ScoreRecording LoadVoice(const std::string& path, uint64_t seed = 0);

// What "audio:FILE" sounds like, for a video; none for other drives.
std::optional<Sound> VideoSoundOf(const std::string& drive);

// LoadRecording, or of "audio:FILE" its voice; prints its notes.
Recording LoadDrive(const std::string& drive, const LiveSourceOptions& options);

}  // namespace cosplat
