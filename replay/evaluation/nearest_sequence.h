// Whether a generated transition copies one that a model was trained on: its distance to the nearest of them.
#pragma once

#include <vector>

#include "generate/transition.h"

namespace risorius {

class SequenceIndex {
 public:
  /// All kept sequences and all asked for have `aus` columns.
  explicit SequenceIndex(Eigen::Index aus) : aus_(aus) {}

  /// Throws std::invalid_argument for another width or no rows.
  void add(const AuMatrix& sequence);
  std::size_t size() const noexcept { return sequences_.size(); }
  /// Root mean square over AUs and 32 moments spread evenly over each duration; infinity if nothing was added.
  double nearest_rms(const AuMatrix& sequence) const;

 private:
  AuMatrix spread(const AuMatrix& sequence) const;

  Eigen::Index aus_;
  std::vector<AuMatrix> sequences_;  ///< 32 x aus each
};

}  // namespace risorius
