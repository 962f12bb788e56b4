// A bounded ring of records of any length between one producer thread and one consumer thread, lock-free and without
// allocation after construction: what is recorded waits here for the disk.
//
//   [ head payload | head payload | ...free... | head payload | unused end ]   each from an address of 8; none is split
//
// It rings no bell: the consumer looks when it wants to, so a record costs its producer a copy and one store. A record
// that finds no room is refused; whoever offers it counts it.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "capture/check.h"
#include "capture/counters.h"

namespace risorius {

class RecordRing {
 public:
  struct Head {
    std::uint32_t bytes = 0;   ///< of the payload
    std::uint16_t kind = 0;    ///< the user's; kSkip is ours
    std::uint16_t stream = 0;  ///< the user's, as are the rest
    std::uint32_t sequence = 0;
    std::uint32_t reserved = 0;
    std::int64_t time_ns = 0;
  };
  struct Record {
    Head head;
    std::span<const std::byte> payload;
  };

  /// Rounds up to a power of two.
  explicit RecordRing(std::size_t bytes) : ring_(std::bit_ceil(bytes < 4096 ? 4096 : bytes)) {}
  RecordRing(const RecordRing&) = delete;
  RecordRing& operator=(const RecordRing&) = delete;

  /// Producer. The payload is `first` and then `second`. False if less than `keep_free` bytes would be left.
  bool try_push(Head head, std::span<const std::byte> first, std::span<const std::byte> second = {},
                std::size_t keep_free = 0) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    const std::size_t at = tail & (ring_.size() - 1), to_end = ring_.size() - at;
    const std::size_t bytes = sizeof(Head) + first.size() + second.size();
    const std::size_t whole = (bytes + kAlign - 1) / kAlign * kAlign;
    const std::size_t skipped = whole <= to_end ? 0 : to_end;
    const std::size_t free = ring_.size() - (tail - head_.load(std::memory_order_acquire));
    if (whole > ring_.size() || skipped + whole + keep_free > free) return false;
    head.bytes = static_cast<std::uint32_t>(first.size() + second.size());
    if (skipped >= sizeof(Head)) {
      const Head skip{.kind = kSkip};
      std::memcpy(&ring_[at], &skip, sizeof skip);
    }
    std::byte* place = &ring_[skipped > 0 ? 0 : at];
    std::memcpy(place, &head, sizeof head);
    if (!first.empty()) std::memcpy(place + sizeof head, first.data(), first.size());
    if (!second.empty()) std::memcpy(place + sizeof head + first.size(), second.data(), second.size());
    tail_.store(tail + skipped + whole, std::memory_order_release);
    high_water_.raise_to(ring_.size() - free + skipped + whole);
    return true;
  }

  /// Consumer: a mark behind what is in the ring now.
  std::size_t end() const noexcept { return tail_.load(std::memory_order_acquire); }
  /// Consumer: the oldest record before the mark. Valid until release().
  std::optional<Record> front(std::size_t end) noexcept {
    while (true) {
      const std::size_t begin = head_.load(std::memory_order_relaxed);
      if (begin == end) return std::nullopt;
      const std::size_t at = begin & (ring_.size() - 1), to_end = ring_.size() - at;
      Head head{.kind = kSkip};
      if (to_end >= sizeof head) std::memcpy(&head, &ring_[at], sizeof head);
      if (head.kind != kSkip) {
        return Record{head, std::span<const std::byte>(ring_).subspan(at + sizeof head, head.bytes)};
      }
      head_.store(begin + to_end, std::memory_order_release);
    }
  }
  void release(const Record& record) noexcept {
    const std::size_t bytes = sizeof(Head) + record.head.bytes;
    const std::size_t begin = head_.load(std::memory_order_relaxed);
    head_.store(begin + (bytes + kAlign - 1) / kAlign * kAlign, std::memory_order_release);
  }

  std::size_t capacity() const noexcept { return ring_.size(); }
  std::size_t size() const noexcept {
    const std::size_t head = head_.load(std::memory_order_acquire);
    return tail_.load(std::memory_order_acquire) - head;
  }
  std::uint64_t high_water() const noexcept { return high_water_.value(); }

 private:
  static constexpr std::size_t kAlign = 8, kCacheLine = 64;
  static constexpr std::uint16_t kSkip = 65535;

  std::vector<std::byte> ring_;
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};
  Counter high_water_;
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};
};

}  // namespace risorius
