// Non-blocking sources of packets: a UDP socket, a phone that is asked, or lines of standard input.
//
// UdpInput, PhoneInput, LineInput -> PacketSource: JsonSource, VmcSource, PhoneSource.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "avatar/live/newest_packets.h"
#include "avatar/live/phone_frame.h"
#include "avatar/live/source.h"
#include "avatar/live/udp_socket.h"
#include "avatar/model/blendshape_map.h"
#include "splat/base/error.h"

namespace cosplat {

// Longer packets and lines are dropped. FLAME's 400 coefficients with 20 digits each need half of
// this.
constexpr size_t kMaxPacketBytes = 16 * 1024;

class PacketInput {
 public:
  virtual ~PacketInput() = default;
  // Adds the packets that have arrived since the last call; never blocks. Counts them, and those
  // that are too long or too many, and names senders that take turns.
  virtual void Receive(NewestPackets& packets, LiveCounts& counts) = 0;
  virtual bool Ended() const = 0;
  virtual std::string Description() const = 0;
};

// Count and describe dropped packets.
void CountOversize(const std::string& description, size_t bytes, LiveCounts& counts);
void CountFlooded(const std::string& description, size_t packets, LiveCounts& counts);

// One packet per datagram; reads at most 4096 per call. Throws Error when it cannot listen at the
// address.
std::unique_ptr<PacketInput> OpenUdpInput(const DriveAddress& address);

// The same of a socket that listens, from one host only; packets of others are counted.
std::unique_ptr<PacketInput> OpenUdpInput(UdpSocket socket,
                                          const std::string& description,
                                          const Peer& only_from);

// An app on a phone that sends to whoever asks, which this does once a second: by scheme "vts" or
// "ifacialmocap". One packet per datagram, of the phone only. Throws Error naming the drive when
// the phone's address cannot be reached or the port that it answers to is taken.
std::unique_ptr<PacketInput> OpenPhoneInput(const DriveAddress& phone);

// One packet per line of the descriptor, which is neither closed nor made non-blocking, because it
// may be shared. Reads at most half a megabyte per call. Blank lines are skipped.
std::unique_ptr<PacketInput> OpenLineInput(int descriptor, const std::string& description);

// The map from blendshape scores that a source uses.
struct ChosenMap {
  BlendshapeMap map;
  std::string description;  // "the avatar's own blendshape map"
};

// matrix: a user's file, or "". Otherwise the avatar's map or, without one, the general one. Throws
// Error as ReadBlendshapeMatrix does.
ChosenMap ChooseBlendshapeMap(const std::string& matrix, const LiveSourceOptions& options);

// What sources of packets share.
class PacketSource : public LiveSource {
 public:
  bool Ended() const override { return input_->Ended(); }
  LiveCounts Counts() const override { return counts_; }
  std::string Description() const override {
    return input_->Description() + ", by " + chosen_.description;
  }

 protected:
  // max_packets: per poll
  PacketSource(std::unique_ptr<PacketInput> input,
               ChosenMap chosen,
               const FlameParams& rest,
               size_t max_packets)
      : input_(std::move(input)),
        chosen_(std::move(chosen)),
        index_(chosen_.map.names),
        rest_(rest),
        packets_(max_packets) {}

  // Calls take(packet) for those that have arrived; where it throws Error, the packet is malformed.
  template <class Take>
  void TakePackets(const Take& take) {
    packets_.Clear();
    input_->Receive(packets_, counts_);
    for (size_t i = 0; i < packets_.size(); ++i) {
      try {
        take(packets_[i]);
      } catch (const Error& error) {
        ++counts_.malformed;
        counts_.last_problem = error.what();
      }
    }
  }

  std::unique_ptr<PacketInput> input_;
  ChosenMap chosen_;
  BlendshapeIndex index_;
  FlameParams rest_;
  NewestPackets packets_;
  LiveCounts counts_;
};

// The places of a frame's scores in a map: those that the map does not have, and `dropped` ones,
// are counted; those that are missing are 0. values: as many as there are places.
void TakeScores(const BlendshapeScores& scores,
                const std::vector<std::string>& dropped,
                const BlendshapeIndex& index,
                const std::string& description,
                std::vector<float>& values,
                LiveCounts& counts);

// FLAME parameters or blendshape scores as lines of JSON (docs/live-input.md):
// PacketInput -> ParseJsonFrame -> JsonSource -> LiveFrame.
std::unique_ptr<LiveSource> OpenJsonSource(std::unique_ptr<PacketInput> input,
                                           ChosenMap map,
                                           const LiveSourceOptions& options);

// Blendshapes of a face tracker in the Virtual Motion Capture protocol (docs/live-input.md):
// PacketInput -> ParseOsc -> VmcSource -> LiveFrame.
std::unique_ptr<LiveSource> OpenVmcSource(std::unique_ptr<PacketInput> input,
                                          ChosenMap map,
                                          const LiveSourceOptions& options);

// Apps on phones (docs/live-input.md): PacketInput -> parse -> PhoneSource -> LiveFrame. signs: of
// the head's angles, 1 or -1.
std::unique_ptr<LiveSource> OpenPhoneSource(std::unique_ptr<PacketInput> input,
                                            PhoneParser parse,
                                            ChosenMap map,
                                            const LiveSourceOptions& options,
                                            const HeadAngles& signs = {1, 1, 1});

// "webcam:", "webcam:N", "webcam:FILM", "audio:" and "audio:-": the command `cosplat webcam` or
// `cosplat voice`, which ends with the source and writes lines of JSON. Throws Error if it cannot
// be started; why it ended is the counts' last problem.
bool IsProgramDrive(const std::string& drive);
std::unique_ptr<LiveSource> OpenProgramSource(const std::string& drive,
                                              const LiveSourceOptions& options);

}  // namespace cosplat
