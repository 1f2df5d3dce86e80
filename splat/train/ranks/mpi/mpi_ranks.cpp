#include <mpi.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "splat/base/error.h"
#include "splat/train/ranks/ranks.h"

namespace cosplat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kMaxWords = size_t(1) << 28;  // of an MPI message, whose count is an int
constexpr auto kPatience = std::chrono::seconds(1);
// Waiting gives the processor away, since ranks may share cores: the longer it has taken, the
// longer are the pauses.
constexpr int kEagerPolls = 100;
constexpr auto kPause = std::chrono::microseconds(20), kLongPause = std::chrono::microseconds(500);
constexpr auto kLookEvery = std::chrono::milliseconds(50);

void Check(int result) {
  if (result == MPI_SUCCESS) return;
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(result, text.data(), &length);
  throw Error("MPI", text.data());
}

// Where a rank runs, to see whether it still does.
struct RankHost {
  std::array<char, 256> host{};
  pid_t process = 0;
};

// The ranks of a communicator.
class MpiRanks : public Ranks {
 public:
  // Frees the communicator no earlier than MPI_Finalize does: there are two of them in a run.
  explicit MpiRanks(MPI_Comm ranks) : ranks_(ranks) {
    int rank = 0, size = 0;
    Check(MPI_Comm_set_errhandler(ranks_, MPI_ERRORS_RETURN));
    Check(MPI_Comm_dup(ranks_, &ending_));
    Check(MPI_Comm_rank(ranks_, &rank));
    Check(MPI_Comm_size(ranks_, &size));
    rank_ = size_t(rank);
    places_.resize(size_t(size));
    RankHost here;
    gethostname(here.host.data(), here.host.size() - 1);
    here.process = getpid();
    Check(
        MPI_Allgather(&here, sizeof here, MPI_BYTE, places_.data(), sizeof here, MPI_BYTE, ranks_));
  }

  size_t rank() const override { return rank_; }
  size_t size() const override { return places_.size(); }
  size_t local_rank() const override { return CountOfThisMachine(rank_); }
  size_t local_size() const override { return CountOfThisMachine(size()); }

  void Exchange(const std::vector<View<const uint32_t>>& to, std::vector<Message>& from) override {
    const Clock::time_point start = Clock::now();
    from.resize(size());
    std::vector<uint64_t> sizes(size()), own(size());
    std::vector<MPI_Request> requests;
    for (size_t r = 0; r < size(); ++r) {
      if (r == rank_) continue;
      own[r] = to[r].size();
      Check(MPI_Irecv(&sizes[r], 1, MPI_UINT64_T, int(r), 0, ranks_, &New(requests)));
      Check(MPI_Isend(&own[r], 1, MPI_UINT64_T, int(r), 0, ranks_, &New(requests)));
    }
    Await(requests);
    for (size_t r = 0; r < size(); ++r) {
      from[r].Refill(sizes[r]);
      for (size_t at = 0; at < from[r].size(); at += kMaxWords)
        Check(MPI_Irecv(from[r].data() + at,
                        int(std::min(kMaxWords, from[r].size() - at)),
                        MPI_UINT32_T,
                        int(r),
                        1,
                        ranks_,
                        &New(requests)));
      for (size_t at = 0; at < own[r]; at += kMaxWords)
        Check(MPI_Isend(to[r].data + at,
                        int(std::min(kMaxWords, own[r] - at)),
                        MPI_UINT32_T,
                        int(r),
                        1,
                        ranks_,
                        &New(requests)));
      bytes_sent_ += own[r] * sizeof(uint32_t);
    }
    Await(requests);
    seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
  }

  bool EndTogether() override {
    MPI_Request all{};
    if (Ended() != size() || MPI_Ibarrier(ending_, &all) != MPI_SUCCESS) return false;
    for (const auto end = Clock::now() + kPatience; Clock::now() < end && Ended() == size();) {
      int done = 0;
      MPI_Test(&all, &done, MPI_STATUS_IGNORE);
      if (done != 0) return ended_together_ = true;
      std::this_thread::sleep_for(kPause);
    }
    return false;
  }

  std::shared_ptr<Ranks> Part(size_t part) override {
    MPI_Comm ranks{};
    Check(MPI_Comm_split(ranks_, int(part), int(rank_), &ranks));
    return std::make_shared<MpiRanks>(ranks);
  }

  uint64_t bytes_sent() const override { return bytes_sent_; }
  double seconds() const override { return seconds_; }

 protected:
  bool ended_together() const { return ended_together_; }

 private:
  static MPI_Request& New(std::vector<MPI_Request>& requests) {
    return requests.emplace_back(MPI_REQUEST_NULL);
  }

  // Counts among the first ranks.
  size_t CountOfThisMachine(size_t first) const {
    const auto here = [&](const RankHost& place) { return place.host == places_[rank_].host; };
    return size_t(std::count_if(places_.begin(), places_.begin() + ptrdiff_t(first), here));
  }

  // A rank of this machine whose process is gone, or size(). Of other machines mpirun knows.
  size_t Ended() const {
    const RankHost& here = places_[rank_];
    for (size_t r = 0; r < size(); ++r)
      if (places_[r].host == here.host && kill(places_[r].process, 0) != 0 && errno == ESRCH)
        return r;
    return size();
  }

  void Await(std::vector<MPI_Request>& requests) {
    const Clock::time_point start = Clock::now();
    Clock::time_point look = start + kLookEvery;
    for (int polls = 0;; ++polls) {
      int done = 0;
      Check(MPI_Testall(int(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE));
      if (done != 0) return requests.clear();
      if (polls < kEagerPolls) {
        std::this_thread::yield();
        continue;
      }
      const Clock::time_point now = Clock::now();
      std::this_thread::sleep_for(
          std::clamp<Clock::duration>((now - start) / 16, kPause, kLongPause));
      if (now < look) continue;
      look = now + kLookEvery;
      if (const size_t gone = Ended(); gone != size())
        throw Error("rank " + std::to_string(gone),
                    "has ended, and with it the run: --resume goes on from its last checkpoint");
    }
  }

  MPI_Comm ranks_{}, ending_{};
  size_t rank_ = 0;
  std::vector<RankHost> places_;
  uint64_t bytes_sent_ = 0;
  double seconds_ = 0;
  bool ended_together_ = false;
};

MPI_Comm World() {
  int provided = 0;
  Check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided));
  return MPI_COMM_WORLD;
}

class AllRanks : public MpiRanks {
 public:
  AllRanks() : MpiRanks(World()) {}
  // A rank that fails alone ends without finalising, which would wait for the others.
  ~AllRanks() override {
    if (std::uncaught_exceptions() == 0 || ended_together()) MPI_Finalize();
  }
};

}  // namespace

std::shared_ptr<Ranks> JoinMpi() { return std::make_shared<AllRanks>(); }

}  // namespace cosplat
