// What the lean and the web build (cmake/CosplatLean.cmake, cmake/CosplatWeb.cmake) use of oneTBB,
// on plain threads: a pool that hands out indices one by one. A loop within a loop, or beside
// another thread's, runs in its own thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace tbb {
namespace lean {

class Pool {
 public:
  static Pool& Get() {
    static Pool pool;
    return pool;
  }

  // Before the first loop: how many threads there will be, the caller's included; one per core
  // otherwise.
  static void UseThreads(unsigned threads) { threads_wanted_ = threads; }

  void Run(size_t count, const std::function<void(size_t)>& f) {
    std::unique_lock only(callers_, std::defer_lock);
    if (within_ || count < 2 || threads_.empty() || !only.try_lock()) {
      for (size_t i = 0; i < count; ++i) f(i);
      return;
    }
    job_ = &f;
    count_ = count;
    next_ = 0;
    busy_ = threads_.size();
    Begin();
    Work();
    const auto all_done = [&] { return busy_ == 0; };
    if (Soon(all_done)) return;
    std::unique_lock lock(mutex_);
    end_.wait(lock, all_done);
  }

 private:
  Pool() {
    for (unsigned t = 1; t < threads_wanted_; ++t) threads_.emplace_back([this] { Serve(); });
  }
  ~Pool() {
    stop_ = true;
    Begin();
    for (std::thread& t : threads_) t.join();
  }

  // A step of training has dozens of loops, shorter than it takes to wake a thread: the next one
  // often begins while the threads still look for it.
  template <class Condition>
  static bool Soon(const Condition& condition) {
    constexpr std::chrono::microseconds kPatience{50};
    const auto end = std::chrono::steady_clock::now() + kPatience;
    do {
      for (int i = 0; i < 100; ++i) {
        if (condition()) return true;
        std::this_thread::yield();
      }
    } while (std::chrono::steady_clock::now() < end);
    return false;
  }

  // A thread counts itself as asleep before it looks for a last time: it sees the new round, or is
  // seen here.
  void Begin() {
    ++round_;
    if (asleep_ == 0) return;
    std::lock_guard lock(mutex_);
    begin_.notify_all();
  }
  void Work() {
    within_ = true;
    for (size_t i = next_++; i < count_; i = next_++) (*job_)(i);
    within_ = false;
  }
  void Serve() {
    size_t seen = 0;
    const auto has_begun = [&] { return round_ != seen; };
    while (true) {
      if (!Soon(has_begun)) {
        std::unique_lock lock(mutex_);
        ++asleep_;
        begin_.wait(lock, has_begun);
        --asleep_;
      }
      seen = round_;
      if (stop_) return;
      Work();
      if (--busy_ > 0) continue;
      std::lock_guard lock(mutex_);
      end_.notify_one();
    }
  }

  static inline unsigned threads_wanted_ = std::thread::hardware_concurrency();
  static inline thread_local bool within_ = false;
  std::vector<std::thread> threads_;
  std::mutex callers_, mutex_;
  std::condition_variable begin_, end_;
  const std::function<void(size_t)>* job_ = nullptr;
  size_t count_ = 0;
  std::atomic<size_t> next_{0}, busy_{0}, round_{0}, asleep_{0};
  std::atomic<bool> stop_ = false;
};

}  // namespace lean

template <class Index>
class blocked_range {
 public:
  blocked_range(Index begin, Index end, size_t grain = 1)
      : begin_(begin), end_(end), grain_(grain) {}
  Index begin() const { return begin_; }
  Index end() const { return end_; }
  size_t size() const { return size_t(end_ - begin_); }
  size_t grainsize() const { return grain_; }

 private:
  Index begin_, end_;
  size_t grain_;
};

template <class Index, class F>
void parallel_for(Index begin, Index end, const F& f) {
  if (end <= begin) return;
  lean::Pool::Get().Run(size_t(end - begin), [&](size_t i) { f(Index(begin + Index(i))); });
}

template <class Index, class F>
void parallel_for(const blocked_range<Index>& range, const F& f) {
  const size_t blocks = (range.size() + range.grainsize() - 1) / range.grainsize();
  lean::Pool::Get().Run(blocks, [&](size_t b) {
    const Index first = range.begin() + Index(b * range.grainsize());
    const Index last = std::min(range.end(), Index(first + Index(range.grainsize())));
    f(blocked_range<Index>(first, last, range.grainsize()));
  });
}

}  // namespace tbb
