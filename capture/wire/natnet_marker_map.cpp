#include "capture/wire/natnet_marker_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/plausible_position.h"
#include "capture/wire/tracker_names.h"

namespace risorius {
namespace {

// Trackers list a set of this name that repeats all markers of the others.
bool is_the_set_of_all(const NatnetAsset& asset) {
  return asset.kind == NatnetAsset::Kind::kMarkerSet && (asset.name == "all" || asset.name == "All");
}

constexpr std::string_view kSetPrefix = "set:";

void place_one(MarkerFrame& frame, std::size_t i, const std::array<float, 3>& p, double mm_per_unit, const Axes& axes,
               std::size_t& not_finite) noexcept {
  if (frame.state[i] == MarkerState::kMeasured || (p[0] == 0 && p[1] == 0 && p[2] == 0)) return;
  // Rounded to float once.
  const auto mm = [mm_per_unit](float value) { return static_cast<float>(mm_per_unit * static_cast<double>(value)); };
  const float x = mm(p[0]), y = mm(p[1]), z = mm(p[2]);
  if (!is_plausible_position(x, y, z)) {
    frame.reason[i] = RejectReason::kNotFinite;
    ++not_finite;
    return;
  }
  frame.state[i] = MarkerState::kMeasured;
  frame.reason[i] = RejectReason::kNone;
  frame.position_mm[i] = axes.to_world(x, y, z);
}

}  // namespace

std::vector<NatnetMarkerMap::Group> NatnetMarkerMap::groups_of(std::span<const NatnetAsset> model,
                                                               std::string_view wanted_set,
                                                               std::vector<std::vector<std::string>>& names) const {
  std::vector<Group> groups;
  const bool has_others = std::any_of(model.begin(), model.end(), [](const NatnetAsset& asset) {
    return !is_the_set_of_all(asset) && !asset.marker_names.empty();
  });
  for (const NatnetAsset& asset : model) {
    const auto same_name =
        std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.name == asset.name; });
    if (same_name != groups.end()) {
      // A rigid body or asset is listed as a marker set too: the one has the names, the other the id.
      if (asset.id) same_name->model = *asset.id;
      if (asset.marker_ids.size() == same_name->count) same_name->member_ids = asset.marker_ids;
      continue;
    }
    const bool wanted = wanted_set.empty() ? !(has_others && is_the_set_of_all(asset)) : asset.name == wanted_set;
    if (!wanted && is_the_set_of_all(asset)) continue;
    groups.push_back({.name = asset.name,
                      .member_ids = asset.marker_ids,
                      .count = asset.marker_names.size(),
                      .model = asset.id.value_or(kNoModel),
                      .wanted = wanted && !asset.marker_names.empty()});
    names.push_back(asset.marker_names);
  }
  return groups;
}

NatnetError NatnetMarkerMap::build(std::span<const NatnetAsset> model, std::string_view markers) {
  const std::string_view wanted_set =
      markers.starts_with(kSetPrefix) ? markers.substr(kSetPrefix.size()) : std::string_view();
  std::vector<std::vector<std::string>> names_of;
  std::vector<Group> groups = groups_of(model, wanted_set, names_of);
  TrackerNames names;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!groups[g].wanted) continue;
    groups[g].first = names.size();
    names.begin_group();
    for (std::size_t m = 0; m < groups[g].count; ++m) {
      if (names.size() == kMaxMarkers) return NatnetError::kTooManyMarkers;
      names.add(names_of[g][m], groups[g].name);
    }
  }
  if (names.size() == 0) return NatnetError::kNoMarkers;
  names_ = names.take();
  groups_ = std::move(groups);
  labelled_only_ = markers == "labelled";
  return NatnetError::kNone;
}

NatnetMarkerMap::Group* NatnetMarkerMap::group_of_model(std::int32_t model) noexcept {
  for (Group& group : groups_) {
    if (group.model == model) return &group;
  }
  return nullptr;
}

NatnetMarkerMap::Group* NatnetMarkerMap::group_of_name(std::string_view name) noexcept {
  for (Group& group : groups_) {
    if (group.name == name) return &group;
  }
  return nullptr;
}

/// In names_; kMaxMarkers if the marker is none of the group's.
std::size_t NatnetMarkerMap::index_of(const Group& group, const NatnetLabelledMarker& marker) const noexcept {
  for (std::size_t i = 0; i < group.member_ids.size(); ++i) {
    if (group.member_ids[i] == marker.id || group.member_ids[i] == marker.member()) return group.first + i;
  }
  if (!group.member_ids.empty() || marker.member() < group.first_member) return kMaxMarkers;
  const std::size_t member = marker.member() - group.first_member;
  return member < group.count ? group.first + member : kMaxMarkers;
}

/// The one marker set without a model whose positions in this frame are those of the model's labelled markers.
NatnetMarkerMap::Group* NatnetMarkerMap::group_with_positions_of(const NatnetFrame& from,
                                                                 std::uint16_t model) noexcept {
  Group* best = nullptr;
  std::size_t most = 0;
  bool unique = true;
  for (auto rest = from.marker_sets; !rest.empty();) {
    const NatnetMarkerSetView set = take_marker_set(rest);
    Group* group = group_of_name(set.name);
    if (group == nullptr || group->model != kNoModel) continue;
    std::size_t equal = 0;
    for (std::size_t i = 0; i < from.labelled_count; ++i) {
      const NatnetLabelledMarker marker = labelled_marker(from, i);
      if (marker.model() != model || !marker.measured()) continue;
      const std::array<float, 3> p{marker.x, marker.y, marker.z};
      const std::size_t member = marker.member();
      const bool one_based = member >= 1 && member - 1 < set.count() && set.position(member - 1) == p;
      equal += one_based || (member < set.count() && set.position(member) == p) ? 1 : 0;
    }
    if (equal == 0 || equal < most) continue;
    unique = equal > most;
    most = equal;
    best = group;
  }
  return unique ? best : nullptr;
}

void NatnetMarkerMap::bind_model(const NatnetFrame& from, std::uint16_t model, bool only_one) noexcept {
  Group* group = group_with_positions_of(from, model);
  // Model 0 is most often that of no model at all: what positions could tell, nothing else may.
  if (group == nullptr && model == 0 && from.marker_set_count > 0) return;
  if (group == nullptr) {
    const auto without = [](const Group& g) { return g.model == kNoModel && g.count > 0; };
    const auto first = std::find_if(groups_.begin(), groups_.end(), without);
    if (first == groups_.end()) return;
    const bool one_left = std::find_if(first + 1, groups_.end(), without) == groups_.end();
    if (one_left && only_one) {
      group = &*first;
    } else if (model >= 1 && model <= groups_.size() && without(groups_[model - 1u])) {
      group = &groups_[model - 1u];
    }
  }
  if (group != nullptr) group->model = model;
}

/// Finds the marker sets of models that have none yet, and whether members count from 0 or from 1.
void NatnetMarkerMap::learn(const NatnetFrame& from) noexcept {
  std::array<std::uint16_t, 16> unknown{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < from.labelled_count; ++i) {
    const NatnetLabelledMarker marker = labelled_marker(from, i);
    if ((marker.params & NatnetLabelledMarker::kUnlabelled) != 0) continue;
    Group* group = group_of_model(marker.model());
    if (group != nullptr) {
      if (marker.member() == 0 && group->member_ids.empty()) group->first_member = 0;
      continue;
    }
    const auto end = unknown.begin() + static_cast<std::ptrdiff_t>(count);
    if (count < unknown.size() && std::find(unknown.begin(), end, marker.model()) == end)
      unknown[count++] = marker.model();
  }
  if (count == 0) return;
  std::sort(unknown.begin(), unknown.begin() + static_cast<std::ptrdiff_t>(count));
  // Model 0 is that of markers without a model; only a tracker that numbers nothing else may mean something by it.
  const std::size_t begin = unknown[0] == 0 && count > 1 ? 1 : 0;
  for (std::size_t i = begin; i < count; ++i) {
    bind_model(from, unknown[i], count - begin == 1);
    if (Group* group = group_of_model(unknown[i]); group != nullptr && group->member_ids.empty()) {
      for (std::size_t m = 0; m < from.labelled_count; ++m) {
        const NatnetLabelledMarker marker = labelled_marker(from, m);
        if (marker.model() == unknown[i] && marker.member() == 0) group->first_member = 0;
      }
    }
  }
}

std::size_t NatnetMarkerMap::place(const NatnetFrame& from, double mm_per_unit, const Axes& axes,
                                   MarkerFrame& frame) noexcept {
  frame.count = static_cast<std::uint32_t>(names_.size());
  for (std::size_t i = 0; i < names_.size(); ++i) {
    frame.state[i] = MarkerState::kMissing;
    frame.reason[i] = RejectReason::kNone;
    frame.position_mm[i] = {};
  }
  learn(from);
  std::size_t not_finite = 0;
  for (std::size_t i = 0; i < from.labelled_count; ++i) {
    const NatnetLabelledMarker marker = labelled_marker(from, i);
    if ((marker.params & NatnetLabelledMarker::kUnlabelled) != 0) continue;
    Group* group = group_of_model(marker.model());
    if (group == nullptr || !group->wanted) continue;
    const std::size_t index = index_of(*group, marker);
    if (index == kMaxMarkers) continue;
    group->is_labelled = true;
    if (marker.measured()) place_one(frame, index, {marker.x, marker.y, marker.z}, mm_per_unit, axes, not_finite);
  }
  if (labelled_only_) return not_finite;
  for (auto rest = from.marker_sets; !rest.empty();) {
    const NatnetMarkerSetView set = take_marker_set(rest);
    const Group* group = group_of_name(set.name);
    if (group == nullptr || !group->wanted || group->is_labelled) continue;
    for (std::size_t i = 0; i < std::min(set.count(), group->count); ++i)
      place_one(frame, group->first + i, set.position(i), mm_per_unit, axes, not_finite);
  }
  return not_finite;
}

}  // namespace risorius
