// What the lean and the web build (cmake/CosplatLean.cmake, cmake/CosplatWeb.cmake) use of oneTBB,
// on plain threads: a pool that hands out indices one by one. A loop within a loop, or beside
// another thread's, runs in its own thread.
#pragma once

#include <algorithm>
#include <atomic>
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
    {
      std::lock_guard lock(mutex_);
      job_ = &f;
      count_ = count;
      next_ = 0;
      busy_ = threads_.size();
      ++round_;
    }
    begin_.notify_all();
    Work();
    std::unique_lock lock(mutex_);
    end_.wait(lock, [&] { return busy_ == 0; });
  }

 private:
  Pool() {
    for (unsigned t = 1; t < threads_wanted_; ++t) threads_.emplace_back([this] { Serve(); });
  }
  ~Pool() {
    {
      std::lock_guard lock(mutex_);
      stop_ = true;
      ++round_;
    }
    begin_.notify_all();
    for (std::thread& t : threads_) t.join();
  }

  void Work() {
    within_ = true;
    for (size_t i = next_++; i < count_; i = next_++) (*job_)(i);
    within_ = false;
  }
  void Serve() {
    size_t seen = 0;
    std::unique_lock lock(mutex_);
    while (true) {
      begin_.wait(lock, [&] { return round_ != seen; });
      seen = round_;
      if (stop_) return;
      lock.unlock();
      Work();
      lock.lock();
      if (--busy_ == 0) end_.notify_one();
    }
  }

  static inline unsigned threads_wanted_ = std::thread::hardware_concurrency();
  static inline thread_local bool within_ = false;
  std::vector<std::thread> threads_;
  std::mutex callers_, mutex_;
  std::condition_variable begin_, end_;
  const std::function<void(size_t)>* job_ = nullptr;
  size_t count_ = 0, busy_ = 0, round_ = 0;
  std::atomic<size_t> next_{0};
  bool stop_ = false;
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
