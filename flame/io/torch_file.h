// PyTorch's checkpoints (torch.save since 1.6), read as data: a ZIP archive that holds a pickle,
// NAME/data.pkl, and the bytes of each tensor's storage, NAME/data/KEY.
#pragma once

#include <string>

#include "flame/io/pickle.h"

namespace cosplat {

// Throws Error naming the file and the member if it is no such archive, if its numbers are stored
// big-endian, or if the pickle is refused.
Pickle ReadTorchFile(const std::string& path);

}  // namespace cosplat
