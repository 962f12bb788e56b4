#include "capture/wire/tracker_names.h"

#include <fmt/format.h>

#include "capture/marker_set.h"
#include "capture/utf8.h"

namespace risorius {
namespace {

/// As many whole characters of clean UTF-8 as fit.
std::string cut(std::string_view text, std::size_t most_bytes) {
  std::size_t bytes = 0;
  while (bytes < text.size()) {
    const std::size_t next = utf8_length(text.substr(bytes));
    if (next == 0 || bytes + next > most_bytes) break;
    bytes += next;
  }
  return std::string(text.substr(0, bytes));
}

}  // namespace

void TrackerNames::add(std::string_view own_bytes, std::string_view group) {
  ++place_;
  const std::string own = own_bytes.empty() ? std::to_string(place_) : utf8_of(own_bytes);
  std::string name = cut(own, kMaxNameBytes);
  if (!group.empty() && used_.contains(name)) name = cut(fmt::format("{}:{}", utf8_of(group), own), kMaxNameBytes);
  for (std::size_t n = 2; !used_.insert(name).second; ++n) {
    const std::string number = fmt::format("#{}", n);
    name = cut(own, kMaxNameBytes - number.size()) + number;
  }
  names_.push_back(std::move(name));
}

}  // namespace risorius
