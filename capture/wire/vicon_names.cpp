#include "capture/wire/vicon_names.h"

#include <algorithm>
#include <utility>

#include "capture/frames.h"
#include "capture/wire/tracker_names.h"

namespace risorius {
namespace {

std::uint64_t key_of(std::uint32_t subject, std::uint32_t marker) noexcept {
  return std::uint64_t{subject} << 32 | marker;
}

}  // namespace

bool ViconNames::same(std::span<const std::span<const std::byte>> subjects) const noexcept {
  return std::equal(subjects.begin(), subjects.end(), described_.begin(), described_.end(),
                    [](const auto& a, const auto& b) { return std::equal(a.begin(), a.end(), b.begin(), b.end()); });
}

ViconNames::Outcome ViconNames::describe(std::span<const std::span<const std::byte>> subjects) {
  if (same(subjects)) return Outcome::kSame;
  std::vector<ViconSubject> decoded;
  for (const auto& body : subjects) {
    auto subject = decode_vicon_subject(body);
    if (!subject) return Outcome::kBad;
    if (wanted_.empty() ? !subject->markers.empty() : subject->name == wanted_) decoded.push_back(std::move(*subject));
  }
  described_.clear();
  for (const auto& body : subjects) described_.emplace_back(body.begin(), body.end());
  TrackerNames names;
  index_.clear();
  const bool several = wanted_.empty() && decoded.size() > 1;
  for (const ViconSubject& subject : decoded) {
    for (const ViconMarkerName& marker : subject.markers) {
      if (names.size() > kMaxMarkers) break;  // too many, however many there are
      // The first of a duplicate wins.
      if (!index_.emplace(key_of(subject.id, marker.id), names.size()).second) continue;
      names.add(several ? subject.name + ":" + marker.name : marker.name);
    }
  }
  names_ = names.take();
  return Outcome::kChanged;
}

void ViconNames::forget() noexcept {
  described_.clear();
  names_.clear();
  index_.clear();
}

std::optional<std::size_t> ViconNames::find(std::uint32_t subject, std::uint32_t marker) const noexcept {
  const auto found = index_.find(key_of(subject, marker));
  return found == index_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace risorius
