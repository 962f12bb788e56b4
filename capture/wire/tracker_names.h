// Marker names of whatever a tracker calls its markers: clean UTF-8, not longer than a name may be, none of them twice.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

namespace risorius {

class TrackerNames {
 public:
  /// `own`: any bytes; "": its place in `group`, from 1 on. A name that is taken already becomes "GROUP:OWN", where
  /// there is a group, and else, or if that is taken too, "OWN#2" and so on.
  void add(std::string_view own, std::string_view group = {});
  /// The next names count their places from 1 again.
  void begin_group() noexcept { place_ = 0; }

  std::size_t size() const noexcept { return names_.size(); }
  std::vector<std::string> take() { return std::move(names_); }

 private:
  std::vector<std::string> names_;
  std::unordered_set<std::string> used_;
  std::size_t place_ = 0;
};

}  // namespace risorius
