// What a training in blocks (block_training.h) keeps on disk, in the run's folder:
//   blocks/whole.bin      the whole scene, until it is split
//   blocks/N.bin          a block's Gaussians, from 1
//   blocks/N/V.rgba       its layer in training view V (splat/train/layers.h), [height, width, 4]
//                         without a header: training reads them in every step
#pragma once

#include <string>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/gaussians.h"

namespace cosplat {

class BlockFiles {
 public:
  // layout: of all Gaussians, with none of them.
  BlockFiles(const std::string& run_folder, const Gaussians& layout);

  // All functions throw Error if a file cannot be written, is missing or is damaged.
  void WriteWhole(const Gaussians& gaussians) const { Write("whole", gaussians); }
  Gaussians ReadWhole() const { return Read("whole"); }
  void RemoveWhole() const;
  void WriteBlock(size_t block, const Gaussians& gaussians) const {
    Write(NameOf(block), gaussians);
  }
  Gaussians ReadBlock(size_t block) const { return Read(NameOf(block)); }
  void WriteLayer(size_t block, size_t view, const Image8& layer) const;
  Image8 ReadLayer(size_t block, size_t view, const Camera& camera) const;

  // Makes the folder; removes it with all that is in it.
  static void Make(const std::string& run_folder);
  static void Remove(const std::string& run_folder);

 private:
  static std::string NameOf(size_t block) { return std::to_string(block + 1); }
  std::string LayerPath(size_t block, size_t view) const;
  void Write(const std::string& name, const Gaussians& gaussians) const;
  Gaussians Read(const std::string& name) const;

  std::string folder_;
  Gaussians layout_;
};

}  // namespace cosplat
