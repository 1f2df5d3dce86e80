#include "splat/train/gradient_sum.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "splat/device/for_each.h"
#include "splat/train/kernels/shards.h"
#include "splat/train/shards.h"

namespace cosplat {
namespace {

// After the attributes.
enum { kScreenRows = kAttributeCount, kRadiusRows };

RowArrays RowsOfView(const ViewGradients& view) {
  RowArrays rows = RowsOf(view.gradients);
  rows.Add({view.screen.data(), 2});
  rows.Add({const_cast<float*>(view.radii.data), 1});  // only read
  return rows;
}

// gaussians: of all ranks.
OwnSums SumsOf(const RowShare& share,
               Gaussians& sum,
               const Buffer<uint8_t>& seen,
               size_t gaussians) {
  OwnSums sums{share, {}, gaussians, seen.view()};
  const RowArrays rows = RowsOf(sum);
  std::copy_n(rows.array, rows.count, sums.sum);
  return sums;
}

}  // namespace

// A view's groups that this rank owns: where they are drawn, or in a message.
struct GradientSum::Rows {
  View<const uint32_t> groups;
  RowArrays arrays;
  bool packed = false;  // AddGroup::packed
  ViewLoss of;
};

GradientSum::GradientSum(Ranks& ranks, Stream& stream)
    : ranks_(ranks), stream_(stream), share_(ShareOf(ranks)), messages_(ranks) {}

void GradientSum::Begin(const Gaussians& gaussians, size_t views) {
  const size_t groups = AdamGroupCount(gaussians.size());
  sum_.RefillLike(gaussians, stream_, share_.CountOf(gaussians.size()));
  moves_.Refill(gaussians.size(), stream_);
  moves_.FillWithZeros(stream_);
  seen_.Refill(groups, stream_);
  seen_.FillWithZeros(stream_);
  drawn_.Refill(groups, stream_);
  never_.Refill(1, stream_);
  never_.FillWithZeros(stream_);
  groups_.resize(ranks_.size());
  lists_.resize(ranks_.size());
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
      std::memcpy(static_cast<void*>(&views[r].emplace()), messages[r].data(), sizeof(ViewLoss));
  return views;
}

std::vector<uint8_t> GradientSum::DrawnGroups(const ViewGradients& mine) {
  ForEach(drawn_.size(), stream_, FindDrawn{mine.radii, drawn_.view()});
  std::vector<uint8_t> drawn(drawn_.size());
  drawn_.Download(drawn.data(), stream_);
  stream_.Wait();
  return drawn;
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
  const RowArrays widths = RowsOfView({layout, none, {}, {}});
  const RowArrays rows = mine ? RowsOfView(*mine) : widths;
  const std::vector<uint8_t> drawn = mine ? DrawnGroups(*mine) : std::vector<uint8_t>();
  for (size_t begin = 0; begin < seen_.size(); begin += kGroupsPerExchange) {
    for (auto& groups : groups_) groups.clear();
    for (size_t g = begin; g < std::min(begin + kGroupsPerExchange, drawn.size()); ++g)
      if (drawn[g] != 0) groups_[share_.OwnerOf(g * kGaussianGroup)].push_back(uint32_t(g));
    for (size_t r = 0; r < ranks_.size(); ++r) {
      groups_drawn_ += groups_[r].size();
      lists_[r].Upload(groups_[r].data(), groups_[r].size(), stream_);
      if (r != ranks_.rank())
        PackGroups(rows, lists_[r], gaussians.size(), messages_.To(r), stream_);
    }
    messages_.Exchange(stream_);
    for (size_t r = 0; r < ranks_.size(); ++r) {
      if (!views[r]) continue;
      if (r == ranks_.rank()) {
        AddView({lists_[r], rows, false, *views[r]}, gaussians, statistics);
      } else {
        const PackedGroups packed = FindPacked(widths, messages_.From(r).view());
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
  AccumulateStep accumulate{{view.arrays.array[kRadiusRows].data, rows},
                            {view.arrays.array[kScreenRows].data, 2 * rows},
                            {view.arrays.array[kScaleLog].data, 3 * rows},
                            gaussians.values[kScaleLog].view(),
                            view.of.width,
                            view.of.height,
                            {},
                            {},
                            {},
                            never_.data()};
  if (statistics) {
    accumulate.screen_gradient = statistics->screen_gradient.view();
    accumulate.plasticity = statistics->plasticity.view();
    accumulate.visible = statistics->visible.view();
  }
  ForEachGroup(view.groups.size(),
               stream_,
               AddGroup{SumsOf(share_, sum_, seen_, count),
                        view.arrays,
                        view.packed,
                        view.groups,
                        of_view_,
                        moves_.view(),
                        statistics != nullptr,
                        accumulate});
  ForEach(view.groups.size(), stream_, MarkGroups{view.groups, seen_.view()});
}

void GradientSum::ZeroUnseen() {
  ForEachGroup(seen_.size(), stream_, ZeroUnseenGroup{SumsOf(share_, sum_, seen_, moves_.size())});
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
  drawn_ = {};
  lists_.clear();
  messages_.Release(stream_);
}

}  // namespace cosplat
