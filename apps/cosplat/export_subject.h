// What `cosplat export` writes: a scene, an avatar or a stand-alone splat file.
#pragma once

#include <memory>
#include <string>

#include "apps/cosplat/export_measure.h"
#include "splat/io/vq.h"

namespace cosplat {

struct ExportSource {
  std::string model;        // run folder, or empty
  std::string splats;       // splat file that replaces the run's own, or empty
  std::string data, flame;  // override the paths in run.json unless empty
  bool quantise = false;    // Quantised will be called
  bool measure = false;     // AsTrained and FromFile will be called
};

class ExportSubject {
 public:
  virtual ~ExportSubject() = default;
  const Gaussians& gaussians() const { return gaussians_; }  // in world space, as 3DGS's SH
  const std::string& path() const { return path_; }          // of the splat file
  virtual bool is_avatar() const { return false; }  // if true, gaussians() is the avatar at rest
  virtual QuantisedSplats Quantised(const VqSettings& settings) const = 0;
  // The run's test views: of the trained model, and of a file written from Quantised's result.
  virtual TestViews AsTrained() = 0;
  virtual TestViews FromFile(const std::string& path) = 0;

 protected:
  explicit ExportSubject(const std::string& path);

 private:
  std::string path_;
  Gaussians gaussians_;
};

// Throws Error if something is missing, or if `measure` is set and the run has no test views.
std::unique_ptr<ExportSubject> LoadExportSubject(const ExportSource& source);

}  // namespace cosplat
