#include "splat/train/ranks/view_exchange.h"

#include <algorithm>
#include <utility>

#include "splat/device/for_each.h"
#include "splat/train/loss/photograph.h"
#include "splat/train/ranks/kernels/shards.h"
#include "splat/train/ranks/shards.h"

namespace cosplat {
namespace {

// What is sent of a projected Gaussian: its splat and radius; and of its gradient.
RowArrays ArraysOf(const ProjectedSplat* splats, const float* radii) {
  RowArrays arrays;
  arrays.Add({const_cast<float*>(&splats->x), kProjectedStride});
  arrays.Add({const_cast<float*>(radii), 1});
  return arrays;
}
RowArrays ArraysOf(const SplatGradient* gradients) {
  RowArrays arrays;
  arrays.Add({const_cast<float*>(&gradients->x), sizeof(SplatGradient) / sizeof(float)});
  return arrays;
}

// Gaussians [first, first + count).
WorldGaussians PartOf(const WorldGaussians& of, size_t first, size_t count) {
  WorldGaussians part = of;
  part.count = count;
  part.position += 3 * first;
  part.rotation += 4 * first;
  part.scale_log += 3 * first;
  part.opacity_logit += first;
  part.color_dc += 3 * first;
  part.color_rest += size_t(of.rest_width) * first;
  if (of.color_frame) part.color_frame += 4 * first;
  if (of.degree) part.degree += first;
  if (of.smoothing) part.smoothing += first;
  return part;
}

}  // namespace

ViewExchange::ViewExchange(Ranks& ranks, StagedRasterizer& rasterizer)
    : ranks_(ranks),
      rasterizer_(rasterizer),
      stream_(rasterizer.stream()),
      share_(ShareOf(ranks)),
      messages_(ranks),
      groups_(ranks.size()),
      lists_(ranks.size()),
      splats_(ranks.size()),
      gradients_(ranks.size()),
      places_(ranks.size()) {}

std::vector<uint32_t> ViewExchange::DrawnGroups(View<const float> radii) {
  drawn_.Refill(GroupCount(radii.size()), stream_);
  ForEach(drawn_.size(), stream_, FindDrawn{radii, drawn_.view()});
  const std::vector<uint8_t> drawn = drawn_.Downloaded(stream_);
  std::vector<uint32_t> groups;
  for (size_t g = 0; g < drawn.size(); ++g)
    if (drawn[g] != 0) groups.push_back(uint32_t(g));
  groups_drawn_ += groups.size();
  return groups;
}

void ViewExchange::Project(const WorldGaussians& own,
                           Basis basis,
                           std::vector<RoundView> views,
                           RenderTape& tape) {
  own_ = own;
  views_ = std::move(views);
  const bool alone = ranks_.size() == 1;
  Buffer<ProjectedSplat>& splats = alone ? tape.splats : projected_;
  Buffer<float>& radii = alone ? tape.radius : radii_;
  splats.Refill(own.count, stream_);
  radii.Refill(own.count, stream_);
  for (size_t v = 0; v < views_.size(); ++v) {
    const RoundView& view = views_[v];
    rasterizer_.Project(own, basis, view.camera, view.degree, splats.data(), radii.data());
    groups_[v] = DrawnGroups(std::as_const(radii).view());
    if (alone) return;
    lists_[v].Upload(groups_[v], stream_);
    PackGroups({ArraysOf(splats.data(), radii.data()), own.count, std::as_const(lists_[v]).view()},
               groups_[v].size(),
               splats_[v],
               stream_);
  }
  for (size_t r = views_.size(); r < ranks_.size(); ++r) {
    groups_[r].clear();
    splats_[r].clear();
  }
  Receive(tape);
}

void ViewExchange::Receive(RenderTape& tape) {
  std::vector<Message> received;
  ranks_.Exchange({groups_.begin(), groups_.end()}, received);
  messages_.Exchange(splats_, stream_);
  if (!has_view()) return;
  std::vector<View<const uint32_t>> lists(received.begin(), received.end());
  lists[ranks_.rank()] = groups_[ranks_.rank()];
  // Sorted as they are among all.
  size_t count = 0;
  for (const View<const uint32_t>& list : lists) count += list.size();
  struct Group {
    uint32_t among_all, rank, k;
  };
  std::vector<Group> groups;
  groups.reserve(count);
  for (uint32_t r = 0; r < lists.size(); ++r) {
    const RowShare share{r, share_.ranks};
    for (uint32_t k = 0; k < lists[r].size(); ++k) {
      const size_t row = share.RowAt(size_t(lists[r][k]) * kGaussianGroup);
      groups.push_back({uint32_t(row / kGaussianGroup), r, k});
    }
  }
  std::sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
    return a.among_all < b.among_all;
  });
  std::vector<std::vector<uint32_t>> places(lists.size());
  for (uint32_t r = 0; r < lists.size(); ++r) places[r].resize(lists[r].size());
  for (uint32_t place = 0; place < groups.size(); ++place)
    places[groups[place].rank][groups[place].k] = place;
  tape.splats.Refill(count * kGaussianGroup, stream_);
  tape.radius.Refill(count * kGaussianGroup, stream_);
  for (uint32_t r = 0; r < lists.size(); ++r) {
    places_[r].Upload(places[r], stream_);
    UnpackGroups(r == ranks_.rank() ? splats_[r] : messages_.From(r),
                 places[r].size(),
                 {ArraysOf(tape.splats.data(), tape.radius.data()),
                  count * kGaussianGroup,
                  std::as_const(places_[r]).view()},
                 stream_);
  }
  stream_.Wait();
}

void ViewExchange::Return(const RenderTape& tape, const std::function<void(const Part&)>& take) {
  const bool alone = ranks_.size() == 1;
  if (!alone) {
    for (size_t r = 0; r < ranks_.size(); ++r)
      if (has_view())
        PackGroups({ArraysOf(tape.d_splats.data()),
                    tape.d_splats.size(),
                    std::as_const(places_[r]).view()},
                   places_[r].size(),
                   gradients_[r],
                   stream_);
      else
        gradients_[r].clear();
    messages_.Exchange(gradients_, stream_);
  }
  for (size_t first = 0; first < own_.count; first += kRowsPerPart) {
    const size_t count = std::min(kRowsPerPart, own_.count - first);
    for (size_t v = 0; v < views_.size(); ++v)
      if (alone)
        take({views_[v],
              first,
              PartOf(own_, first, count),
              tape.splats.data() + first,
              {tape.radius.data() + first, count},
              tape.d_splats.data() + first});
      else
        ReturnPart(v, first, count, take);
  }
}

void ViewExchange::ReturnPart(size_t view,
                              size_t first,
                              size_t count,
                              const std::function<void(const Part&)>& take) {
  const std::vector<uint32_t>& groups = groups_[view];
  const uint32_t first_group = uint32_t(first / kGaussianGroup);
  const auto at = [&](size_t group) {
    return std::lower_bound(groups.begin(), groups.end(), uint32_t(group));
  };
  const auto begin = at(first_group), end = at(first_group + GroupCount(count));
  if (begin == end) return;
  const size_t n = size_t(end - begin), skipped = size_t(begin - groups.begin());
  projected_.Refill(count, stream_);
  radii_.Refill(count, stream_);
  radii_.FillWithZeros(stream_);
  d_splats_.Refill(count, stream_);
  const View<const uint32_t> list(lists_[view].data() + skipped, n);
  const auto unpack = [&](const Message& message, const RowArrays& to) {
    const View<uint32_t> words(const_cast<uint32_t*>(message.data()), message.size());
    ForEachGroup(
        n,
        stream_,
        CopyGroup{{RowsFrom(PackedIn(to, words), skipped * kGaussianGroup), n * kGaussianGroup},
                  {to, count, list, first_group}});
  };
  unpack(splats_[view], ArraysOf(projected_.data(), radii_.data()));
  unpack(view == ranks_.rank() ? gradients_[view] : messages_.From(view),
         ArraysOf(d_splats_.data()));
  take({views_[view],
        first,
        PartOf(own_, first, count),
        projected_.data(),
        std::as_const(radii_).view(),
        d_splats_.data()});
}

void ViewExchange::Release() {
  messages_.Release(stream_);
  for (auto* messages : {&splats_, &gradients_})
    for (Message& message : *messages) message = {};
  for (auto* lists : {&lists_, &places_})
    for (Buffer<uint32_t>& list : *lists) list = {};
  projected_ = {};
  radii_ = {};
  d_splats_ = {};
  drawn_ = {};
}

size_t ViewExchange::allocated_bytes() const {
  size_t bytes =
      messages_.allocated_bytes() + AllocatedBytes(projected_, radii_, d_splats_, drawn_);
  for (const auto* messages : {&splats_, &gradients_})
    for (const Message& message : *messages) bytes += AllocatedBytes(message);
  for (const auto* lists : {&lists_, &places_})
    for (const Buffer<uint32_t>& list : *lists) bytes += AllocatedBytes(list);
  return bytes;
}

}  // namespace cosplat
