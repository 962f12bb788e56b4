// Which marker of our stream is which entry of a NatNet frame. A model definition lists marker sets and assets with the
// names of their markers; a frame has labelled markers with (model << 16 | member), and for each marker set its
// positions. A marker set has no id: which model it is, a frame tells by equal positions, or the order does.
// capture/README.md, "NatNet", has the rules. `place` allocates nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/wire/natnet_codec.h"

namespace risorius {

class NatnetMarkerMap {
 public:
  NatnetMarkerMap() = default;
  /// `markers`: "" all that have names, from where there are positions; "labelled" the same, labelled markers only;
  /// "set:NAME" those of one marker set or asset. kNoMarkers or kTooManyMarkers: the map is not changed.
  NatnetError build(std::span<const NatnetAsset> model, std::string_view markers);

  /// Unique, at most kMaxNameBytes bytes each. A name that occurs in two assets is preceded by its asset's.
  const std::vector<std::string>& names() const noexcept { return names_; }

  /// Sets the frame's count, states, reasons and positions (mm, LUF). Returns the number of positions that are not
  /// finite. A position of exactly (0, 0, 0) is missing: that is how trackers without an occluded bit say so.
  std::size_t place(const NatnetFrame& from, double mm_per_unit, const Axes& axes, MarkerFrame& frame) noexcept;

 private:
  static constexpr std::int32_t kNoModel = -1;
  struct Group {
    std::string name;
    std::vector<std::int32_t> member_ids;  ///< of each marker; empty: they count from first_member
    std::size_t count = 0;
    std::size_t first = 0;  ///< in names_
    std::int32_t model = kNoModel;
    std::uint16_t first_member = 1;
    bool wanted = false;
    bool is_labelled = false;  ///< its markers have come labelled
  };

  std::vector<Group> groups_of(std::span<const NatnetAsset> model, std::string_view wanted_set,
                               std::vector<std::vector<std::string>>& names) const;
  Group* group_of_model(std::int32_t model) noexcept;
  Group* group_of_name(std::string_view name) noexcept;
  std::size_t index_of(const Group& group, const NatnetLabelledMarker& marker) const noexcept;
  void learn(const NatnetFrame& from) noexcept;
  void bind_model(const NatnetFrame& from, std::uint16_t model, bool only_one) noexcept;
  Group* group_with_positions_of(const NatnetFrame& from, std::uint16_t model) noexcept;

  std::vector<std::string> names_;
  std::vector<Group> groups_;
  bool labelled_only_ = false;
};

}  // namespace risorius
