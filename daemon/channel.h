// A bounded queue between two threads of the daemon, with the bell of its consumer and a reserve for control items.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <thread>

#include "capture/spsc_queue.h"
#include "daemon/doorbell.h"

namespace risorius {

template <class T>
class Channel {
 public:
  /// Overflow policy: a frame that finds less than the reserve free is refused and counted (the newest goes, so that
  /// what is in the queue stays in order); control items (sets, ends of takes) may use the reserve, so frames never
  /// push them out.
  explicit Channel(std::size_t capacity) : most_frames_(capacity), queue_(capacity + kReserve) {}

  /// Producer.
  bool send_frame(const T& item) noexcept {
    if (queue_.size() >= most_frames_) {
      refused_frames_.add();
      return false;
    }
    return send_control(item);
  }
  bool send_control(const T& item) noexcept {
    if (!queue_.try_push(item)) return false;
    bell_.ring();
    return true;
  }
  void ring() noexcept { bell_.ring(); }
  /// An item will follow within microseconds: the consumer wakes while the producer still works on it, so that the time
  /// that waking takes does not come on top. Who has something to work on is awake, and is not told.
  void announce() noexcept {
    if (queue_.size() > 0) return;
    announced_.store(true, std::memory_order_release);
    bell_.ring();
  }

  /// Consumer. Sleeps until it rings; where an item was announced, stays awake for it, giving way to whoever else wants
  /// the processor, for kPatience at most.
  void wait() noexcept {
    bell_.wait();
    if (!announced_.exchange(false, std::memory_order_acquire)) return;
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (queue_.front() == nullptr && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  }
  const T* front() noexcept { return queue_.front(); }
  void release() noexcept { queue_.release(); }

  std::uint64_t refused_frames() const noexcept { return refused_frames_.value(); }
  std::uint64_t refused_control() const noexcept { return queue_.refused(); }
  const SpscQueue<T>& queue() const noexcept { return queue_; }

 private:
  static constexpr std::size_t kReserve = 64;
  static constexpr std::chrono::microseconds kPatience{400};
  std::size_t most_frames_;
  SpscQueue<T> queue_;
  Doorbell bell_;
  std::atomic<bool> announced_{false};
  Counter refused_frames_;
};

}  // namespace risorius
