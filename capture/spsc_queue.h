// A bounded ring between one producer thread and one consumer thread, lock-free and without allocation after
// construction.
//
//        head_ (consumer)          tail_ (producer)
//           v                          v
//   [ . . . x x x x x x x x x x x x x x . . . ]   capacity a power of two
//
// What to do when it is full is decided once, where the queue is made: try_push refuses and counts.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <new>
#include <type_traits>
#include <vector>

#include "capture/counters.h"

namespace risorius {

template <class T>
requires std::is_trivially_copyable_v<T>
class SpscQueue {
 public:
  /// Rounds the capacity up to a power of two.
  explicit SpscQueue(std::size_t capacity)
      : ring_(std::bit_ceil(capacity < 2 ? 2 : capacity)), mask_(ring_.size() - 1) {}
  SpscQueue(const SpscQueue&) = delete;
  SpscQueue& operator=(const SpscQueue&) = delete;

  /// Producer: the place of the next value, or null when the queue is full (counted). Fill it, then commit().
  T* try_claim() noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - known_head_ == ring_.size()) {
      known_head_ = head_.load(std::memory_order_acquire);
      if (tail - known_head_ == ring_.size()) {
        refused_.add();
        return nullptr;
      }
    }
    return &ring_[tail & mask_];
  }
  void commit() noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed) + 1;
    tail_.store(tail, std::memory_order_release);
    pushed_.add();
    high_water_.raise_to(tail - head_.load(std::memory_order_relaxed));
  }
  bool try_push(const T& value) noexcept {
    T* place = try_claim();
    if (place == nullptr) return false;
    *place = value;
    commit();
    return true;
  }

  /// Consumer: the oldest value, or null when the queue is empty. Valid until release().
  const T* front() noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == known_tail_) {
      known_tail_ = tail_.load(std::memory_order_acquire);
      if (head == known_tail_) return nullptr;
    }
    return &ring_[head & mask_];
  }
  void release() noexcept {
    head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
    popped_.add();
  }
  bool try_pop(T& value) noexcept {
    const T* oldest = front();
    if (oldest == nullptr) return false;
    value = *oldest;
    release();
    return true;
  }

  std::size_t capacity() const noexcept { return ring_.size(); }
  std::size_t size() const noexcept {
    const std::size_t head = head_.load(std::memory_order_acquire);
    const std::size_t tail = tail_.load(std::memory_order_acquire);
    return tail - head;
  }
  std::uint64_t pushed() const noexcept { return pushed_.value(); }
  std::uint64_t popped() const noexcept { return popped_.value(); }
  std::uint64_t refused() const noexcept { return refused_.value(); }
  std::uint64_t high_water() const noexcept { return high_water_.value(); }

 private:
  static constexpr std::size_t kCacheLine = 64;

  std::vector<T> ring_;
  std::size_t mask_;
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};
  std::size_t known_head_ = 0;
  Counter pushed_, refused_, high_water_;
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};
  std::size_t known_tail_ = 0;
  Counter popped_;
};

}  // namespace risorius
