#include "splat/train/gradient_sum.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>

#include "splat/train/kernels/adam.h"
#include "splat/train/kernels/step.h"

namespace cosplat {
namespace {

constexpr size_t kHeaderWords = 4;  // loss, width, height

// After the attributes.
enum { kScreenRows = kAttributeCount, kRadiusRows };

std::vector<RowArray> RowsOfView(const ViewGradients& view) {
  std::vector<RowArray> rows = RowsOf(view.gradients);
  rows.push_back({view.screen.data(), 2});
  rows.push_back({const_cast<float*>(view.radii.data), 1});  // only read
  return rows;
}

}  // namespace

// A view's groups that this rank owns: where they are drawn, or in a message.
struct GradientSum::Rows {
  View<const uint32_t> groups;
  std::vector<RowArray> arrays;
  bool packed = false;  // row kGaussianGroup * k is the first of groups[k]; else of group k
  int width = 0, height = 0;
};

void GradientSum::Begin(const Gaussians& gaussians, size_t views) {
  const size_t groups = AdamGroupCount(gaussians.size());
  if (sum_.size() != gaussians.size()) sum_.RefillLike(gaussians, HostStream());
  moves_.Refill(gaussians.size());
  moves_.FillWithZeros(HostStream());
  seen_.Refill(groups);
  seen_.FillWithZeros(HostStream());
  share_ = 1 / float(views);
  losses_.clear();
}

void GradientSum::Add(const ViewGradients* mine,
                      const Gaussians& gaussians,
                      DensityStatistics* statistics) {
  groups_.resize(ranks_.size());
  to_.resize(ranks_.size());
  for (auto& groups : groups_) groups.clear();
  for (Message& message : to_) message.clear();
  std::vector<RowArray> rows;
  if (mine) {
    for (size_t g = 0; g < seen_.size(); ++g)
      if (AnyPositive(mine->radii, g)) groups_[shards_.OwnerOf(g)].push_back(uint32_t(g));
    rows = RowsOfView(*mine);
    const uint64_t loss = std::bit_cast<uint64_t>(mine->loss);
    const uint32_t header[kHeaderWords] = {
        uint32_t(loss), uint32_t(loss >> 32), uint32_t(mine->width), uint32_t(mine->height)};
    for (size_t r = 0; r < ranks_.size(); ++r) {
      groups_drawn_ += groups_[r].size();
      if (r != ranks_.rank())
        PackGroups({header, kHeaderWords}, rows, groups_[r], gaussians.size(), to_[r]);
    }
  }
  ranks_.Exchange({to_.begin(), to_.end()}, from_);
  Gaussians layout;  // of the rows in messages: their widths alone
  layout.degree = gaussians.degree;
  layout.corrections = gaussians.corrections;
  Buffer<float> none;
  const std::vector<RowArray> widths = RowsOfView({layout, none, {}});
  for (size_t r = 0; r < ranks_.size(); ++r) {
    if (r == ranks_.rank()) {
      if (!mine) continue;
      losses_.push_back(mine->loss);
      AddView({groups_[r], rows, false, mine->width, mine->height}, gaussians, statistics);
    } else if (!from_[r].empty()) {
      Message& message = from_[r];
      losses_.push_back(std::bit_cast<double>(message[0] + (uint64_t(message[1]) << 32)));
      const PackedGroups packed =
          FindPacked(widths, {message.data() + kHeaderWords, message.size() - kHeaderWords});
      AddView({packed.groups, packed.arrays, true, int(message[2]), int(message[3])},
              gaussians,
              statistics);
    }
  }
}

void GradientSum::AddView(const Rows& view,
                          const Gaussians& gaussians,
                          DensityStatistics* statistics) {
  const size_t count = gaussians.size();
  const size_t rows = view.packed ? view.groups.size() * kGaussianGroup : count;
  const uint32_t never = 0;
  AccumulateStep accumulate{{view.arrays[kRadiusRows].data, rows},
                            {view.arrays[kScreenRows].data, 2 * rows},
                            {view.arrays[kScaleLog].data, 3 * rows},
                            gaussians.values[kScaleLog].view(),
                            view.width,
                            view.height,
                            {},
                            {},
                            {},
                            &never};
  if (statistics) {
    accumulate.screen_gradient = statistics->screen_gradient.view();
    accumulate.plasticity = statistics->plasticity.view();
    accumulate.visible = statistics->visible.view();
  }
  tbb::parallel_for(tbb::blocked_range<size_t>(0, view.groups.size(), kGroupsPerBlock),
                    [&](const auto& range) {
                      for (size_t k = range.begin(); k < range.end(); ++k) {
                        const size_t g = view.groups[k], first = g * kGaussianGroup;
                        const size_t row = view.packed ? k * kGaussianGroup : first;
                        const size_t size = std::min(kGaussianGroup, count - first);
                        for (int a = 0; a < kAttributeCount; ++a) {
                          const size_t width = view.arrays[a].width;
                          const float* from = view.arrays[a].data + row * width;
                          float* sum = sum_.values[a].data() + first * width;
                          if (seen_[g])
                            for (size_t n = 0; n < size * width; ++n) sum[n] += share_ * from[n];
                          else
                            for (size_t n = 0; n < size * width; ++n) sum[n] = share_ * from[n];
                        }
                        seen_[g] = 1;
                        for (size_t i = 0; i < size; ++i) {
                          if (accumulate.radii[row + i] > 0) moves_[first + i] = 1;
                          if (statistics) accumulate.Add(first + i, row + i);
                        }
                      }
                    });
}

void GradientSum::MoveAll() {
  std::fill(moves_.begin(), moves_.end(), 1.0f);
  KeepOwn(moves_);
}

void GradientSum::ZeroUnseen() {
  for (size_t g = 0; g < seen_.size(); ++g) {
    if (seen_[g] || !shards_.Owns(g)) continue;
    const size_t first = g * kGaussianGroup, last = std::min(first + kGaussianGroup, sum_.size());
    for (int a = 0; a < kAttributeCount; ++a) {
      const size_t width = size_t(sum_.width(a));
      std::fill(sum_.values[a].data() + first * width, sum_.values[a].data() + last * width, 0.0f);
    }
  }
}

void GradientSum::KeepOwn(View<float> moves) const {
  for (size_t i = 0; i < moves.size(); ++i)
    if (!shards_.Owns(i / kGaussianGroup)) moves[i] = 0;
}

double GradientSum::MeanLoss() const {
  double sum = 0;
  for (const double loss : losses_) sum += loss;
  return sum / double(losses_.size());
}

void GradientSum::Release() {
  sum_ = {};
  moves_ = {};
  seen_ = {};
  to_.clear();
  from_.clear();
}

size_t GradientSum::held() const {
  size_t bytes = HeldBy(sum_) + HeldBy(moves_, seen_);
  for (const auto* messages : {&to_, &from_})
    for (const Message& message : *messages) bytes += HeldBy(message);
  return bytes;
}

}  // namespace cosplat
