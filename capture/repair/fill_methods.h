// Every way to fill the gaps of a take, by name and behind one signature: the defaults and the methods that they are
// measured against.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"

namespace risorius {

struct FillMethodEntry {
  std::string_view name;
  bool is_causal;         ///< no frame depends on a later one
  bool states_deviation;  ///< its standard deviations mean something
  std::string_view meaning;
  /// Fills missing and rejected markers; gaps longer than max_gap_ns stay missing (causal: from there on).
  void (*fill)(std::vector<MarkerFrame>& frames, const MarkerSet& set, std::int64_t max_gap_ns);
};

/// The offline default first, then the causal one, then the baselines.
std::span<const FillMethodEntry> fill_methods() noexcept;
/// Throws UserError with the names that there are.
const FillMethodEntry& fill_method_named(std::string_view name);

}  // namespace risorius
