// What `cosplat export` writes: a scene, an avatar or a file of splats alone.
#pragma once

#include <memory>
#include <string>

#include "apps/cosplat/export_measure.h"
#include "splat/io/vq.h"

namespace cosplat {

struct ExportSource {
  std::string model;        // a run's folder, or empty
  std::string splats;       // a file of splats, in place of the run's own; or empty
  std::string data, flame;  // in place of what run.json names, where not empty
  bool quantise = false;    // Quantised will be called
  bool measure = false;     // AsTrained and FromFile will be
};

class ExportSubject {
 public:
  virtual ~ExportSubject() = default;
  const Gaussians& gaussians() const { return gaussians_; }  // in the world, 3DGS's SH
  const std::string& path() const { return path_; }          // of the file they came from
  virtual bool is_avatar() const { return false; }           // they are the avatar at rest then
  virtual QuantisedSplats Quantised(const VqSettings& settings) const = 0;
  // The run's test views; of the second, from a file that Quantised went into.
  virtual TestViews AsTrained() = 0;
  virtual TestViews FromFile(const std::string& path) = 0;

 protected:
  explicit ExportSubject(const std::string& path);

 private:
  std::string path_;
  Gaussians gaussians_;
};

// Throws Error when something is missing; also when there is nothing to measure on.
std::unique_ptr<ExportSubject> LoadExportSubject(const ExportSource& source);

}  // namespace cosplat
