#include "flame/fit/fit_landmarks.h"

#include <ceres/ceres.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <mutex>

#include "flame/eyelids.h"
#include "flame/fit/face_texture.h"
#include "flame/fit/frame_priors.h"
#include "flame/fit/landmark_cost.h"
#include "flame/fit/silhouette.h"
#include "flame/io/landmarks.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

using namespace internal;  // of flame/fit

// The noise of a landmark, as a fraction of the face's size: about a pixel for a face of 250.
constexpr double kLandmarkSigma = 0.004;
// Deviation of the shape's coefficients about the mean head. Far below FLAME's unit variance, since
// errors of the landmarks that are alike in all frames would go into the shape. Freer if mattes'
// rims measure it, too.
constexpr double kShapeSigma = 0.035, kRimShapeSigma = 0.1;
// A camera's focal length before anything is known: a lens of 45 mm on a full frame, and its
// standard deviation as an exponent. Only a head that turns says more.
constexpr double kFocalPerSide = 1.8, kFocalSigma = 0.06;
// Frames that find shape and focal length, spread evenly over the video.
constexpr size_t kSubjectFrames = 80;
// How often frames are fitted again, each drawn to the mean of its neighbours.
constexpr int kSmoothingSweeps = 5;
// How often shape and focal length are found again with the mesh's outline, which moves with them.
constexpr int kRimRounds = 3, kRimIterations = 15;
// Translation and the root's rotation, which a frame's numbers begin with, are the body's. Their
// means over this many frames to either side stand for where it is; it stays near them by these
// standard deviations (radians, metres), and the neck takes the head's turns.
constexpr size_t kBodyNumbers = 6, kBodyWindow = 25;
// Of frames that are not neighbours in the video, those within this time, and some in any case.
constexpr double kBodySeconds = 2;
constexpr size_t kMinBodyWindow = 6;
constexpr struct { double root = 0.05, neck = 0.5, translation = 0.02; } kBodySigma;

constexpr const char* kNoFace = "no face of this model fits the landmarks";

// The images are all of the frames.
FrameCrop Whole(int width, int height) {
  return {{0, 0, width, height}, width, height, width, height};
}

FitLens LensOf(const FrameCrop& crop) {
  return {crop.scale_x() * (crop.frame_width / 2.0 - crop.part.x),
          crop.scale_y() * (crop.frame_height / 2.0 - crop.part.y)};
}

double LogFocalOf(const LandmarkFitOptions& options, const FrameCrop& crop) {
  const double focal = options.focal > 0
                           ? options.focal
                           : kFocalPerSide * std::max(crop.frame_width, crop.frame_height);
  return std::log(crop.scale_x() * focal);
}

int ExpressionCount(const FlameModel& model, int at_most) {
  const int lids = model.has_eyelids ? 2 : 0;
  return lids + std::min(model.expression_count - lids, at_most);
}

// Around the landmarks there are hair, neck and chest.
FrameView ViewOf(const ObservedFace& face, const FitLens& lens) {
  constexpr double kMargin = 0.75;  // in units of the landmarks' extent
  const FaceBox box = BoxOf(face.points);
  const double margin = kMargin * std::max(box.width(), box.height());
  FrameView view;
  view.lens = lens;
  view.box = {box.left - margin, box.top - margin, box.right + margin, box.bottom + margin};
  view.face_size = face.size;
  return view;
}

class LandmarkFitter {
 public:
  LandmarkFitter(const FlameModel& model,
                 const LandmarkEmbedding& embedding,
                 const std::vector<std::optional<ObservedFace>>& faces,
                 int width,
                 int height,
                 const LandmarkFitOptions& options);

  // Rigid motion of a mean face: no iteration, so that it needs no start.
  void InitializePoses();
  void SettleBody();
  // Every frame on its own, with the subject as it is. near: drawn to its neighbours, too.
  void FitFrames(bool near);
  void FitSubject();
  void ReadImages(const std::function<Image8(size_t)>& image);
  // From here on the mesh's outline is drawn to the mattes' rims; false if there are none.
  bool UseRims();
  // Offsets the mesh by the subject's hair.
  void FitHair();
  // Refines the frames by what their images show, for as long as points gain that are held out.
  void FitToImages();
  LandmarkFit Result() const;

  std::function<void()> tick;  // after each frame

 private:
  void PlaceFrame(size_t f, const PointsOnFlame::Tape& rest);
  void FitFrame(size_t f, const std::vector<double>* near);
  struct Blocks {
    double *shape, *log_focal, *frame;
  };
  void AddFrame(ceres::Problem& problem, size_t f, const Blocks& blocks) const;
  std::vector<size_t> SubjectFrames() const;
  double Sigma(size_t f) const { return kLandmarkSigma * faces_[f]->size; }
  FittedFrame FrameResult(size_t f) const;

  FlameModel model_;  // with the subject's hair, once it is known
  const LandmarkEmbedding& embedding_;
  const std::vector<std::optional<ObservedFace>>& faces_;
  const int width_, height_;
  const FitLens lens_;
  const PointsOnFlame points_;
  FramePrior prior_;
  const bool focal_given_;
  const std::string source_;
  std::vector<double> shape_;
  double log_focal_;
  std::vector<std::vector<double>> frames_;      // empty where there is no face
  std::vector<std::optional<FrameView>> views_;  // once the images are read
  std::vector<FrameFields> fields_;
  bool rims_ = false;  // whether mattes have some
  std::optional<Silhouette> silhouette_;
  std::vector<float> static_offset_;
  std::optional<FaceTexture> texture_;
  std::vector<double> spread_;
};

LandmarkFitter::LandmarkFitter(const FlameModel& model,
                               const LandmarkEmbedding& embedding,
                               const std::vector<std::optional<ObservedFace>>& faces,
                               int width,
                               int height,
                               const LandmarkFitOptions& options)
    : model_(model),
      embedding_(embedding),
      faces_(faces),
      width_(width),
      height_(height),
      lens_(LensOf(options.crop.value_or(Whole(width, height)))),
      points_(model,
              embedding,
              std::min(model.shape_count, options.shape_count),
              ExpressionCount(model, options.expression_count)),
      prior_{std::vector(faces.size(), std::vector<double>(size_t(points_.frame_size()))),
             internal::RestSigma(points_.frame_size(), model.has_eyelids),
             internal::StepSigma(points_.frame_size(), model.has_eyelids)},
      focal_given_(options.focal > 0),
      source_(options.source),
      shape_(size_t(points_.shape_count())),
      log_focal_(LogFocalOf(options, options.crop.value_or(Whole(width, height)))),
      frames_(faces.size()),
      views_(faces.size()) {
  shape_.reserve(shape_.size() + 1);  // Ceres takes no null pointer, not even for no numbers
  for (size_t f = 0; f < faces.size(); ++f)
    if (faces[f]) frames_[f].assign(size_t(points_.frame_size()), 0);
}

// Scaled orthography (Tomasi and Kanade 1992, for a known shape): the nearest rotation to the
// linear map from the mean face to the landmarks.
void LandmarkFitter::PlaceFrame(size_t f, const PointsOnFlame::Tape& rest) {
  const Eigen::Index count = Eigen::Index(embedding_.size());
  Eigen::MatrixXd from(3, count), to(2, count);
  for (Eigen::Index p = 0; p < count; ++p) {
    const auto& seen = faces_[f]->points[size_t(embedding_[size_t(p)].landmark)];
    from.col(p) = Eigen::Map<const Eigen::Vector3d>(rest.points[size_t(p)].data());
    to.col(p) = Eigen::Vector2d(seen[0] - lens_.cx, lens_.cy - seen[1]);
  }
  const Eigen::Vector3d from_mean = from.rowwise().mean();
  const Eigen::Vector2d to_mean = to.rowwise().mean();
  from.colwise() -= from_mean;
  to.colwise() -= to_mean;
  const Eigen::Matrix<double, 2, 3> linear =
      from.transpose().colPivHouseholderQr().solve(to.transpose()).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix<double, 2, 3>, Eigen::FullPivHouseholderQRPreconditioner>
      svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix<double, 2, 3> rows = svd.matrixU() * svd.matrixV().leftCols<2>().transpose();
  Eigen::Matrix3d rotation;
  rotation << rows, rows.row(0).cross(rows.row(1));
  const double scale = std::max(svd.singularValues().mean(), 1e-6);  // px per metre
  const Eigen::AngleAxisd turn(rotation);
  const Eigen::Vector3d axis = turn.angle() * turn.axis();
  const Eigen::Vector3d root = Eigen::Map<const Eigen::Vector3d>(&rest.joints[0].x);
  const Eigen::Vector3d turned = rotation * (from_mean - root) + root;
  double* const frame = frames_[f].data();
  std::copy_n(axis.data(), 3, frame + kFitPose);
  frame[kFitTranslation] = to_mean[0] / scale - turned[0];
  frame[kFitTranslation + 1] = to_mean[1] / scale - turned[1];
  frame[kFitTranslation + 2] = -std::exp(log_focal_) / scale - turned[2];
}

void LandmarkFitter::InitializePoses() {
  PointsOnFlame::Tape rest;
  const std::vector<double> zero(size_t(points_.frame_size()));
  points_.Pose(shape_.data(), zero.data(), rest);
  for (size_t f = 0; f < faces_.size(); ++f)
    if (faces_[f]) PlaceFrame(f, rest);
}

void LandmarkFitter::AddFrame(ceres::Problem& problem, size_t f, const Blocks& blocks) const {
  const auto& [shape, log_focal, frame] = blocks;
  problem.AddResidualBlock(new LandmarkCost(points_, embedding_, *faces_[f], lens_, Sigma(f)),
                           nullptr,
                           shape,
                           log_focal,
                           frame);
  problem.AddResidualBlock(new PriorCost(prior_.rests[f], prior_.rest_sigma), nullptr, frame);
  if (texture_)
    if (auto cost = texture_->Cost(f))
      problem.AddResidualBlock(cost.release(), nullptr, shape, log_focal, frame);
  if (rims_ && fields_[f].rim)
    if (auto cost = silhouette_->Cost(shape, *log_focal, frame, *fields_[f].rim, *views_[f]))
      problem.AddResidualBlock(cost.release(), nullptr, shape, log_focal, frame);
}

void LandmarkFitter::FitFrame(size_t f, const std::vector<double>* near) {
  ceres::Problem problem;
  double* const frame = frames_[f].data();
  // Ceres takes pointers to what it may change; blocks set constant are not changed.
  AddFrame(problem, f, {shape_.data(), &log_focal_, frame});
  if (near) problem.AddResidualBlock(new PriorCost(*near, prior_.step_sigma), nullptr, frame);
  problem.SetParameterBlockConstant(shape_.data());
  problem.SetParameterBlockConstant(&log_focal_);
  SolveFrame(problem, near ? 10 : 50);
  if (tick) tick();
}

void LandmarkFitter::FitFrames(bool near) {
  // All means are taken before any frame changes, so that the order does not matter.
  std::vector<std::vector<double>> means(faces_.size());
  for (size_t f = 0; near && f < faces_.size(); ++f)
    if (faces_[f])
      means[f] =
          BetweenNeighbours(frames_, f, [&](size_t g) { return faces_[g] && faces_[g]->follows; });
  tbb::parallel_for(size_t(0), faces_.size(), [&](size_t f) {
    if (faces_[f]) FitFrame(f, means[f].empty() ? nullptr : &means[f]);
  });
}

// The body below the neck moves slowly: from here on, the root stays near its mean over the
// neighbouring second or two, and what the head turns beyond it is the neck's.
void LandmarkFitter::SettleBody() {
  for (size_t f = 0; f < frames_.size(); ++f) {
    if (frames_[f].empty()) continue;
    const auto near = [&](size_t g) {
      return std::max(f, g) - std::min(f, g) <= kMinBodyWindow || !faces_[g] ||
             std::abs(faces_[g]->seconds - faces_[f]->seconds) <= kBodySeconds;
    };
    size_t begin = f - std::min(f, kBodyWindow);
    size_t end = std::min(f + kBodyWindow + 1, frames_.size());
    while (!near(begin)) ++begin;
    while (!near(end - 1)) --end;
    double count = 0;
    std::fill_n(prior_.rests[f].begin(), kBodyNumbers, 0.0);
    for (size_t g = begin; g < end; ++g) {
      if (frames_[g].empty()) continue;
      for (size_t k = 0; k < kBodyNumbers; ++k) prior_.rests[f][k] += frames_[g][k];
      ++count;
    }
    for (size_t k = 0; k < kBodyNumbers; ++k) prior_.rests[f][k] /= count;
  }
  for (size_t i = 0; i < 3; ++i) {
    prior_.rest_sigma[kFitTranslation + i] = kBodySigma.translation;
    prior_.rest_sigma[kFitPose + i] = kBodySigma.root;
    prior_.rest_sigma[kFitPose + 3 + i] = kBodySigma.neck;
  }
}

std::vector<size_t> LandmarkFitter::SubjectFrames() const {
  std::vector<size_t> seen, picked;
  for (size_t f = 0; f < faces_.size(); ++f)
    if (faces_[f]) seen.push_back(f);
  const size_t count = std::min(kSubjectFrames, seen.size());
  for (size_t i = 0; i < count; ++i)
    picked.push_back(seen[count == 1 ? 0 : i * (seen.size() - 1) / (count - 1)]);
  return picked;
}

void LandmarkFitter::FitSubject() {
  const std::vector<size_t> picked = SubjectFrames();
  // Ceres eliminates blocks in the order of their addresses, on which the sums' last bits depend:
  // so all of them are in one array.
  const size_t size = size_t(points_.frame_size());
  std::vector<double> numbers(picked.size() * size + 1 + shape_.size() + 1);
  double* const log_focal = &numbers[picked.size() * size];
  double* const shape = log_focal + 1;
  *log_focal = log_focal_;
  std::copy(shape_.begin(), shape_.end(), shape);
  ceres::Problem problem;
  auto* order = new ceres::ParameterBlockOrdering;
  for (size_t i = 0; i < picked.size(); ++i) {
    double* const frame = &numbers[i * size];
    std::copy_n(frames_[picked[i]].begin(), size, frame);
    AddFrame(problem, picked[i], {shape, log_focal, frame});
    order->AddElementToGroup(frame, 0);
  }
  if (!shape_.empty()) {
    const std::vector<double> sigma(shape_.size(), rims_ ? kRimShapeSigma : kShapeSigma);
    problem.AddResidualBlock(
        new PriorCost(std::vector<double>(shape_.size()), sigma), nullptr, shape);
    order->AddElementToGroup(shape, 1);
  }
  problem.AddResidualBlock(new PriorCost({log_focal_}, {kFocalSigma}), nullptr, log_focal);
  order->AddElementToGroup(log_focal, 1);
  if (focal_given_) problem.SetParameterBlockConstant(log_focal);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering.reset(order);
  options.num_threads = 1;  // sums would depend on the number of threads
  options.max_num_iterations = rims_ ? kRimIterations : 60;
  options.function_tolerance = 1e-5;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (size_t i = 0; i < picked.size(); ++i)
    std::copy_n(&numbers[i * size], size, frames_[picked[i]].begin());
  std::copy_n(shape, shape_.size(), shape_.begin());
  log_focal_ = *log_focal;
}

void LandmarkFitter::ReadImages(const std::function<Image8(size_t)>& image) {
  for (size_t f = 0; f < faces_.size(); ++f)
    if (faces_[f]) views_[f] = ViewOf(*faces_[f], lens_);
  fields_ = internal::ReadFields(views_, image);
}

bool LandmarkFitter::UseRims() {
  silhouette_.emplace(model_, points_.shape_count(), points_.frame_size() - kFitExpression);
  rims_ = std::any_of(
      fields_.begin(), fields_.end(), [](const FrameFields& frame) { return bool(frame.rim); });
  return rims_;
}

void LandmarkFitter::FitHair() {
  static_offset_ = internal::FitHairOffset(
      model_, shape_, log_focal_, frames_, SubjectFrames(), views_, fields_);
  for (size_t i = 0; i < static_offset_.size(); ++i)
    model_.template_vertices[i] += static_offset_[i];
  silhouette_.emplace(model_, points_.shape_count(), points_.frame_size() - kFitExpression);
}

void LandmarkFitter::FitToImages() {
  texture_.emplace(
      model_, points_.shape_count(), points_.frame_size() - kFitExpression, views_, fields_);
  spread_ = texture_->Refine(shape_, log_focal_, frames_, [&] { FitFrames(true); });
}

FittedFrame LandmarkFitter::FrameResult(size_t f) const {
  const std::vector<double>& frame = frames_[f];
  for (double x : frame)
    if (!std::isfinite(x)) throw Error(source_, kNoFace);
  FittedFrame out;
  SetFromRow(frame, out.params);
  EyelidsFromExpression(model_, out.params);
  return out;
}

LandmarkFit LandmarkFitter::Result() const {
  LandmarkFit fit;
  fit.brightness_spread = spread_;
  const float focal = float(std::exp(log_focal_));
  fit.camera.width = width_;
  fit.camera.height = height_;
  fit.camera.fx = fit.camera.fy = focal;
  fit.camera.cx = float(lens_.cx);
  fit.camera.cy = float(lens_.cy);
  fit.camera.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  fit.shape.assign(shape_.begin(), shape_.end());
  fit.static_offset = static_offset_;
  for (size_t f = 0; f < faces_.size(); ++f) {
    fit.frames.emplace_back();
    if (faces_[f]) fit.frames[f] = FrameResult(f);
  }
  return fit;
}

}  // namespace

LandmarkFit FitLandmarks(const FlameModel& model,
                         const LandmarkEmbedding& embedding,
                         const std::vector<std::optional<ObservedFace>>& faces,
                         int width,
                         int height,
                         const LandmarkFitOptions& options,
                         const std::function<void(int done, int total)>& progress) {
  const int seen =
      int(std::count_if(faces.begin(), faces.end(), [](const auto& f) { return bool(f); }));
  if (seen < kMinFaces)
    throw Error(options.source, Format("faces found: {}, expected at least {}", seen, kMinFaces));
  LandmarkFitter fitter(model, embedding, faces, width, height, options);
  const int sweeps = 2 + kSmoothingSweeps + (options.silhouette ? kRimRounds : 0) +
                     (options.image ? kMaxPhotometricRounds : 0);
  const int total = sweeps * seen;
  std::mutex mutex;
  int done = 0;
  fitter.tick = [&] {
    const std::lock_guard lock(mutex);
    ++done;
    if (progress) progress(done, total);
  };
  fitter.InitializePoses();
  fitter.FitFrames(false);
  fitter.FitSubject();
  fitter.FitFrames(false);
  if (options.image) fitter.ReadImages(options.image);
  const bool mattes = options.image && options.silhouette && fitter.UseRims();
  for (int round = 0; mattes && round < kRimRounds; ++round) {
    fitter.FitSubject();
    fitter.FitFrames(false);
  }
  fitter.SettleBody();
  for (int sweep = 0; sweep < kSmoothingSweeps; ++sweep) fitter.FitFrames(true);
  if (mattes) fitter.FitHair();
  if (options.image) fitter.FitToImages();
  if (progress && done < total) progress(total, total);
  LandmarkFit fit = fitter.Result();
  MeasureFit(model, embedding, faces, fit);
  if (!std::isfinite(fit.error)) throw Error(options.source, kNoFace);
  return fit;
}

}  // namespace cosplat
