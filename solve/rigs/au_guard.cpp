#include "solve/rigs/au_guard.h"

#include <fmt/format.h>
#include <stdexcept>
#include <utility>

#include "solve/rigs/basis_update.h"

namespace risorius {
namespace {

constexpr double kReachShare = 0.1;   // of the peak: below, an AU does not reach a marker
constexpr double kAlikeCosine = 0.8;  // AUs that were alike from the start may stay so
constexpr int kBisections = 12;

}  // namespace

double cosine_of(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  const double norms = a.norm() * b.norm();
  return norms > 0 ? a.cwiseProduct(b).sum() / norms : 0;
}

AuGuard::AuGuard(Rig start, const AuGuardLimits& limits) : start_(std::move(start)), limits_(limits) {
  const auto require = [](bool good, const char* name, double value, const char* range) {
    if (!good) throw std::invalid_argument(fmt::format("AuGuardLimits.{} = {}: must be {}", name, value, range));
  };
  require(limits.least_cosine > 0 && limits.least_cosine < 1, "least_cosine", limits.least_cosine, "between 0 and 1");
  require(limits.least_gain > 0 && limits.least_gain <= 1, "least_gain", limits.least_gain, "above 0, at most 1");
  require(limits.largest_gain >= 1, "largest_gain", limits.largest_gain, "at least 1");
  require(limits.largest_far_share >= 0 && limits.largest_far_share < 1, "largest_far_share", limits.largest_far_share,
          "0 to below 1");
  const auto count = static_cast<Eigen::Index>(start_.au_count());
  start_cosine_.resize(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const RigAu& au = start_.aus[static_cast<std::size_t>(i)];
    const double peak_mm = au.displacement_mm.colwise().norm().maxCoeff();
    is_far_.emplace_back((reach_of(start_, au, limits.reach_mm).array() < kReachShare * peak_mm).cast<double>());
    for (Eigen::Index j = 0; j < count; ++j) {
      start_cosine_(i, j) = cosine_of(au.displacement_mm, start_.aus[static_cast<std::size_t>(j)].displacement_mm);
    }
  }
}

bool AuGuard::allows(std::size_t au, const Eigen::Matrix3Xd& field_mm) const {
  const Eigen::Matrix3Xd& start = start_.aus[au].displacement_mm;
  const double own = cosine_of(field_mm, start);
  const double gain = field_mm.norm() / start.norm();
  if (own < limits_.least_cosine || gain < limits_.least_gain || gain > limits_.largest_gain) return false;
  const double far = field_mm.colwise().squaredNorm().dot(is_far_[au].transpose());
  const double far_at_start = start.colwise().squaredNorm().dot(is_far_[au].transpose()) / start.squaredNorm();
  if (far > (limits_.largest_far_share + far_at_start) * field_mm.squaredNorm()) return false;
  for (std::size_t other = 0; other < start_.au_count(); ++other) {
    if (other == au) continue;
    if (start_cosine_(static_cast<Eigen::Index>(au), static_cast<Eigen::Index>(other)) > kAlikeCosine) continue;
    if (cosine_of(field_mm, start_.aus[other].displacement_mm) > own) return false;
  }
  return true;
}

bool AuGuard::hold_back(std::size_t au, Eigen::Matrix3Xd& field_mm) const {
  if (allows(au, field_mm)) return false;
  const Eigen::Matrix3Xd& start = start_.aus[au].displacement_mm;
  const Eigen::Matrix3Xd way = field_mm - start;
  double allowed = 0, refused = 1;
  for (int i = 0; i < kBisections; ++i) {
    const double share = 0.5 * (allowed + refused);
    (allows(au, start + share * way) ? allowed : refused) = share;
  }
  field_mm = start + allowed * way;
  return true;
}

}  // namespace risorius
