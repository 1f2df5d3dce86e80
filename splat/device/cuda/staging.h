// Ordinary memory of the host on its way to the device, with no waiting for what the device is at.
//
// The driver may wait for the stream before it reads memory that is not pinned. So it is copied to
// pinned memory first: to two pieces in turn, since one may still be on its way.
#pragma once

#include <array>
#include <cstring>

#include "splat/device/cuda/memory.h"
#include "splat/device/cuda/stream.h"

namespace cosplat::cuda {

class Staging {
 public:
  // `from` is free at once. Waits only where the last transfer but one is not over.
  void Send(const void* from, size_t bytes, void* to, cudaStream_t stream) {
    if (bytes == 0) return;
    Piece& piece = pieces_[next_];
    next_ = 1 - next_;
    piece.sent.Wait();
    std::memcpy(piece.RoomFor(bytes), from, bytes);
    Check(cudaMemcpyAsync(to, piece.memory, bytes, cudaMemcpyHostToDevice, stream),
          "cudaMemcpyAsync");
    piece.sent.Record(stream);
  }

 private:
  struct Piece {
    Piece() = default;
    ~Piece() { cudaFreeHost(memory); }
    Piece(const Piece&) = delete;
    Piece& operator=(const Piece&) = delete;
    void* RoomFor(size_t wanted) {
      if (wanted > bytes) {
        Check(cudaFreeHost(std::exchange(memory, nullptr)), "cudaFreeHost");
        bytes = 0;
        Check(cudaMallocHost(&memory, wanted), "cudaMallocHost");
        bytes = wanted;
      }
      return memory;
    }

    void* memory = nullptr;
    size_t bytes = 0;
    Event sent;
  };
  std::array<Piece, 2> pieces_;
  size_t next_ = 0;
};

}  // namespace cosplat::cuda
