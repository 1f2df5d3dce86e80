// The processes that train one scene together, and how they exchange data.
//
// All ranks run the same program on the same data. What they do not share, all of them compute,
// from the same bits and with the same result: the order of the views, random numbers, density
// control. They divide the Gaussians (splat/train/ranks/shards.h), with their moments and all that
// Adam does to them, and the views of a step (splat/train/ranks/view_exchange.h).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "splat/device/buffer.h"

namespace cosplat {

using Message = Buffer<uint32_t>;  // in host memory, but for those of RankMessages

class Ranks {
 public:
  virtual ~Ranks() = default;
  virtual size_t rank() const = 0;
  virtual size_t size() const = 0;
  // Among those of this machine, and how many these are.
  virtual size_t local_rank() const = 0;
  virtual size_t local_size() const = 0;

  // Sends to[r] to rank r and receives from[r] from it, for every r but this rank, whose message is
  // left empty. All ranks make the same calls in the same order. to: [size()]. Throws Error if
  // another rank has ended.
  virtual void Exchange(const std::vector<View<const uint32_t>>& to,
                        std::vector<Message>& from) = 0;
  // Whether all ranks call this within a second, as those do that fail alike.
  virtual bool EndTogether() = 0;
  // Those that call this with the same number, in the same order. All ranks call it.
  virtual std::shared_ptr<Ranks> Part(size_t part) = 0;

  // What this rank has sent so far, and its seconds in Exchange, waiting included.
  virtual uint64_t bytes_sent() const = 0;
  virtual double seconds() const = 0;
};

// A process that trains alone.
std::shared_ptr<Ranks> OneRank();
// The ranks that mpirun started this process among, or OneRank() where it did not. Once per
// process. Throws Error if there are several and the program was built without MPI.
std::shared_ptr<Ranks> JoinRanks();
// The same where it did, with MPI (Open MPI). Throws Error if that cannot be used.
std::shared_ptr<Ranks> JoinMpi();

// What each rank sends to all others; this rank's own entry is empty.
std::vector<Message> ExchangeWithAll(View<const uint32_t> message, Ranks& ranks);

// Over all ranks.
uint64_t Sum(uint64_t number, Ranks& ranks);
uint32_t Largest(uint32_t number, Ranks& ranks);
uint32_t Smallest(uint32_t number, Ranks& ranks);
// Throws Error on all ranks if they have not computed the same number of Gaussians, as machines or
// GPUs of different kinds may.
void CheckAlike(size_t gaussians, Ranks& ranks);

// What rank 0 passes to it.
std::string TextOfRankZero(const std::string& text, Ranks& ranks);

}  // namespace cosplat
