// Another neutral for a rig: markers are put on again from session to session, and a take may have its own.
#pragma once

#include <string>

#include "replay/pipeline/neutral.h"
#include "replay/takes/take.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// A stretch of a take: "TAKE:FROM-TO", "TAKE" for all of it, or "TAKE:auto" and "TAKE:FROM-TO:auto" for the best of
/// neutral_candidates.h in it.
struct NeutralPlace {
  TakeRange range;
  bool is_auto = false;
};
NeutralPlace parse_neutral_place(const std::string& text);

/// Throws UserError, also where the face moves too much to be a neutral.
struct ChosenNeutral {
  Neutral neutral;
  std::string place;  ///< "TAKE:FROM-TO"
};
ChosenNeutral read_neutral(TakeReader& take, const NeutralPlace& place);

/// More motion than this (rms per marker) is doubted, and no neutral.
inline constexpr double kDoubtedMotionMm = 1, kLargestMotionMm = 4;

struct RenewedRig {
  Rig rig;
  std::string place;        ///< that the neutral is from
  double moved_rms_mm = 0;  ///< of the markers against the old neutral, the head's motion taken out
  double moved_most_mm = 0;
  std::string moved_most_marker;
};

/// Markers are put on again to within a few mm; a face that lies farther from the last neutral is doubted.
inline constexpr double kDoubtedShiftMm = 3;
/// One sentence, or nothing.
std::string doubt_of(const RenewedRig& renewed);

/// The rig with the neutral's positions, laid on the old ones; markers that the neutral does not have stay. Throws
/// UserError: less than half of the markers, or a face that cannot be this rig's (farther than 20 mm).
RenewedRig with_neutral(const Rig& rig, const Neutral& neutral, const std::string& place);

}  // namespace risorius
