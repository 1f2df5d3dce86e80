#include "avatar/train/blendshape_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "splat/base/error.h"

namespace cosplat {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;

// A score that varies less in all frames is noise, which a sender with another scale would enlarge.
constexpr double kMinRange = 0.05;
constexpr size_t kFolds = 10;
constexpr size_t kMinFramesPerFold = 6;
// Candidates of the ridge's strength, relative to the variance of a standardised score.
constexpr std::array<double, 10> kStrengths{1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1, 3};
// The figures are of this many frames at most, evenly spaced, and of the vertices that move by this
// much from the mean face in one of them.
constexpr size_t kMaxMeasured = 500;
constexpr float kMoved = 1e-3f;  // metres

constexpr size_t kJaw = 2;  // the jaw in FlameParams::pose; the eyes follow

RowVectorXd OutputsOf(const FlameParams& face, size_t expressions) {
  RowVectorXd out = RowVectorXd::Zero(long(expressions + kMappedTurns));
  for (size_t e = 0; e < std::min(expressions, face.expression.size()); ++e)
    out[long(e)] = face.expression[e];
  for (size_t t = 0; t < kMappedTurns; ++t)
    out[long(expressions + t)] = face.pose[kJaw + t / 3][t % 3];
  return out;
}

FlameParams FaceOf(const RowVectorXd& outputs) {
  FlameParams face;
  const size_t expressions = size_t(outputs.size()) - kMappedTurns;
  for (size_t e = 0; e < expressions; ++e) face.expression.push_back(float(outputs[long(e)]));
  for (size_t t = 0; t < kMappedTurns; ++t)
    face.pose[kJaw + t / 3][t % 3] = float(outputs[long(expressions + t)]);
  return face;
}

std::vector<float> PosedFace(const FlamePoser<float>& poser, const FlameParams& face) {
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(face), vertices);
  return vertices;
}

// Samples as matrices, without the scores that do not vary.
struct Table {
  std::vector<std::string> names;
  MatrixXd scores;   // [N, C]
  MatrixXd outputs;  // [N, E + kMappedTurns]
};

RowVectorXd RowOf(const BlendshapeMap& map, size_t c) {
  const size_t width = map.offset.size();
  RowVectorXd row(static_cast<long>(width));
  for (size_t o = 0; o < width; ++o) row[long(o)] = map.matrix[c * width + o];
  return row;
}

Table TableOf(const BlendshapeSamples& samples, const FlameModel& model) {
  const size_t expressions = size_t(model.expression_count);
  const long n = long(samples.size());
  Table table;
  table.outputs.resize(n, long(expressions + kMappedTurns));
  for (long i = 0; i < n; ++i)
    table.outputs.row(i) = OutputsOf(samples.faces[size_t(i)], expressions);
  for (size_t c = 0; c < samples.names.size(); ++c) {
    Eigen::VectorXd column(n);
    for (long i = 0; i < n; ++i) column[i] = samples.scores[size_t(i)][c];
    if (column.maxCoeff() - column.minCoeff() < kMinRange) continue;
    const long used = long(table.names.size());
    table.names.push_back(samples.names[c]);
    table.scores.conservativeResize(n, used + 1);
    table.scores.col(used) = column;
  }
  return table;
}

// Where on the face a score or an output is, by its name.
enum class Region { kAny, kEyes, kMouth };

Region RegionOf(const std::string& name) {
  const std::string normal = NormalName(name);
  const auto begins = [&](const char* with) { return normal.starts_with(with); };
  if (begins("eye") || begins("brow")) return Region::kEyes;
  if (begins("jaw") || begins("mouth") || begins("cheek") || begins("nose")) return Region::kMouth;
  return Region::kAny;
}

// [C, E + kMappedTurns], 1 where an output may follow a score: one of its own region or of no known
// one, or any if none of these varies. What else changes at the same time is the video's chance.
MatrixXd Followed(const std::vector<std::string>& scores, const FlameModel& model) {
  std::vector<Region> outputs(size_t(model.expression_count), Region::kAny);
  for (size_t e = 0; e < model.expression_names.size(); ++e)
    outputs[e] = RegionOf(model.expression_names[e]);
  if (model.has_eyelids) std::fill_n(outputs.rbegin(), 2, Region::kEyes);
  outputs.insert(outputs.end(), 3, Region::kMouth);  // the jaw's turn
  outputs.insert(outputs.end(), kMappedTurns - 3, Region::kEyes);
  MatrixXd followed(scores.size(), outputs.size());
  for (size_t o = 0; o < outputs.size(); ++o) {
    for (size_t c = 0; c < scores.size(); ++c) {
      const Region score = RegionOf(scores[c]);
      followed(long(c), long(o)) =
          outputs[o] == Region::kAny || score == Region::kAny || score == outputs[o];
    }
    if (followed.col(long(o)).isZero()) followed.col(long(o)).setOnes();
  }
  return followed;
}

// Rows of a table that a fit uses: all but [begin, end).
struct Fold {
  long begin = 0, end = 0;
};

std::vector<Fold> FoldsOf(size_t frames) {
  const size_t count = std::clamp(frames / kMinFramesPerFold, size_t(2), kFolds);
  std::vector<Fold> folds;
  for (size_t k = 0; k < count; ++k)
    folds.push_back({long(k * frames / count), long((k + 1) * frames / count)});
  return folds;
}

MatrixXd Without(const MatrixXd& rows, const Fold& fold) {
  MatrixXd rest(rows.rows() - (fold.end - fold.begin), rows.cols());
  rest.topRows(fold.begin) = rows.topRows(fold.begin);
  rest.bottomRows(rows.rows() - fold.end) = rows.bottomRows(rows.rows() - fold.end);
  return rest;
}

// Ridge regressions on the rows outside a fold. What does not depend on the strength is computed
// once.
class Regression {
 public:
  Regression(const Table& table, const MatrixXd& followed, const Fold& fold)
      : names_(table.names), followed_(followed) {
    MatrixXd x = Without(table.scores, fold), y = Without(table.outputs, fold);
    least_ = x.colwise().minCoeff();
    most_ = x.colwise().maxCoeff();
    x_mean_ = x.colwise().mean();
    y_mean_ = y.colwise().mean();
    x.rowwise() -= x_mean_;
    y.rowwise() -= y_mean_;
    scale_ = (x.colwise().squaredNorm() / double(x.rows())).cwiseSqrt().cwiseMax(1e-6);
    x = x.array().rowwise() / scale_.array();
    xx_ = x.transpose() * x / double(x.rows());
    xy_ = x.transpose() * y / double(x.rows());
  }

  // min |y - x B|^2 + strength |B|^2, in standardised scores. Shrinking towards the general map
  // instead of zero was tried: on a real head it predicts held-out frames no better.
  BlendshapeMap Fit(double strength) const {
    MatrixXd b(xy_.rows(), xy_.cols());
    for (long o = 0; o < b.cols(); ++o) {
      const auto followed = followed_.col(o).asDiagonal();
      MatrixXd left = followed * xx_ * followed;
      left.diagonal().array() += strength;
      b.col(o) = left.ldlt().solve(followed * xy_.col(o));
    }
    b = b.array().colwise() / scale_.transpose().array();
    const RowVectorXd offset = y_mean_ - x_mean_ * b;
    BlendshapeMap map;
    map.names = names_;
    map.offset.assign(offset.data(), offset.data() + offset.size());
    for (long c = 0; c < b.rows(); ++c) {
      // Constant outside the fold: the range must not be empty.
      map.min.push_back(float(std::min(least_[c], 1 - kMinRange)));
      map.max.push_back(float(std::max(most_[c], map.min.back() + kMinRange)));
      for (long o = 0; o < b.cols(); ++o) map.matrix.push_back(float(b(c, o)));
    }
    return map;
  }
  const RowVectorXd& mean_face() const { return y_mean_; }

 private:
  const std::vector<std::string>& names_;
  const MatrixXd& followed_;
  RowVectorXd least_, most_, x_mean_, y_mean_, scale_;
  MatrixXd xx_, xy_;
};

FlameParams Predicted(const BlendshapeMap& map, const Eigen::RowVectorXd& scores) {
  FlameParams face;
  ApplyBlendshapes(map, std::vector<float>(scores.data(), scores.data() + scores.size()), face);
  return face;
}

// The vertices' mean squared distance as a quadratic form of a difference of outputs: the mesh is
// nearly linear in them about the mean face.
class VertexMetric {
 public:
  VertexMetric(const FlamePoser<float>& poser, const RowVectorXd& mean_face) {
    constexpr double kStep = 0.05;
    const std::vector<float> at_mean = PosedFace(poser, FaceOf(mean_face));
    MatrixXd motion(long(at_mean.size()), mean_face.size());
    for (long o = 0; o < mean_face.size(); ++o) {
      RowVectorXd outputs = mean_face;
      outputs[o] += kStep;
      const std::vector<float> moved = PosedFace(poser, FaceOf(outputs));
      for (size_t i = 0; i < moved.size(); ++i)
        motion(long(i), o) = (double(moved[i]) - at_mean[i]) / kStep;
    }
    form_ = motion.transpose() * motion / double(at_mean.size() / 3);
  }
  double Squared(const RowVectorXd& difference) const {
    return (difference * form_).dot(difference);
  }

 private:
  MatrixXd form_;
};

// Sum over all frames, each predicted from the other folds.
double HeldOutError(const Table& table,
                    const std::vector<Fold>& folds,
                    const std::vector<Regression>& regressions,
                    const VertexMetric& metric,
                    double strength) {
  double sum = 0;
  for (size_t k = 0; k < folds.size(); ++k) {
    const BlendshapeMap map = regressions[k].Fit(strength);
    for (long i = folds[k].begin; i < folds[k].end; ++i) {
      const FlameParams face = Predicted(map, table.scores.row(i));
      sum += metric.Squared(table.outputs.row(i) - OutputsOf(face, map.expression_count()));
    }
  }
  return sum;
}

// Compares predicted faces with the tracked ones, vertex by vertex, without the head's own pose.
class FaceComparison {
 public:
  explicit FaceComparison(const FlamePoser<float>& poser) : poser_(poser) {}

  void Add(const FlameParams& tracked, const FlameParams& predicted, const FlameParams& mean) {
    const std::vector<float> t = PosedFace(poser_, tracked), p = PosedFace(poser_, predicted),
                             m = PosedFace(poser_, mean);
    const size_t count = t.size() / 3;
    error_.resize(count);
    mean_error_.resize(count);
    moves_.resize(count);
    for (size_t v = 0; v < count; ++v) {
      double error = 0, motion = 0;
      for (size_t k = 3 * v; k < 3 * v + 3; ++k) {
        error += std::pow(double(t[k]) - p[k], 2);
        motion += std::pow(double(t[k]) - m[k], 2);
      }
      squared_error_ += error;
      squared_motion_ += motion;
      error_[v] += std::sqrt(error);
      mean_error_[v] += std::sqrt(motion);
      moves_[v] = moves_[v] || motion >= double(kMoved) * kMoved;
    }
    ++frames_;
  }

  BlendshapeFitFigures Figures() const {
    BlendshapeFitFigures figures;
    double error = 0, mean_error = 0, count = 0;
    for (size_t v = 0; v < moves_.size(); ++v) {
      if (!moves_[v]) continue;
      error += error_[v];
      mean_error += mean_error_[v];
      count += frames_;
    }
    if (count > 0) {
      figures.error = float(error / count);
      figures.mean_face_error = float(mean_error / count);
    }
    figures.r2 = float(squared_motion_ > 0 ? 1 - squared_error_ / squared_motion_ : 0);
    return figures;
  }

 private:
  const FlamePoser<float>& poser_;
  std::vector<double> error_, mean_error_;  // [V] sums over frames, metres
  std::vector<char> moves_;
  double squared_error_ = 0, squared_motion_ = 0, frames_ = 0;
};

size_t StrideOf(size_t frames) { return (frames + kMaxMeasured - 1) / kMaxMeasured; }

// The tracked face as far as scores can determine it.
FlameParams FaceWithoutHead(const FlameParams& face, size_t expressions) {
  return FaceOf(OutputsOf(face, expressions));
}

BlendshapeFitFigures HeldOutFigures(const Table& table,
                                    const std::vector<Fold>& folds,
                                    const std::vector<Regression>& regressions,
                                    const FlamePoser<float>& poser,
                                    double strength) {
  FaceComparison comparison(poser);
  const long stride = long(StrideOf(size_t(table.outputs.rows())));
  for (size_t k = 0; k < folds.size(); ++k) {
    const BlendshapeMap map = regressions[k].Fit(strength);
    const FlameParams mean = FaceOf(regressions[k].mean_face());
    for (long i = folds[k].begin; i < folds[k].end; i += stride)
      comparison.Add(FaceOf(table.outputs.row(i)), Predicted(map, table.scores.row(i)), mean);
  }
  BlendshapeFitFigures figures = comparison.Figures();
  figures.frames = int(table.outputs.rows());
  return figures;
}

// Adds what scores that do not vary in the samples do on any head. The face that was fitted stays
// that of their mean.
void AddGeneral(const FlameModel& model, const BlendshapeSamples& samples, BlendshapeMap& map) {
  const BlendshapeMap general = GeneralBlendshapeMap(&model);
  for (size_t g = 0; g < general.names.size(); ++g) {
    const std::string& name = general.names[g];
    if (FindBlendshape(map, name) >= 0) continue;
    double mean = 0;
    for (size_t c = 0; c < samples.names.size(); ++c)
      for (size_t i = 0; samples.names[c] == name && i < samples.size(); ++i)
        mean += double(samples.scores[i][c]) / double(samples.size());
    const RowVectorXd row = RowOf(general, g);
    map.names.push_back(name);
    map.min.push_back(0);
    map.max.push_back(1);
    for (long o = 0; o < row.size(); ++o) {
      map.matrix.push_back(float(row[o]));
      map.offset[size_t(o)] -= float(mean * row[o]);
    }
  }
}

double BestStrength(const Table& table,
                    const std::vector<Fold>& folds,
                    const std::vector<Regression>& regressions,
                    const VertexMetric& metric) {
  std::array<double, kStrengths.size()> errors;
  for (size_t i = 0; i < errors.size(); ++i)
    errors[i] = HeldOutError(table, folds, regressions, metric, kStrengths[i]);
  return kStrengths[size_t(std::min_element(errors.begin(), errors.end()) - errors.begin())];
}

}  // namespace

BlendshapeFit FitBlendshapes(const FlamePoser<float>& poser, const BlendshapeSamples& samples) {
  if (samples.size() < kMinScoredFrames)
    throw Error("blendshape scores",
                std::to_string(samples.size()) + " frames have any, at least " +
                    std::to_string(kMinScoredFrames) + " are needed for a map");
  const Table table = TableOf(samples, poser.model());
  if (table.names.empty())
    throw Error("blendshape scores", "none of them varies in the video's frames");
  const MatrixXd followed = Followed(table.names, poser.model());
  const std::vector<Fold> folds = FoldsOf(samples.size());
  std::vector<Regression> regressions;
  for (const Fold& fold : folds) regressions.emplace_back(table, followed, fold);
  const Regression all(table, followed, {});
  const VertexMetric metric(poser, all.mean_face());
  BlendshapeFit fit;
  fit.strength = BestStrength(table, folds, regressions, metric);
  fit.map = all.Fit(fit.strength);
  fit.map.fit = HeldOutFigures(table, folds, regressions, poser, fit.strength);
  fit.varying = table.names.size();
  fit.mean = FaceOf(all.mean_face());
  AddGeneral(poser.model(), samples, fit.map);
  return fit;
}

BlendshapeFitFigures MeasureBlendshapes(const FlamePoser<float>& poser,
                                        const BlendshapeFit& fit,
                                        const BlendshapeSamples& samples) {
  FaceComparison comparison(poser);
  const size_t expressions = size_t(poser.model().expression_count);
  for (size_t i = 0; i < samples.size(); i += StrideOf(samples.size())) {
    BlendshapeScores scores;
    for (size_t c = 0; c < samples.names.size(); ++c)
      scores[samples.names[c]] = samples.scores[i][c];
    FlameParams predicted;
    ApplyBlendshapes(fit.map, scores, predicted);
    comparison.Add(FaceWithoutHead(samples.faces[i], expressions), predicted, fit.mean);
  }
  BlendshapeFitFigures figures = comparison.Figures();
  figures.frames = int(samples.size());
  return figures;
}

}  // namespace cosplat
