// One open avatar of the plug-in, which a handle refers to. Not thread-safe, except where noted.
//
// handle_table.h -> Instance -> Player, DepthPass -> the caller's memory. Throws CodedError, or
// Error for bad files; boundary.h turns both into a status.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "avatar/play/player.h"
#include "avatar/plugin/cosplat.h"
#include "avatar/plugin/depth_pass.h"
#include "avatar/plugin/host_camera.h"
#include "avatar/plugin/instance_face.h"
#include "avatar/plugin/live_parameters.h"

namespace cosplat::plugin {

class Instance {
 public:
  Instance(const char* avatar_path, const cosplat_open_options& options);
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  const cosplat_info& info() const { return info_; }
  const std::vector<std::string>& expression_names() const { return expression_names_; }
  const LiveParameters& parameters() const { return parameters_; }
  InstanceFace& face() { return face_; }
  std::optional<Camera>& camera() { return camera_; }
  const HeadPlace& head_place() const { return head_place_; }

  // change(LiveParameters&) applies one cosplat_set_... call; refused parameters are counted.
  template <class Change>
  void ChangeParameters(const Change& change) {
    try {
      change(parameters_);
    } catch (const BadFrame& refused) {
      face_.CountRefused(refused.verdict());
      throw;
    }
    face_.Offer(parameters_);
  }
  void ResetParameters();
  void SetDrive(const char* drive);
  void Advance(int64_t now_ns) { face_.Advance(now_ns, parameters_); }
  void Render(const cosplat_picture& picture);
  // Its texts are valid until the next call.
  cosplat_health Health();
  // The Gaussians that Render draws now. Valid until the next call of either.
  WorldGaussians Placed();
  const AvatarModel& avatar() const { return player_.avatar(); }

  // Thread-safe. Returns true to one thread at a time, until that thread calls Leave.
  bool TryEnter() { return !busy_.exchange(true, std::memory_order_acquire); }
  void Leave() { busy_.store(false, std::memory_order_release); }

  // Text of cosplat_last_error. The last byte is always zero.
  std::array<char, 512>& last_error() { return last_error_; }

 private:
  Camera CameraFor(const cosplat_picture& picture) const;
  const FlameParams& Face() const;
  void Pose();

  FlameModel flame_;
  Player player_;
  FlameParams rest_;
  LiveParameters parameters_;
  InstanceFace face_;
  PosedAvatar placed_;
  std::optional<Camera> camera_;
  std::optional<DepthPass> depth_;  // created when a depth is first requested
  cosplat_info info_{};
  HeadPlace head_place_;
  uint64_t beyond_film_ = 0;
  std::vector<std::string> expression_names_;
  std::array<char, 512> last_error_{};
  std::atomic<bool> busy_ = false;
};

}  // namespace cosplat::plugin
