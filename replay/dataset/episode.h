// One action of one AU in a take: when it began, was strongest and ended, and how FACS codes it.
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>

#include "replay/takes/au_column.h"

namespace risorius {

enum class EpisodeEnd : std::uint8_t {
  kOffset,       ///< the intensity went down
  kNotObserved,  ///< the AU was not seen for too long; the episode may have gone on
  kEndOfTake,    ///< the take ended within it
};

struct EpisodePoint {
  std::uint64_t frame = 0;  ///< sequence
  std::int64_t time_ns = 0;
};

struct Episode {
  std::uint32_t column = 0;    ///< index into the AU names
  std::uint8_t au_number = 0;  ///< of FACS; 0 for a column that is no AU
  ColumnSide side = ColumnSide::kNone;
  EpisodePoint onset;   ///< first frame, inclusive
  EpisodePoint apex;    ///< first frame of the peak
  EpisodePoint offset;  ///< last frame in which it was seen, inclusive
  double peak = 0;      ///< intensity as solved, 0 to the rig's bound
  char letter = 'A';    ///< A to E
  EpisodeEnd closed_by = EpisodeEnd::kOffset;
};

static_assert(std::is_trivially_copyable_v<Episode>);

/// "12C", "L14B"; a column that is no AU: its name, a colon and the letter.
std::string facs_code(const Episode& episode, const std::string& column_name);

/// "offset", "not observed", "end of take"
const char* name_of(EpisodeEnd end) noexcept;

}  // namespace risorius
