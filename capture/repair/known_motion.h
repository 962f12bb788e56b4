// What somebody who knows the face says of how its markers move, such as a rig: where they rest and how each movement
// displaces them. Handed to repair as plain vectors, since capture/ knows no rigs.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace risorius {

struct KnownMotion {
  std::vector<std::string> marker_names;   ///< M, unique
  Eigen::Matrix3Xd rest_mm;                ///< 3 x M, in axes of its own
  std::vector<Eigen::Matrix3Xd> modes_mm;  ///< displacements at full strength, 3 x M each
};

/// The same for the markers of a set, turned into the axes in which that set is seen as soon as enough of them were.
/// A shape that does not fit what is seen (another face's, or mirrored) is not believed; a few false tracks do not
/// matter.
class KnownModes {
 public:
  /// Allocates. `known` may be null: nothing is known.
  void use(std::shared_ptr<const KnownMotion> known, const std::vector<std::string>& names);
  /// Another take: other axes.
  void reset() noexcept;

  /// Nothing is known until use() is called again.
  void forget() noexcept { known_.reset(), reset(); }

  /// Where marker i was seen; of one that was seen before, only while the axes are not found.
  void see(std::size_t i, const Eigen::Vector3d& position_mm) noexcept;
  /// Finds the axes, if they are not found and enough markers were seen.
  void align() noexcept;

  /// Enough of the markers that are known were seen, and they do not fit.
  bool refused() const noexcept { return is_refused_; }
  bool aligned() const noexcept { return is_aligned_; }
  bool knows(std::size_t i) const noexcept { return is_aligned_ && known_ && is_known_[i] != 0; }
  Eigen::Index count() const noexcept { return modes_mm_.rows(); }
  /// What each mode does to marker i, mm: modes x 3. The marker is known.
  auto of(std::size_t i) const noexcept { return modes_mm_.middleCols<3>(static_cast<Eigen::Index>(3 * i)); }

 private:
  std::shared_ptr<const KnownMotion> known_;
  std::vector<int> index_;  ///< in known_, by marker of the set
  std::vector<std::uint8_t> is_known_;
  std::vector<Eigen::Vector3d> rest_mm_, seen_mm_;
  std::vector<double> weight_;               ///< 1: known and seen
  std::vector<double> trust_, distance_mm_;  ///< in the alignment
  Eigen::MatrixXd modes_mm_;                 ///< modes x 3 markers of the set
  bool is_aligned_ = false, is_refused_ = false;
};

}  // namespace risorius
