#include "avatar/train/bust_track.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "avatar/model/place_bust.h"
#include "splat/device/for_each.h"

namespace cosplat {

std::vector<size_t> InstantsOf(const std::vector<int>& timesteps) {
  std::vector<int> distinct = timesteps;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  std::vector<size_t> instants;
  for (const int t : timesteps)
    instants.push_back(
        size_t(std::lower_bound(distinct.begin(), distinct.end(), t) - distinct.begin()));
  return instants;
}

BustTrack::BustTrack(const AvatarPoser& poser,
                     const std::vector<BustPose>& poses,
                     std::vector<size_t> instants,
                     const BustRates& rates,
                     int iterations)
    : instants_(std::move(instants)),
      first_frames_(poses.size(), instants_.size()),
      mean_on_host_(poser.bust()),
      pivot_(poser.bust_pivot()),
      rates_(rates),
      decay_(std::pow(rates.last, float(poses.size()) / float(std::max(1, iterations)))) {
  for (size_t i = 0; i < instants_.size(); ++i)
    first_frames_[instants_[i]] = std::min(first_frames_[instants_[i]], i);
  std::vector<BustState> states;
  for (const BustPose& pose : poses) states.push_back({pose, {}});
  SetStates(states);
}

std::vector<BustState> BustTrack::States() const { return states_.Downloaded(*stream_); }

void BustTrack::SetStates(const std::vector<BustState>& states) {
  states_.Upload(states, *stream_);
  mean_.Upload(mean_on_host_, *stream_);
  stream_->Wait();
}

std::vector<BustPose> BustTrack::Poses() const {
  std::vector<BustPose> poses;
  for (const BustState& state : States()) poses.push_back(state.pose);
  return poses;
}

BustPose BustTrack::PoseOf(size_t frame) const { return Poses()[instants_[frame]]; }

void BustTrack::WorkIn(Stream& stream) {
  const std::vector<BustState> states = States();
  stream_ = &stream;
  SetStates(states);
}

void BustTrack::PoseBust(size_t frame, View<float> vertices) {
  const size_t numbers = mean_.size();
  ForEach(numbers / 3,
          *stream_,
          PlaceBust{std::as_const(mean_).view(),
                    pivot_,
                    &states_.data()[instants_[frame]].pose,
                    vertices.data + (vertices.count - numbers)});
}

void BustTrack::Advance(size_t frame,
                        const Embedding& embedding,
                        size_t first_face,
                        const PosedGaussians& posed,
                        const PosedGaussians& d_posed,
                        const uint32_t* overflowed) {
  const size_t n = embedding.triangle.size();
  const size_t blocks = (n + SumBust::kBlock - 1) / SumBust::kBlock;
  const size_t instant = instants_[frame];
  sums_.Refill(kBustOutputs * blocks, *stream_);
  ForEach(blocks,
          *stream_,
          SumBust{embedding.triangle.view(),
                  int32_t(first_face),
                  pivot_,
                  &states_.data()[instant].pose,
                  {posed.position.data(), posed.rotation.data(), nullptr, posed.frame.data()},
                  {d_posed.position.data(),
                   d_posed.rotation.data(),
                   nullptr,
                   d_posed.frame.empty() ? nullptr : d_posed.frame.data()},
                  sums_.view()});
  ForEach(1,
          *stream_,
          AdvanceBust{std::as_const(sums_).view(),
                      rates_.turn,
                      rates_.shift,
                      decay_,
                      rates_.spread,
                      instant,
                      states_.view(),
                      overflowed});
}

}  // namespace cosplat
