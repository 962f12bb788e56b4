#include "replay/mcap/disk_sync.h"

#include <cerrno>
#include <unistd.h>
#include <utility>

namespace risorius {

DiskSync::DiskSync(int descriptor) : descriptor_(descriptor), thread_([this] { run(); }) {}

DiskSync::~DiskSync() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void DiskSync::request() noexcept {
  {
    const std::scoped_lock lock(mutex_);
    requested_ = true;
  }
  changed_.notify_all();
}

void DiskSync::wait() noexcept {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !requested_ && !syncing_; });
}

int DiskSync::take_problem() noexcept {
  const std::scoped_lock lock(mutex_);
  return std::exchange(problem_, 0);
}

void DiskSync::run() noexcept {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return requested_ || stopping_; });
    if (!requested_) return;
    requested_ = false;
    syncing_ = true;
    lock.unlock();
    const int problem = ::fdatasync(descriptor_) == 0 ? 0 : errno;
    lock.lock();
    syncing_ = false;
    if (problem != 0) problem_ = problem;
    changed_.notify_all();
  }
}

}  // namespace risorius
