// What a bad network does to each datagram of a stream, decided from a seed: a pure function of the seed and of the
// datagrams before, without sockets or clocks. Every kind of fault draws from a stream of random numbers of its own,
// and draws for every datagram: turning one fault on or off leaves what the others do as it was.
//
//   datagram -> lost? (each by chance, or all during an outage) -> one copy or two -> each: a bit flipped?
//            -> held back until some more have passed? -> delayed
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "replay/performer/random.h"

namespace risorius {

struct ChaosOptions {
  double loss = 0;                                 ///< probability, 0 to 1, as the other three
  double reorder = 0;                              ///< of each copy: held back until 1 to kMostHeldBack more have come
  double duplicate = 0;                            ///< forwarded twice
  double corrupt = 0;                              ///< of each copy: one of its bits is turned
  std::int64_t burst_ns = 0;                       ///< length of an outage, in which all is lost; 0: none
  std::int64_t burst_interval_ns = 5'000'000'000;  ///< mean time from an outage's end to the next, exponential; > 0
  std::int64_t delay_ns = 0;                       ///< of each copy, >= 0
  std::int64_t jitter_ns = 0;                      ///< on top, uniform from 0, >= 0: copies can overtake each other
  std::uint64_t seed = 1;
};

enum class ChaosFate : std::uint8_t { kForwarded, kLost, kLostInBurst };

struct ChaosCopy {
  std::optional<std::size_t> turned_bit;  ///< bit n % 8 of byte n / 8
  std::uint32_t held_back = 0;            ///< datagrams that are to come before this copy goes on
  std::int64_t delay_ns = 0;
};

struct ChaosDecision {
  ChaosFate fate = ChaosFate::kForwarded;
  std::size_t copies = 0;  ///< 1 or 2; 0 if it is lost
  std::array<ChaosCopy, 2> copy;
};

class ChaosPlan {
 public:
  static constexpr std::size_t kMostHeldBack = 3;

  /// Throws UserError naming the option, its value and range.
  explicit ChaosPlan(const ChaosOptions& options);

  /// For the next datagram, of `bytes`, which came at `time_ns` (never falling; the first one begins the time).
  ChaosDecision decide(std::size_t bytes, std::int64_t time_ns) noexcept;
  /// Outages that have begun.
  std::uint64_t bursts() const noexcept { return bursts_; }

 private:
  bool in_burst(std::int64_t time_ns) noexcept;

  ChaosOptions options_;
  Random loss_, burst_, duplicate_, corrupt_, reorder_, jitter_;
  std::optional<std::int64_t> burst_begin_ns_;  ///< of the present outage, or of the next
  std::uint64_t bursts_ = 0;
  bool burst_counted_ = false;
};

}  // namespace risorius
