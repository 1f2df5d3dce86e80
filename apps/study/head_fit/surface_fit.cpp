#include "apps/study/head_fit/surface_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "flame/fit/landmark_embedding.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

using Points = Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr double kRegion = 0.0965;  // metres
constexpr double kReach = 0.14;     // metres from the landmarks' middle: the face, and more
constexpr int kNoseBottom = 2, kNoseBridge = 168;
constexpr int kRounds = 8;
constexpr double kMinCosine = 0.2;       // between normals of points that belong together
constexpr double kLandmarkWeight = 0.5;  // of a landmark's coordinate, beside a distance
constexpr double kRidge = 1e-3;      // metres of distance that weigh as much as a coefficient of 1
constexpr Eigen::Index kMotion = 7;  // turn, shift, size

Points ToPoints(const std::vector<float>& values) {
  return Eigen::Map<const Eigen::Matrix3Xf>(values.data(), 3, Eigen::Index(values.size() / 3))
      .cast<double>();
}

Points NormalsOf(const Points& p, const std::vector<std::array<int32_t, 3>>& faces) {
  Points normals = Points::Zero(3, p.cols());
  for (const auto& f : faces) {
    const Vector3d a = p.col(f[0]), b = p.col(f[1]), c = p.col(f[2]);
    for (const int32_t v : f) normals.col(v) += (b - a).cross(c - a);
  }
  return normals.colwise().normalized();
}

bool IsEyeball(const FlameModel& model, size_t v) {
  const float* w = &model.skinning_weights[kFlameJoints * v];
  return w[3] + w[4] > 0.5f;
}

// Points spread over a surface, as barycentric combinations of its vertices.
struct Sample {
  std::array<int32_t, 3> vertices;
  std::array<double, 3> weights;
};
// Those within kReach of `middle`.
std::vector<Sample> SamplesOf(const FlameModel& model, const Points& mean, const Vector3d& middle) {
  constexpr double k = 1 / 6.0;
  std::vector<Sample> samples;
  for (const auto& f : model.faces) {
    if (IsEyeball(model, size_t(f[0])) || (mean.col(f[0]) - middle).norm() > kReach) continue;
    for (const std::array<double, 3>& w : {std::array{2 * k, 2 * k, 2 * k},
                                           std::array{4 * k, k, k},
                                           std::array{k, 4 * k, k},
                                           std::array{k, k, 4 * k}})
      samples.push_back({f, w});
  }
  return samples;
}
Points At(const Points& p, const std::vector<Sample>& samples) {
  Points out(3, Eigen::Index(samples.size()));
  for (size_t i = 0; i < samples.size(); ++i) {
    const auto& [v, w] = samples[i];
    out.col(Eigen::Index(i)) = w[0] * p.col(v[0]) + w[1] * p.col(v[1]) + w[2] * p.col(v[2]);
  }
  return out;
}

Sample SampleOf(const EmbeddedLandmark& point) {
  Sample sample;
  for (size_t k = 0; k < 3; ++k)
    sample.vertices[k] = point.vertices[k], sample.weights[k] = point.barycentric[k];
  return sample;
}

// The nearest of `surface` whose normal is alike, for each of `points`.
std::vector<Eigen::Index> Nearest(const Points& points,
                                  const Points& normals,
                                  const Points& surface,
                                  const Points& surface_normals) {
  const Eigen::Matrix3Xf p = surface.cast<float>(), n = surface_normals.cast<float>();
  std::vector<Eigen::Index> nearest(static_cast<size_t>(points.cols()));
  Eigen::ArrayXf distance;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f at = points.col(i).cast<float>(), up = normals.col(i).cast<float>();
    distance = (p.colwise() - at).colwise().squaredNorm().transpose().array() +
               ((up.transpose() * n).transpose().array() < float(kMinCosine)).cast<float>();
    distance.minCoeff(&nearest[size_t(i)]);
  }
  return nearest;
}

// p -> scale * rotation * p + shift, which takes `from` nearest to `to` (Umeyama 1991).
Points Moved(const Points& points, const Points& from, const Points& to) {
  return (Eigen::umeyama(from, to, true) * points.colwise().homogeneous()).topRows<3>();
}

class Fitter {
 public:
  Fitter(const FlameModel& ours, const FlameModel& people, bool with_shape)
      : ours_(ours),
        people_(people),
        count_(with_shape ? ours.shape_count : 0),
        mean_(ToPoints(ours.template_vertices)) {
    const Eigen::Index size = 3 * ours.vertex_count;
    directions_ = Eigen::Map<const Eigen::MatrixXf>(ours.shape_directions.data(), size, count_)
                      .cast<double>();
    for (const EmbeddedLandmark& a : FlameLandmarks(people, LandmarkSet::kMediapipe478))
      for (const EmbeddedLandmark& b : FlameLandmarks(ours, LandmarkSet::kMediapipe478))
        if (a.landmark == b.landmark)
          their_marks_.push_back(SampleOf(a)), our_marks_.push_back(SampleOf(b));
    samples_ = SamplesOf(ours, mean_, At(mean_, our_marks_).rowwise().mean());
  }

  FaceFit Fit(const std::vector<float>& face) {
    Points theirs = ToPoints(face);
    const std::vector<Eigen::Index> region = RegionOf(theirs);
    const double size = SizeOf(theirs);
    Eigen::VectorXd c = Eigen::VectorXd::Zero(count_);
    theirs = Moved(theirs, At(theirs, their_marks_), At(Shaped(c), our_marks_));
    for (int round = 0; round < kRounds; ++round) Step(region, c, theirs);
    FaceFit fit;
    const double scale = SizeOf(theirs) / size;
    const Eigen::VectorXd residuals = Correspond(region, Shaped(c), theirs).residuals;
    for (const double r : residuals) fit.distances.push_back(std::abs(r) / scale);
    fit.coefficients.assign(c.begin(), c.end());
    return fit;
  }

 private:
  struct Pairs {
    std::vector<Eigen::Index> sample;  // of ours, for each point
    Points points, normals;            // theirs; ours there
    Eigen::VectorXd residuals;         // along our normals
  };

  Points Shaped(const Eigen::VectorXd& c) const {
    if (count_ == 0) return mean_;
    return mean_ + (directions_ * c).reshaped(3, mean_.cols());
  }
  double SizeOf(const Points& p) const {
    const Points marks = At(p, their_marks_);
    return (marks.colwise() - marks.rowwise().mean()).norm();
  }
  std::vector<Eigen::Index> RegionOf(const Points& theirs) const {
    Vector3d bottom, bridge;
    int found = 0;
    for (const EmbeddedLandmark& mark : FlameLandmarks(people_, LandmarkSet::kMediapipe478)) {
      found += mark.landmark == kNoseBottom || mark.landmark == kNoseBridge;
      if (mark.landmark == kNoseBottom) bottom = At(theirs, {SampleOf(mark)}).col(0);
      if (mark.landmark == kNoseBridge) bridge = At(theirs, {SampleOf(mark)}).col(0);
    }
    if (found < 2)
      throw Error(people_.name, "landmarks", "of the nose's bottom and bridge are missing");
    const Vector3d center = bottom + 0.3 * (bridge - bottom);
    const Points normals = NormalsOf(theirs, people_.faces);
    const Vector3d middle = theirs.rowwise().mean();
    std::vector<Eigen::Index> region;
    for (Eigen::Index v = 0; v < theirs.cols(); ++v) {
      const bool outside = normals.col(v).dot(theirs.col(v) - middle) > 0;  // not of lips or lids
      if (outside && !IsEyeball(people_, size_t(v)) && (theirs.col(v) - center).norm() < kRegion)
        region.push_back(v);
    }
    return region;
  }
  Pairs Correspond(const std::vector<Eigen::Index>& region,
                   const Points& shaped,
                   const Points& theirs) const {
    const Points surface = At(shaped, samples_);
    const Points normals = At(NormalsOf(shaped, ours_.faces), samples_).colwise().normalized();
    Pairs pairs;
    pairs.points = theirs(Eigen::all, region);
    pairs.sample = Nearest(
        pairs.points, NormalsOf(theirs, people_.faces)(Eigen::all, region), surface, normals);
    pairs.normals = normals(Eigen::all, pairs.sample);
    pairs.residuals = (pairs.points - surface(Eigen::all, pairs.sample))
                          .cwiseProduct(pairs.normals)
                          .colwise()
                          .sum()
                          .transpose();
    return pairs;
  }
  // d(sample . n)/d(coefficients)
  Eigen::RowVectorXd ShapeRow(const Sample& sample, const Vector3d& n) const {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(count_);
    for (size_t k = 0; k < 3; ++k)
      row +=
          sample.weights[k] * (n.transpose() * directions_.middleRows(3 * sample.vertices[k], 3));
    return row;
  }

  // Gauss-Newton: our coefficients, and the face's turn, shift and size about its middle.
  void Step(const std::vector<Eigen::Index>& region, Eigen::VectorXd& c, Points& theirs) const {
    const Points shaped = Shaped(c);
    const Pairs pairs = Correspond(region, shaped, theirs);
    const Vector3d middle = pairs.points.rowwise().mean();
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(count_ + kMotion, count_ + kMotion);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(count_ + kMotion);
    a.diagonal().head(count_).setConstant(kRidge * kRidge);
    b.head(count_) = -kRidge * kRidge * c;
    const auto add =
        [&](const Sample& sample, const Vector3d& at, const Vector3d& n, double r, double weight) {
          Eigen::VectorXd row(count_ + kMotion);
          const Vector3d q = at - middle;
          row << ShapeRow(sample, n).transpose(), -q.cross(n), -n, -q.dot(n);
          a.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
          b += weight * r * row;
        };
    for (size_t i = 0; i < region.size(); ++i) {
      const Eigen::Index k = Eigen::Index(i);
      add(samples_[size_t(pairs.sample[i])],
          pairs.points.col(k),
          pairs.normals.col(k),
          pairs.residuals[k],
          1);
    }
    const Points our_marks = At(shaped, our_marks_), their_marks = At(theirs, their_marks_);
    for (Eigen::Index i = 0; i < our_marks.cols(); ++i)
      for (int axis = 0; axis < 3; ++axis)
        add(our_marks_[size_t(i)],
            their_marks.col(i),
            Vector3d::Unit(axis),
            their_marks(axis, i) - our_marks(axis, i),
            kLandmarkWeight * kLandmarkWeight);
    const Eigen::VectorXd x = a.selfadjointView<Eigen::Lower>().ldlt().solve(b);
    c += x.head(count_);
    const Vector3d turn = x.segment<3>(count_), shift = x.segment<3>(count_ + 3);
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(turn.norm(), turn.norm() > 0 ? turn.normalized() : Vector3d::UnitX())
            .toRotationMatrix();
    theirs = ((1 + x[count_ + 6]) * (rotation * (theirs.colwise() - middle))).colwise() +
             (middle + shift);
  }

  const FlameModel &ours_, &people_;
  const Eigen::Index count_;
  const Points mean_;
  Eigen::MatrixXd directions_;  // [3 V, count]
  std::vector<Sample> samples_, our_marks_, their_marks_;
};

}  // namespace

FaceFit FitToFace(const FlameModel& ours,
                  const FlameModel& people,
                  const std::vector<float>& face,
                  bool with_shape) {
  return Fitter(ours, people, with_shape).Fit(face);
}

}  // namespace cosplat
