// The muscles of the face as a table, and the skin's motion under each action unit: what a muscle carries along, from
// its insertion in the skin towards its origin in the bone; sphincters that gather and push; lids that slide on the
// eyeball; the jaw on its hinge. Millimetres in the frame of the built-in head at rest. Written for the left side; the
// right side is its mirror image.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solve/faces/builtin_head_mesh.h"

namespace risorius {

enum class MuscleKind : std::uint8_t {
  kLinear,     ///< a strand: full motion at the insertion only
  kSheet,      ///< a sheet: full motion over the inner third of its region
  kSphincter,  ///< a ring about the insertion: draws the skin in, and pushes it out of the face
  kRollIn,     ///< the red of the lips turns in over the teeth
  kUpperLid,   ///< the upper lid's edge slides on the eyeball: + opens, - closes, as a share of the way
  kLowerLid,   ///< the lower lid's edge, + up
  kJawTurn,    ///< the jaw turns about the condyles and slides forward on them
  kJawShift,   ///< the jaw moves as a whole, from the insertion towards the origin
};

/// The skin that moves with a muscle although its neighbour across the mouth does not.
enum class LipShare : std::uint8_t { kBoth, kUpper, kLower };

struct Muscle {
  std::string_view name;
  std::string_view au;  ///< without side
  bool is_paired;       ///< one on each side; else in the middle, for both sides at once
  MuscleKind kind;
  Eigen::Vector3d origin_mm;     ///< of the pull: fixed to bone, or where skin is drawn to
  Eigen::Vector3d insertion_mm;  ///< in the skin; the middle of the region carried along
  double along_mm, across_mm;    ///< radii of the region, along the pull and across it (sphincter: x and y)
  double amplitude_mm;           ///< travel at the insertion at intensity 1 (sphincter: of the mouth's corner inwards;
                                 ///< lids: mm of the edge's middle; jaw turn: of the chin)
  double outward_mm = 0;         ///< in z besides, at the insertion: skin that piles up, or lips that come forward
  LipShare lips = LipShare::kBoth;
};

/// Sources of anatomy and amplitudes: see solve/README.md, "The built-in face".
std::span<const Muscle> facial_muscles() noexcept;

/// One column of the face: an AU, of one side where FACS has sides.
struct AuColumn {
  std::string name;  ///< "AU12L"
  std::string_view au;
  char side = 0;  ///< 'L', 'R', or 0
  double upper_bound = 1.2;
};
std::vector<AuColumn> facial_au_columns();

/// Displacement (3 x V, mm) of a column at intensity 1.
Eigen::Matrix3Xd au_displacement_mm(const HeadMesh& mesh, const AuColumn& column);

}  // namespace risorius
