// How far the fills of a take can be believed, found out by rehearsing: every gap is moved to a few places where its
// marker is in truth seen, with the same others hidden, and filled there; what that gets wrong is seen. Learnt per
// octave of the gap's length, apart for gaps whose neighbours are hidden, too (FillTrust): which share of its way off
// the straight line the regression is given, and what its stated variance is worth.
#pragma once

#include <array>
#include <vector>

#include "capture/repair/fill_trust.h"
#include "capture/repair/head_take.h"
#include "capture/repair/take_regression.h"

namespace risorius {

class TakeRehearsal {
 public:
  /// Keeps references.
  TakeRehearsal(const HeadTake& take, const TakeRegression& regression) : take_(take), regression_(regression) {}

  /// Moves a gap to at most so many places.
  void practise(const Gap& gap, const GapChoice& choice, std::size_t places);
  /// After all gaps were practised.
  void conclude();
  /// What `fill` says of the gap, as far as it can be believed.
  void weigh(const Gap& gap, GapRegression::Fill& fill) const;

 private:
  static constexpr std::size_t kOctaves = 8;  ///< gaps of up to 1/60, 1/30 ... 64/30 s

  struct Rehearsed {
    std::size_t kind;
    Gap gap;
    GapRegression::Fill fill;
    double noise_mm2;
  };

  std::vector<std::size_t> places_for(const Gap& gap, std::size_t count) const;
  std::size_t kind_of(const Gap& gap) const;
  Eigen::Vector3d straight_mm(const Gap& gap, std::size_t frame) const;

  const HeadTake& take_;
  const TakeRegression& regression_;
  std::vector<Rehearsed> rehearsed_;
  std::array<FillTrust, 2 * kOctaves> trust_;
};

}  // namespace risorius
