#include "replay/performer/truth_model.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>

namespace risorius {
namespace {

constexpr std::uint64_t kShapeStream = 31, kCreepStream = 32;
constexpr double kFieldRadiusMm = 45;  // how far a smooth random field stays alike
constexpr int kFieldBumps = 12;
constexpr double kCreepTimeS = 20;
constexpr std::size_t kGradientNeighbours = 8;

void require(double value, const char* name, double most) {
  if (value >= 0 && value <= most) return;
  throw std::invalid_argument(fmt::format("PerturbOptions.{} = {}: must be 0 to {}", name, value, most));
}

Eigen::Vector3d draw_vector(Random& random) {
  Eigen::Vector3d v;
  for (double& coordinate : v) coordinate = random.gaussian();
  return v;
}

/// A smooth random field over the markers with a root mean square length of 1.
Eigen::Matrix3Xd smooth_field(const Eigen::Matrix3Xd& at_mm, Random& random) {
  Eigen::Matrix3Xd field = Eigen::Matrix3Xd::Zero(3, at_mm.cols());
  for (int bump = 0; bump < kFieldBumps; ++bump) {
    const auto centre = static_cast<Eigen::Index>(random.index(static_cast<std::size_t>(at_mm.cols())));
    const Eigen::Vector3d push = draw_vector(random);
    for (Eigen::Index m = 0; m < at_mm.cols(); ++m) {
      const double distance = (at_mm.col(m) - at_mm.col(centre)).norm() / kFieldRadiusMm;
      field.col(m) += std::exp(-0.5 * distance * distance) * push;
    }
  }
  const double rms = std::sqrt(field.squaredNorm() / static_cast<double>(at_mm.cols()));
  return rms > 0 ? Eigen::Matrix3Xd(field / rms) : field;
}

std::vector<Eigen::Index> neighbours_of(const Eigen::Matrix3Xd& at_mm, Eigen::Index m) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(at_mm.cols()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return (at_mm.col(a) - at_mm.col(m)).squaredNorm() < (at_mm.col(b) - at_mm.col(m)).squaredNorm();
  });
  order.resize(std::min(order.size(), kGradientNeighbours + 1));
  order.erase(order.begin());  // itself
  return order;
}

}  // namespace

TruthModel::TruthModel(const Rig& rig, const PerturbOptions& options, double rate_hz, std::uint64_t seed)
    : rig_(rig),
      slide_share_(options.slide_share),
      creep_mm_(options.creep_mm),
      creep_keep_(std::exp(-1 / (rate_hz * kCreepTimeS))),
      seed_(seed),
      creep_random_(seed, kCreepStream),
      creep_mm_now_(Eigen::Matrix3Xd::Zero(3, rig.neutral_mm.cols())) {
  require(options.identity_mm, "identity_mm", 20);
  require(options.basis_share, "basis_share", 0.5);
  require(options.placement_mm, "placement_mm", 10);
  require(options.slide_share, "slide_share", 0.5);
  require(options.creep_mm, "creep_mm", 5);
  Random random(seed, kShapeStream);
  if (options.identity_mm > 0) change_identity(options, random);
  if (options.placement_mm > 0) place_markers(options, random);
  if (options.basis_share > 0) change_basis(options, random);
  if (options.slide_share > 0) {
    for (const RigAu& au : rig_.aus) {
      // Across the way that the marker goes, the same side for neighbours.
      const Eigen::Matrix3Xd across = smooth_field(rig_.neutral_mm, random);
      Eigen::Matrix3Xd& bend = bend_mm_.emplace_back(3, rig_.neutral_mm.cols());
      for (Eigen::Index m = 0; m < bend.cols(); ++m) {
        const Eigen::Vector3d way = au.displacement_mm.col(m), side = way.cross(across.col(m));
        const double length = side.norm();
        // 4 x (1 - x) is 1 half way.
        bend.col(m) = length > 1e-9 ? Eigen::Vector3d(4 * slide_share_ * way.norm() / length * side)
                                    : Eigen::Vector3d(Eigen::Vector3d::Zero());
      }
    }
  }
}

void TruthModel::change_identity(const PerturbOptions& options, Random& random) {
  rig_.neutral_mm += options.identity_mm * smooth_field(rig_.neutral_mm, random);
}

void TruthModel::place_markers(const PerturbOptions& options, Random& random) {
  const Eigen::Matrix3Xd at_mm = rig_.neutral_mm;
  std::vector<Eigen::Matrix3Xd> moved;
  for (const RigAu& au : rig_.aus) moved.push_back(au.displacement_mm);
  for (Eigen::Index m = 0; m < at_mm.cols(); ++m) {
    const Eigen::Vector3d shift = options.placement_mm * draw_vector(random);
    rig_.neutral_mm.col(m) += shift;
    // Displacement fields are smooth: their gradient at the marker, by least squares over its neighbours, says what
    // they are a little beside it.
    Eigen::Matrix3d spread = 25 * Eigen::Matrix3d::Identity();  // mm^2: as if neighbours were known to 5 mm
    const std::vector<Eigen::Index> near = neighbours_of(at_mm, m);
    for (const Eigen::Index other : near) {
      const Eigen::Vector3d apart = at_mm.col(other) - at_mm.col(m);
      spread += apart * apart.transpose();
    }
    const Eigen::Vector3d along = spread.ldlt().solve(shift);
    for (std::size_t k = 0; k < moved.size(); ++k) {
      const Eigen::Matrix3Xd& field = rig_.aus[k].displacement_mm;
      for (const Eigen::Index other : near)
        moved[k].col(m) += (at_mm.col(other) - at_mm.col(m)).dot(along) * (field.col(other) - field.col(m));
    }
  }
  for (std::size_t k = 0; k < moved.size(); ++k) rig_.aus[k].displacement_mm = moved[k];
}

void TruthModel::change_basis(const PerturbOptions& options, Random& random) {
  for (RigAu& au : rig_.aus) {
    const double size = std::sqrt(au.displacement_mm.squaredNorm() /
                                  std::max<double>(1, static_cast<double>(au.displacement_mm.cols())));
    // A third each: strength of the whole AU, its direction, its shape from place to place.
    const double share = options.basis_share / std::sqrt(3.0);
    const double strength = 1 + share * std::clamp(random.gaussian(), -2.0, 2.0);
    const Eigen::Vector3d axis = draw_vector(random).normalized();
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(share * std::clamp(random.gaussian(), -2.0, 2.0), axis).toRotationMatrix();
    const Eigen::Matrix3Xd local = smooth_field(rig_.neutral_mm, random);
    const Eigen::Matrix3Xd before = au.displacement_mm;
    au.displacement_mm = strength * turn * au.displacement_mm;
    // Where the AU moves nothing, another person's moves nothing either.
    for (Eigen::Index m = 0; m < au.displacement_mm.cols(); ++m) {
      const double here = size > 0 ? au.displacement_mm.col(m).norm() / size : 0;
      au.displacement_mm.col(m) += share * size * std::min(1.0, here) * local.col(m);
    }
    // By as much as was asked, a third more or less.
    const Eigen::Matrix3Xd change = au.displacement_mm - before;
    const double wanted = options.basis_share * random.uniform(2.0 / 3, 4.0 / 3) * before.norm();
    if (change.norm() > 0) au.displacement_mm = before + wanted / change.norm() * change;
  }
}

void TruthModel::pose_next(std::span<const double> intensities, Eigen::Matrix3Xd& head_mm) noexcept {
  head_mm = rig_.neutral_mm;
  for (std::size_t k = 0; k < rig_.aus.size(); ++k) {
    const double x = intensities[k];
    if (x == 0) continue;
    head_mm += x * rig_.aus[k].displacement_mm;
    if (slide_share_ > 0) head_mm += x * (1 - x) * bend_mm_[k];
  }
  if (creep_mm_ <= 0) return;
  const double input = creep_mm_ * std::sqrt(1 - creep_keep_ * creep_keep_);
  for (Eigen::Index i = 0; i < creep_mm_now_.size(); ++i) {
    double& creep = creep_mm_now_.data()[i];
    creep = creep_keep_ * creep + input * creep_random_.noise();
  }
  head_mm += creep_mm_now_;
}

void TruthModel::rewind() noexcept {
  creep_random_ = Random(seed_, kCreepStream);
  creep_mm_now_.setZero();
}

}  // namespace risorius
