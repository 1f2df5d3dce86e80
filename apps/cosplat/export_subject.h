// What `cosplat export` writes: a scene, an avatar, a stand-alone splat file, or an avatar trained
// with GaussianAvatars.
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
  bool views = false;       // Significance, Seen or Quantised will be called
  bool measure = false;     // AsTrained and FromFile will be called
};

class ExportSubject {
 public:
  virtual ~ExportSubject() = default;
  const Gaussians& gaussians() const { return gaussians_; }  // in world space, as 3DGS's SH
  const std::string& path() const { return path_; }          // of the splat file
  virtual bool is_avatar() const { return false; }  // if true, gaussians() is the avatar at rest
  // A scene, or an avatar that has no .glb yet. Throws Error for one that has.
  virtual void WriteGlb(const std::string& path, bool truncate_degree) const = 0;
  // A run's folder for `render`, `metrics` and `play`. Throws Error if it has one.
  virtual void WriteRun(const std::string& folder, bool truncate_degree) const;
  // [N] what an error in the colour of each of gaussians() weighs, for codebooks: by the training
  // views, or by size if there are none.
  virtual std::vector<float> Significance() const { return SizeSignificance(gaussians_); }
  // SeenBands of gaussians(), truncated to kMaxSplatFileDegree, from the training views; empty if
  // there are none.
  virtual std::vector<float> Seen() const { return {}; }
  virtual QuantisedSplats Quantised(const VqSettings& settings) const = 0;
  // The run's test views: of the trained model, and of a file that was exported. A file of an
  // avatar must have been written from Quantised's result.
  virtual TestViews AsTrained() = 0;
  virtual TestViews FromFile(const std::string& path) = 0;

 protected:
  ExportSubject(const std::string& path, Gaussians gaussians)
      : path_(path), gaussians_(std::move(gaussians)) {}

 private:
  std::string path_;
  Gaussians gaussians_;
};

// Throws Error if something is missing, or if `measure` is set and the run has no test views.
std::unique_ptr<ExportSubject> LoadExportSubject(const ExportSource& source);

}  // namespace cosplat
