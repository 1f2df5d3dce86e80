#include "apps/obs/picture_thread.h"

#include <obs-module.h>

#include <algorithm>

namespace cosplat::obs {

PictureThread::PictureThread() : thread_([this] { Run(); }) {}

PictureThread::~PictureThread() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void PictureThread::Set(const PictureSettings& settings) {
  {
    const std::lock_guard lock(mutex_);
    if (set_ && settings == settings_) return;
    settings_ = settings;
    set_ = dirty_ = true;
  }
  changed_.notify_one();
}

void PictureThread::SetShown(bool shown) {
  {
    const std::lock_guard lock(mutex_);
    shown_ = shown;
  }
  changed_.notify_one();
}

bool PictureThread::TakeImage(Picture& picture) {
  const std::lock_guard lock(mutex_);
  if (!fresh_) return false;
  std::swap(picture, newest_);
  fresh_ = false;
  return true;
}

std::string PictureThread::Status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

bool PictureThread::WaitForWork(PictureSettings& settings) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return stop_ || (set_ && shown_); });
  // Changed settings take effect immediately.
  changed_.wait_until(lock, due_, [&] { return stop_ || dirty_; });
  dirty_ = false;
  settings = settings_;
  return !stop_;
}

void PictureThread::Run() {
  PictureSettings settings;
  Picture picture;
  while (WaitForWork(settings)) {
    const auto period = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(1 / settings.fps));
    // If the machine is too slow, pictures are skipped and there is no catching up.
    due_ = std::max(due_ + period, Clock::now());
    try {
      Draw(settings, picture);
      Publish(picture, view_->Status());
    } catch (const std::exception& error) {
      view_.reset();
      Fail(error.what());
    }
  }
}

void PictureThread::Draw(const PictureSettings& settings, Picture& out) {
  if (!view_ || settings.view != open_) {
    view_.reset();  // frees the drive's port before it is opened again
    view_ = std::make_unique<hosts::AvatarView>(settings.view);
    open_ = settings.view;
  }
  out.width = settings.width;
  out.height = settings.height;
  out.pixels.resize(size_t(4) * out.width * out.height);
  cosplat_picture picture{};
  picture.struct_size = sizeof(picture);
  picture.width = out.width;
  picture.height = out.height;
  picture.format = COSPLAT_FORMAT_BGRA8;
  picture.pixels = out.pixels.data();
  view_->Advance(std::chrono::nanoseconds(Clock::now().time_since_epoch()).count());
  view_->Draw(settings.orbit, settings.background, COSPLAT_ALPHA_PREMULTIPLIED, picture);
}

void PictureThread::Publish(Picture& picture, const std::string& status) {
  const std::lock_guard lock(mutex_);
  std::swap(picture, newest_);
  status_ = status;
  fresh_ = true;
}

// Settings that failed are not retried until they are set again.
void PictureThread::Fail(const std::string& problem) {
  blog(LOG_WARNING, "[cosplat] %s", problem.c_str());
  const std::lock_guard lock(mutex_);
  newest_ = {};
  status_ = problem;
  fresh_ = true;
  if (!dirty_) set_ = false;
}

}  // namespace cosplat::obs
