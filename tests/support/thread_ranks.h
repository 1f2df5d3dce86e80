// Ranks (splat/train/ranks/ranks.h) that are threads of this process.
#pragma once

#include <barrier>
#include <functional>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "splat/train/ranks/ranks.h"

namespace cosplat::test {

class ThreadRanks : public Ranks {
 public:
  struct Mailbox {
    explicit Mailbox(size_t ranks)
        : sent(ranks, std::vector<Message>(ranks)), all(ptrdiff_t(ranks)) {}
    std::vector<std::vector<Message>> sent;  // [from][to]
    std::barrier<> all;
  };

  ThreadRanks(std::shared_ptr<Mailbox> mailbox, size_t rank) : mailbox_(mailbox), rank_(rank) {}
  size_t rank() const override { return rank_; }
  size_t size() const override { return mailbox_->sent.size(); }
  size_t local_rank() const override { return rank_; }
  size_t local_size() const override { return size(); }
  void Exchange(const std::vector<View<const uint32_t>>& to, std::vector<Message>& from) override {
    from.resize(size());
    for (size_t r = 0; r < size(); ++r) {
      if (r == rank_) continue;
      mailbox_->sent[rank_][r].assign(to[r].begin(), to[r].end());
      bytes_sent_ += to[r].size() * sizeof(uint32_t);
    }
    mailbox_->all.arrive_and_wait();
    for (size_t r = 0; r < size(); ++r)
      if (r != rank_) from[r] = mailbox_->sent[r][rank_];
    mailbox_->all.arrive_and_wait();
  }
  bool EndTogether() override {
    mailbox_->all.arrive_and_wait();
    return true;
  }
  std::shared_ptr<Ranks> Part(size_t) override { throw std::logic_error("threads have no parts"); }
  uint64_t bytes_sent() const override { return bytes_sent_; }
  double seconds() const override { return 0; }

 private:
  std::shared_ptr<Mailbox> mailbox_;
  size_t rank_;
  uint64_t bytes_sent_ = 0;
};

// Runs `task` as each of the ranks.
inline void OnThreads(size_t ranks, const std::function<void(std::shared_ptr<Ranks>)>& task) {
  const auto mailbox = std::make_shared<ThreadRanks::Mailbox>(ranks);
  std::vector<std::thread> threads;
  for (size_t r = 0; r < ranks; ++r)
    threads.emplace_back([&, r] { task(std::make_shared<ThreadRanks>(mailbox, r)); });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace cosplat::test
