#include "splat/train/loss/photograph.h"

#include <Eigen/Dense>
#include <algorithm>

#include "splat/device/sum_tree.h"

namespace cosplat {
namespace {

// Weight of the identity in a fit, per pixel: holds what the colours of the pixels do not
// determine, and keeps 95 % of an exposure in directions where they vary by 0.04.
constexpr double kIdentityWeight = 1e-4;

size_t BlocksOf(View<const float> rendered) {
  return (rendered.count / 3 + PhotographBackward::kBlock - 1) / PhotographBackward::kBlock;
}

}  // namespace

ExposureState::ExposureState(size_t frames)
    : m(frames * math::kExposureNumbers, 0),
      v(frames * math::kExposureNumbers, 0),
      updates(frames * math::kExposureNumbers, 0) {
  for (size_t i = 0; i < frames; ++i)
    value.append(kIdentityExposure.begin(), kIdentityExposure.end());
}

ExposureState ExposureState::Of(const std::vector<uint32_t>& frames) const {
  constexpr size_t kNumbers = math::kExposureNumbers;
  ExposureState own(frames.size());
  for (size_t i = 0; i < own.value.size(); ++i) {
    const size_t from = frames[i / kNumbers] * kNumbers + i % kNumbers;
    own.value[i] = value[from];
    own.m[i] = m[from];
    own.v[i] = v[from];
    own.updates[i] = updates[from];
  }
  return own;
}

void ExposureState::SetToMeans(const std::vector<std::vector<uint32_t>>& frames,
                               const std::vector<ExposureState>& found) {
  constexpr size_t kNumbers = math::kExposureNumbers;
  std::vector<float> parts(value.size(), 0);
  const auto for_each = [&](const auto& action) {
    for (size_t p = 0; p < found.size(); ++p)
      for (size_t i = 0; i < found[p].value.size(); ++i)
        action(frames[p][i / kNumbers] * kNumbers + i % kNumbers, found[p], i);
  };
  for_each([&](size_t to, const ExposureState&, size_t) {
    parts[to] += 1;
    value[to] = m[to] = v[to] = 0;
  });
  for_each([&](size_t to, const ExposureState& of, size_t i) {
    value[to] += of.value[i] / parts[to];
    m[to] += of.m[i] / parts[to];
    v[to] += of.v[i] / parts[to];
    updates[to] = std::max(updates[to], of.updates[i]);
  });
}

const Buffer<float>& PhotographModel::Forward(View<const float> rendered,
                                              const float* exposure,
                                              const TargetView& target,
                                              const std::array<float, 3>& background,
                                              Stream& stream) {
  shown_.Refill(rendered.count, stream);
  ForEach(rendered.count / 3,
          stream,
          PhotographForward{rendered,
                            exposure,
                            target,
                            {background[0], background[1], background[2]},
                            shown_.view()});
  return shown_;
}

void PhotographModel::Backward(View<const float> rendered,
                               const float* exposure,
                               const TargetView& target,
                               Buffer<float>& d_shown,
                               Stream& stream) {
  const size_t blocks = BlocksOf(rendered);
  sums_.Refill(exposure ? blocks : 0, stream);
  ForEach(blocks,
          stream,
          PhotographBackward{rendered, exposure, target.ignored, d_shown.view(), sums_.view()});
  if (!exposure) return;
  gradient_.Refill(math::kExposureNumbers, stream);
  const View<const ExposureSum> sums = std::as_const(sums_).view();
  ForEach(1, stream, AddUpExposure{SumInTree(sums, tree_, stream), gradient_.view()});
}

void PhotographModel::Update(size_t frame,
                             float rate,
                             View<const float> gradient,
                             const uint32_t* overflowed,
                             ExposureState& exposures,
                             Stream& stream) {
  moved_.Refill(math::kExposureNumbers, stream);
  const ExposureArrays all{
      exposures.value.view(), exposures.m.view(), exposures.v.view(), exposures.updates.view()};
  ForEach(math::kExposureNumbers,
          stream,
          StepExposure{all, frame, rate, gradient, overflowed, moved_.view()});
  ForEach(all.value.count, stream, CenterExposures{std::as_const(moved_).view(), all.value});
}

Exposure FitExposure(View<const float> rendered,
                     View<const float> target,
                     View<const uint8_t> use) {
  const size_t plane = use.count;
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> products = Eigen::Matrix<double, 4, 3>::Zero();
  size_t count = 0;
  for (size_t i = 0; i < plane; ++i) {
    if (!use[i]) continue;
    const Eigen::Vector4d x(rendered[i], rendered[plane + i], rendered[2 * plane + i], 1);
    const Eigen::RowVector3d y(target[i], target[plane + i], target[2 * plane + i]);
    squares += x * x.transpose();
    products += x * y;
    ++count;
  }
  const double weight = kIdentityWeight * double(count + 1);
  squares.diagonal().array() += weight;
  for (int k = 0; k < 3; ++k) products(k, k) += weight;
  const Eigen::Matrix<double, 4, 3> fitted = squares.ldlt().solve(products);
  Exposure exposure;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) exposure[size_t(4 * r + c)] = float(fitted(c, r));
  return exposure;
}

void ApplyExposure(const Exposure& exposure, View<float> image) {
  const size_t plane = image.count / 3;
  ParallelFor(plane, [&](size_t i) {
    const math::Vec3<float> y =
        math::Exposed(exposure.data(), {image[i], image[plane + i], image[2 * plane + i]});
    image[i] = y.x;
    image[plane + i] = y.y;
    image[2 * plane + i] = y.z;
  });
}

}  // namespace cosplat
