// How fast a trained model is drawn: frames per second of its held-out views.
#pragma once

#include <string>

namespace cosplat {

// Per second of one core's processor time, of the model as its folder has it, each frame drawn
// whole (an avatar's is posed too); the best of several passes over all held-out views. Reads the
// run's data set. Throws Error when something of it is missing.
double StudyFramesPerSecond(const std::string& model_folder);

}  // namespace cosplat
