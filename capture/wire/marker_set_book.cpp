#include "capture/wire/marker_set_book.h"

#include <algorithm>
#include <utility>

namespace risorius {

MarkerSetBook::MarkerSetBook(std::optional<double> mm_per_unit, std::optional<Axes> axes)
    : mm_per_unit_(mm_per_unit), axes_(axes), names_(kMaxMarkers) {
  in_force_.reserve(kMaxSets);
}

const MarkerSet* MarkerSetBook::find(std::uint32_t set_id) const noexcept {
  const auto found =
      std::find_if(in_force_.begin(), in_force_.end(), [=](const auto* set) { return set->id == set_id; });
  return found == in_force_.end() ? nullptr : *found;
}

std::uint32_t MarkerSetBook::drop_incomplete() noexcept {
  present_.reset();
  return std::exchange(datagrams_, 0);
}

void MarkerSetBook::keep_only(std::uint32_t set_id) noexcept {
  std::erase_if(in_force_, [=](const auto* set) { return set->id != set_id; });
}

bool MarkerSetBook::continues(const MarkerSetPart& part) const noexcept {
  return datagrams_ > 0 && part.session == head_.session && part.set_id == head_.set_id &&
         part.revision == head_.revision && part.rate_hz == head_.rate_hz && part.mm_per_unit == head_.mm_per_unit &&
         part.axes == head_.axes && part.count == head_.count;
}

bool MarkerSetBook::repeats_names(const MarkerSetPart& part) const noexcept {
  auto rest = part.names;
  for (std::size_t i = part.first; i < part.first + part.part_count; ++i) {
    if (take_name(rest) != names_[i].view()) return false;
  }
  return true;
}

void MarkerSetBook::take_names(const MarkerSetPart& part) noexcept {
  auto rest = part.names;
  for (std::size_t i = part.first; i < part.first + part.part_count; ++i) {
    const std::string_view name = take_name(rest);
    names_[i].size = static_cast<std::uint8_t>(name.size());
    std::copy(name.begin(), name.end(), names_[i].bytes.begin());
    present_.set(i);
  }
  ++datagrams_;
}

MarkerSetBook::Outcome MarkerSetBook::add(const MarkerSetPart& part) noexcept {
  Outcome outcome;
  if (continues(part)) {
    std::size_t overlap = 0;
    for (std::size_t i = part.first; i < part.first + part.part_count; ++i) overlap += present_[i] ? 1 : 0;
    if (overlap == part.part_count && repeats_names(part)) {
      outcome.dropped = 1;
      return outcome;
    }
    if (overlap != 0) {
      outcome.error = DecodeError::kInconsistentPart;
      outcome.dropped = drop_incomplete();
      outcome.refused = 1;
      return outcome;
    }
  } else {
    outcome.dropped = drop_incomplete();
    head_ = part;
    head_.names = {};
  }
  take_names(part);
  if (present_.count() == head_.count) complete(outcome);
  return outcome;
}

bool MarkerSetBook::equals_incomplete(const MarkerSet& set) const noexcept {
  if (set.id != head_.set_id || set.names.size() != head_.count || set.rate_hz != head_.rate_hz ||
      set.mm_per_unit != mm_per_unit_.value_or(head_.mm_per_unit) || set.axes != axes_.value_or(head_.axes)) {
    return false;
  }
  return std::equal(set.names.begin(), set.names.end(), names_.begin(),
                    [](const std::string& a, const Name& b) { return a == b.view(); });
}

const MarkerSet* MarkerSetBook::store(DecodeError& error) {
  const bool is_one_too_many =
      session_ == head_.session && in_force_.size() == kMaxSets && find(head_.set_id) == nullptr;
  const auto known =
      std::find_if(sets_.begin(), sets_.end(), [this](const auto& set) { return equals_incomplete(set); });
  if (known != sets_.end() && !is_one_too_many) return &*known;
  if (is_one_too_many || sets_.size() == kMaxSetsEver) {
    error = DecodeError::kTooManySets;
    return nullptr;
  }
  MarkerSet set{.id = head_.set_id,
                .names = {},
                .rate_hz = head_.rate_hz,
                .mm_per_unit = mm_per_unit_.value_or(head_.mm_per_unit),
                .axes = axes_.value_or(head_.axes)};
  for (std::size_t i = 0; i < head_.count; ++i) set.names.emplace_back(names_[i].view());
  if (!problems_of(set).empty()) {
    error = DecodeError::kBadSet;
    return nullptr;
  }
  return &sets_.emplace_back(std::move(set));
}

void MarkerSetBook::complete(Outcome& outcome) noexcept {
  const MarkerSet* set = store(outcome.error);
  const std::uint32_t datagrams = drop_incomplete();
  if (set == nullptr) {
    outcome.refused = datagrams;
    return;
  }
  outcome.used = datagrams;
  if (session_ != head_.session) {
    session_ = head_.session;
    in_force_.clear();
    outcome.new_session = true;
  }
  const auto before =
      std::find_if(in_force_.begin(), in_force_.end(), [set](const auto* other) { return other->id == set->id; });
  if (before != in_force_.end() && *before == set) return;
  if (before != in_force_.end()) {
    *before = set;
  } else {
    in_force_.push_back(set);
  }
  outcome.changed = set;
}

}  // namespace risorius
