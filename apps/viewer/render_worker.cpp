#include "apps/viewer/render_worker.h"

#include <chrono>
#include <exception>
#include <utility>

namespace cosplat::viewer {
namespace {

void DrawInto(Stage& stage, FinishedImage& picture) {
  const auto start = std::chrono::steady_clock::now();
  const Shot& shot = picture.job.shot;
  picture.problem.clear();
  picture.stayed = picture.job.may_stay && stage.DrawsOnDevice(shot);
  try {
    if (picture.stayed) {
      picture.image = {};
      stage.DrawToStay(shot, picture.on_device);
    } else {
      stage.Draw(shot, picture.image);
    }
  } catch (const std::exception& problem) {
    picture.image = {};
    picture.stayed = false;
    picture.problem = problem.what();
  }
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  picture.milliseconds = took.count();
}

}  // namespace

RenderWorker::RenderWorker(Stage& stage, std::function<void()> on_finished)
    : stage_(stage), on_finished_(std::move(on_finished)), thread_([this] { Run(); }) {}

RenderWorker::~RenderWorker() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void RenderWorker::Start(RenderJob job) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(job);
  }
  wake_.notify_one();
}

bool RenderWorker::Busy() const {
  const std::lock_guard lock(mutex_);
  return drawing_ || waiting_;
}

bool RenderWorker::TakeImage(FinishedImage& out) {
  const std::lock_guard lock(mutex_);
  if (!has_finished_) return false;
  std::swap(out, finished_);
  has_finished_ = false;
  return true;
}

void RenderWorker::Run() {
  FinishedImage picture;
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stop_ || waiting_; });
    if (stop_) return;
    picture.job = std::move(*waiting_);
    waiting_.reset();
    drawing_ = true;
    lock.unlock();
    DrawInto(stage_, picture);
    lock.lock();
    drawing_ = false;
    has_finished_ = true;
    std::swap(finished_, picture);
    lock.unlock();
    on_finished_();
    lock.lock();
  }
}

}  // namespace cosplat::viewer
