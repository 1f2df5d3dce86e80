// How long a step of a training on several ranks takes, calculated from a run on one: for
// docs/large-scenes.md.
//
// A step of B views on R ranks, each with a core of its own:
//   rounds = ceil(B / R) views that a rank draws x (per drawn Gaussian x D + per pixel x P)
//   + (B N x per Gaussian + B D x per summed Gaussian + U x per updated Gaussian) / R
//   + bytes of a rank x (1 / copying + 1 / bandwidth) + messages x latency
//   splat/train/ranks/view_exchange.h
// N: Gaussians of the scene, D of them drawn in a view, U in one of the B views at least.
#pragma once

#include <cstddef>
#include <string>

namespace cosplat::scale {

// Of the machine and the data.
struct Measured {
  // Processor seconds of one rank with one thread: what else the machine does disturbs them less
  // than the time of day.
  double per_gaussian = 0;  // projecting all, for a view
  double per_drawn = 0;     // sorting those that are drawn
  double per_pixel = 0;     // blending, the loss, and back
  double per_summed = 0;    // adding a view's gradients to the sum
  double per_updated = 0;   // Adam
  double drawn = 0;         // share of the Gaussians in groups that a view draws
  double updated = 0;       // share in groups that a step updates
  double gaussians = 0, pixels = 0, batch = 0;
};
// From the stats.json of a run by one rank with one thread, without density control and at one size
// of image. pixels: of a view. Throws Error if it is not of such a run.
Measured MeasuredIn(const std::string& stats_json, double pixels);

// Bytes per second that a rank packs, copies, and that others unpack: on the machine of
// docs/large-scenes.md 45 MB in 17 ms.
constexpr double kCopying = 2.7e9;

struct Machine {
  double ranks = 1;
  double bandwidth = 0;    // of a rank's link, bytes per second, in and out of a rank
  double latency = 50e-6;  // seconds of a message: TCP in a local network
};

struct Training {
  double gaussians = 0;
  double pixels = 0;
  double batch = 0;
  double drawn = 0, updated = 0;  // Gaussians, as above
  double assembled = 0;           // numbers a step that all ranks are told for density control
  double moved = 0;               // numbers a step that change places; of one rank none is sent
};
// The training of a run as measured.
Training TrainingOf(const Measured& measured);
// A scene that grows by its area: a view draws the measured share, but at most `most_drawn`. Which
// Gaussians a view draws is independent of the other views.
Training LargeTraining(const Measured& measured, double gaussians, double batch);
constexpr double kMaxDrawn = 2e6;

struct StepTime {
  double drawing = 0, own_share = 0, exchange = 0;  // seconds
  double bytes = 0;                                 // sent, by all ranks together
  double total() const { return drawing + own_share + exchange; }
};
StepTime TimeOf(const Measured& measured, const Training& training, const Machine& machine);

}  // namespace cosplat::scale
