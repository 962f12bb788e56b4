// Brings a growing file to the disk (fdatasync) on a thread of its own: a disk can take seconds for it, and whoever
// writes must not wait, or what it has not yet handed to the kernel is lost when the process is killed. Requests that
// come during a sync are one sync.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

namespace risorius {

class DiskSync {
 public:
  /// The descriptor stays the caller's, and open until this object is gone.
  explicit DiskSync(int descriptor);
  ~DiskSync();
  DiskSync(const DiskSync&) = delete;
  DiskSync& operator=(const DiskSync&) = delete;

  /// What is in the file now is to be on the disk soon.
  void request() noexcept;
  /// Waits until all that was requested is there.
  void wait() noexcept;
  /// The errno of a sync that failed since this was asked last; 0: none.
  int take_problem() noexcept;

 private:
  void run() noexcept;

  int descriptor_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool requested_ = false, syncing_ = false, stopping_ = false;
  int problem_ = 0;
  std::thread thread_;
};

}  // namespace risorius
