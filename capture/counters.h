// Counter registers: one writer, any number of readers, no lock. And the ledger that every stage keeps.
#pragma once

#include <atomic>
#include <cstdint>

namespace risorius {

/// A register of one writing thread that any other thread may read at any time.
class Counter {
 public:
  void add(std::uint64_t n = 1) noexcept { value_.store(value() + n, std::memory_order_relaxed); }
  void set(std::uint64_t n) noexcept { value_.store(n, std::memory_order_relaxed); }
  void raise_to(std::uint64_t n) noexcept {
    if (n > value()) set(n);
  }
  std::uint64_t value() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// What became of the frames (or datagrams) that a stage was handed. No loss is silent:
/// received = emitted + dropped + refused + held, and held = 0 after a flush.
struct StageLedger {
  Counter received;  ///< accepted by push
  Counter emitted;   ///< handed on by pop
  Counter dropped;   ///< good but given up: too late, no room
  Counter refused;   ///< not usable: malformed, unknown set, does not fit
  Counter held;      ///< inside the stage now

  bool balanced() const noexcept {
    return received.value() == emitted.value() + dropped.value() + refused.value() + held.value();
  }
};

}  // namespace risorius
