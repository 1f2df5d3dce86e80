#include "splat/train/gradient_sum.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>

#include "splat/train/kernels/adam.h"
#include "splat/train/kernels/step.h"

namespace cosplat {
namespace {

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
  ViewLoss of;
};

void GradientSum::Begin(const Gaussians& gaussians, size_t views) {
  const size_t groups = AdamGroupCount(gaussians.size());
  const size_t own = share_.CountOf(gaussians.size());
  if (sum_.size() != own) sum_ = gaussians.ZerosLike(own);
  moves_.Refill(gaussians.size());
  moves_.FillWithZeros(HostStream());
  seen_.Refill(groups);
  seen_.FillWithZeros(HostStream());
  of_view_ = 1 / float(views);
  losses_.clear();
}

// Of the round's views, by rank; none of a rank without a view.
std::vector<std::optional<ViewLoss>> GradientSum::ExchangeLosses(const ViewGradients* mine) {
  static_assert(sizeof(ViewLoss) % sizeof(uint32_t) == 0);
  Message message(mine ? sizeof(ViewLoss) / sizeof(uint32_t) : 0);
  if (mine) std::memcpy(message.data(), &mine->of, sizeof mine->of);
  std::vector<Message> messages = ExchangeWithAll(message, ranks_);
  messages[ranks_.rank()] = std::move(message);
  std::vector<std::optional<ViewLoss>> views(messages.size());
  for (size_t r = 0; r < views.size(); ++r)
    if (!messages[r].empty())
      std::memcpy(&views[r].emplace(), messages[r].data(), sizeof(ViewLoss));
  return views;
}

void GradientSum::Add(const ViewGradients* mine,
                      const Gaussians& gaussians,
                      DensityStatistics* statistics) {
  const std::vector<std::optional<ViewLoss>> views = ExchangeLosses(mine);
  for (const std::optional<ViewLoss>& view : views)
    if (view) losses_.push_back(view->loss);
  Gaussians layout;  // of the rows in messages: their widths alone
  layout.degree = gaussians.degree;
  layout.corrections = gaussians.corrections;
  Buffer<float> none;
  const std::vector<RowArray> widths = RowsOfView({layout, none, {}, {}});
  const std::vector<RowArray> rows = mine ? RowsOfView(*mine) : widths;
  groups_.resize(ranks_.size());
  to_.resize(ranks_.size());
  for (size_t begin = 0; begin < seen_.size(); begin += kGroupsPerExchange) {
    for (auto& groups : groups_) groups.clear();
    if (mine)
      for (size_t g = begin; g < std::min(begin + kGroupsPerExchange, seen_.size()); ++g)
        if (AnyPositive(mine->radii, g))
          groups_[share_.OwnerOf(g * kGaussianGroup)].push_back(uint32_t(g));
    for (size_t r = 0; r < ranks_.size(); ++r) {
      groups_drawn_ += groups_[r].size();
      if (r != ranks_.rank()) PackGroups({}, rows, groups_[r], gaussians.size(), to_[r]);
    }
    ranks_.Exchange({to_.begin(), to_.end()}, from_);
    for (size_t r = 0; r < ranks_.size(); ++r) {
      if (!views[r]) continue;
      if (r == ranks_.rank()) {
        AddView({groups_[r], rows, false, *views[r]}, gaussians, statistics);
      } else {
        const PackedGroups packed = FindPacked(widths, from_[r].view());
        AddView({packed.groups, packed.arrays, true, *views[r]}, gaussians, statistics);
      }
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
                            view.of.width,
                            view.of.height,
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
                        const size_t place = share_.PlaceOf(first);
                        const size_t row = view.packed ? k * kGaussianGroup : first;
                        const size_t size = std::min(kGaussianGroup, count - first);
                        for (int a = 0; a < kAttributeCount; ++a) {
                          const size_t width = view.arrays[a].width;
                          const float* from = view.arrays[a].data + row * width;
                          float* sum = sum_.values[a].data() + place * width;
                          if (seen_[g])
                            for (size_t n = 0; n < size * width; ++n) sum[n] += of_view_ * from[n];
                          else
                            for (size_t n = 0; n < size * width; ++n) sum[n] = of_view_ * from[n];
                        }
                        seen_[g] = 1;
                        for (size_t i = 0; i < size; ++i) {
                          if (accumulate.radii[row + i] > 0) moves_[first + i] = 1;
                          if (statistics) accumulate.Add(first + i, row + i);
                        }
                      }
                    });
}

void GradientSum::ZeroUnseen() {
  for (size_t g = 0; g < seen_.size(); ++g) {
    if (seen_[g] || !share_.Owns(g * kGaussianGroup)) continue;
    const size_t first = share_.PlaceOf(g * kGaussianGroup);
    const size_t last = std::min(first + kGaussianGroup, sum_.size());
    for (int a = 0; a < kAttributeCount; ++a) {
      const size_t width = size_t(sum_.width(a));
      std::fill(sum_.values[a].data() + first * width, sum_.values[a].data() + last * width, 0.0f);
    }
  }
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

size_t GradientSum::HeldByMessages() const {
  size_t bytes = 0;
  for (const auto* messages : {&to_, &from_})
    for (const Message& message : *messages) bytes += HeldBy(message);
  return bytes;
}

}  // namespace cosplat
