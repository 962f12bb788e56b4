// The marker set of a recorded stream, for those who solve or send its Ticks: where the Tick of a set lay in a damaged
// part of the file, the next repeat of it (SessionTopic::kSets) stands in for it; all other repeats say nothing new.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "replay/session/session_format.h"
#include "replay/session/tick_codec.h"

namespace risorius {

class KnownSet {
 public:
  /// Of a message of kTicks or kSets, in the file's order: whether it is to be taken as a Tick.
  bool is_news(SessionTopic topic, std::span<const std::byte> tick) {
    if (topic == SessionTopic::kTicks && !is_marker_set_tick(tick)) return true;
    const bool same = std::ranges::equal(tick, set_);
    if (!same) set_.assign(tick.begin(), tick.end());
    return topic == SessionTopic::kTicks || !same;
  }

 private:
  std::vector<std::byte> set_;
};

}  // namespace risorius
