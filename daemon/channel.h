// A bounded queue between two threads of the daemon, with the bell of its consumer and a reserve for control items.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>

#include "capture/monotonic_clock.h"
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
  /// Producer. An item will follow within microseconds: the consumer wakes while the producer still works on it, so
  /// that the time that waking takes does not come on top. Who has something to work on is awake, and is not told.
  void announce() noexcept { announce(monotonic_now_ns() + kPatienceNs); }
  /// The same of an item that should come until then.
  void announce(std::int64_t until_ns) noexcept {
    if (queue_.size() > 0) return;
    if (until_ns > awake_until_ns_.load(std::memory_order_relaxed))  // of several sources, the one that is due last
      awake_until_ns_.store(until_ns, std::memory_order_release);
    bell_.ring();
  }

  /// Consumer. Sleeps until it rings; where an item was announced, stays awake for it until the announced time, giving
  /// way to whoever else wants the processor.
  void wait() noexcept {
    bell_.wait();
    const auto waited_for = [this] { return awake_until_ns_.load(std::memory_order_acquire); };
    while (queue_.front() == nullptr && monotonic_now_ns() < waited_for()) std::this_thread::yield();
  }
  const T* front() noexcept { return queue_.front(); }
  void release() noexcept {
    awake_until_ns_.store(0, std::memory_order_relaxed);  // it has come, and is not waited for a second time
    queue_.release();
  }

  std::uint64_t refused_frames() const noexcept { return refused_frames_.value(); }
  std::uint64_t refused_control() const noexcept { return queue_.refused(); }
  const SpscQueue<T>& queue() const noexcept { return queue_; }

 private:
  static constexpr std::size_t kReserve = 64;
  static constexpr std::int64_t kPatienceNs = 400'000;
  std::size_t most_frames_;
  SpscQueue<T> queue_;
  Doorbell bell_;
  std::atomic<std::int64_t> awake_until_ns_{0};  ///< 0 = nothing is announced
  Counter refused_frames_;
};

}  // namespace risorius
