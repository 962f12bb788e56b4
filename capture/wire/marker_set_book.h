// The marker sets that a native stream has described: puts the parts of a set together, keeps every distinct set for
// good (frames downstream point at them), and knows which sets are in force in the session being received. A set of
// another session begins that session and forgets which sets were in force. Allocates for a new set only.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "capture/marker_set.h"
#include "capture/wire/marker_codec.h"

namespace risorius {

class MarkerSetBook {
 public:
  static constexpr std::size_t kMaxSets = 64;        ///< in force at once
  static constexpr std::size_t kMaxSetsEver = 4096;  ///< distinct, of all sessions: a sender that states the rate that
                                                     ///< it measured describes another set each time it starts

  /// What became of the datagrams that the book held and was handed.
  struct Outcome {
    DecodeError error = DecodeError::kNone;
    std::uint32_t used = 0, dropped = 0, refused = 0;
    bool new_session = false;
    const MarkerSet* changed = nullptr;  ///< now in force and was not before; valid for the book's life
  };

  /// Overrides of what senders state about their numbers.
  MarkerSetBook(std::optional<double> mm_per_unit, std::optional<Axes> axes);
  MarkerSetBook(const MarkerSetBook&) = delete;
  MarkerSetBook& operator=(const MarkerSetBook&) = delete;

  Outcome add(const MarkerSetPart& part) noexcept;
  /// The set in force under this id, or null.
  const MarkerSet* find(std::uint32_t set_id) const noexcept;
  /// Empty before the first complete set.
  std::optional<std::uint32_t> session() const noexcept { return session_; }
  /// Datagrams of an incomplete set.
  std::uint32_t held() const noexcept { return datagrams_; }
  /// Gives the incomplete set up; returns its datagrams.
  std::uint32_t drop_incomplete() noexcept;
  /// Ends the force of every set but the one in force under this id.
  void keep_only(std::uint32_t set_id) noexcept;

 private:
  struct Name {
    std::uint8_t size = 0;
    std::array<char, kMaxNameBytes> bytes{};
    std::string_view view() const noexcept { return {bytes.data(), size}; }
  };

  bool continues(const MarkerSetPart& part) const noexcept;
  bool repeats_names(const MarkerSetPart& part) const noexcept;
  void take_names(const MarkerSetPart& part) noexcept;
  bool equals_incomplete(const MarkerSet& set) const noexcept;
  const MarkerSet* store(DecodeError& error);
  void complete(Outcome& outcome) noexcept;

  std::optional<double> mm_per_unit_;
  std::optional<Axes> axes_;

  MarkerSetPart head_;  ///< of the incomplete set; its spans are not used
  std::vector<Name> names_;
  std::bitset<kMaxMarkers> present_;
  std::uint32_t datagrams_ = 0;

  std::deque<MarkerSet> sets_;  ///< they never move
  std::optional<std::uint32_t> session_;
  std::vector<const MarkerSet*> in_force_;
};

}  // namespace risorius
