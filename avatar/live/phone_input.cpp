#include <chrono>
#include <optional>

#include "avatar/live/packet_input.h"
#include "avatar/live/udp_socket.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

// Apps send for a while after each request: VTube Studio's for the time that it names.
constexpr auto kAskEvery = std::chrono::seconds(1);

// iFacialMocap answers to this port of whoever asks.
constexpr int kIFacialMocapPort = 49983;

std::string RequestOf(const DriveAddress& phone, int port) {
  if (phone.scheme == "vts")
    return R"({"messageType":"iOSTrackingDataRequest","time":5.0,"sentBy":"CoSplat","ports":[)" +
           std::to_string(port) + "]}";
  return "iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719";
}

class PhoneInput : public PacketInput {
 public:
  explicit PhoneInput(const DriveAddress& phone)
      : phone_(UdpSocket::ConnectTo(phone)),
        description_(phone.scheme + "://" + HostAndPort(phone.host, phone.port)) {
    // Where the phone reaches this machine, and nobody else does.
    DriveAddress here = ParseDriveAddress("udp://" + phone_.LocalAddress());
    here.drive = phone.drive;
    here.port = phone.scheme == "vts" ? 0 : kIFacialMocapPort;
    UdpSocket socket = UdpSocket::Listen(here);
    const std::string local = socket.LocalAddress();
    request_ = RequestOf(phone, ParseDriveAddress("udp://" + local).port);
    description_ += " to " + local;
    answers_ = OpenUdpInput(std::move(socket), description_, phone_.RemoteAddress());
  }

  void Receive(NewestPackets& packets, LiveCounts& counts) override {
    // By the real clock, which is the phone's: a host's may run faster.
    const auto now = std::chrono::steady_clock::now();
    if (!asked_ || now - *asked_ >= kAskEvery) {
      asked_ = now;
      if (!phone_.Send(request_))
        counts.last_problem = description_ + ": the phone refuses requests: is its app open?";
    }
    answers_->Receive(packets, counts);
  }
  bool Ended() const override { return false; }
  std::string Description() const override { return description_; }

 private:
  UdpSocket phone_;  // what is asked
  std::string description_, request_;
  std::unique_ptr<PacketInput> answers_;
  std::optional<std::chrono::steady_clock::time_point> asked_;
};

}  // namespace

std::unique_ptr<PacketInput> OpenPhoneInput(const DriveAddress& phone) {
  if (phone.port == 0) throw Error(phone.drive, "port", "found 0, expected the phone's");
  return std::make_unique<PhoneInput>(phone);
}

}  // namespace cosplat
