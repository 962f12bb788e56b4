// Wakes one waiting thread; no busy waiting, no allocation, and no lock on the ringing side.
// Thread rule: any thread rings, one thread waits. A ring between two waits is never lost.
#pragma once

#include <atomic>
#include <cstdint>

namespace risorius {

class Doorbell {
 public:
  void ring() noexcept {
    rings_.fetch_add(1, std::memory_order_release);
    rings_.notify_one();
  }

  /// Returns at once if it rang since the last wait, else sleeps until it does.
  void wait() noexcept {
    rings_.wait(heard_, std::memory_order_acquire);
    heard_ = rings_.load(std::memory_order_acquire);
  }

 private:
  std::atomic<std::uint32_t> rings_{0};
  std::uint32_t heard_ = 0;
};

}  // namespace risorius
