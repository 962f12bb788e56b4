#include "solve/rigs/rig.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "capture/errors.h"
#include "capture/frames.h"
#include "capture/marker_set.h"

namespace risorius {
namespace {

constexpr double kMaxUpperBound = 2;
/// Of any coordinate and displacement: neutrals may lie where the stage's origin is, but not on the moon.
constexpr double kFarthestMm = 10'000;
constexpr double kLargestWeight = 1000;
/// As in capture/rigid_alignment.cpp: flatter than this, the stabilisers lie on one line.
constexpr double kCollinearSpreadRatio = 1e-3;

using Problems = std::vector<std::string>;

void check_name(Problems& problems, const std::string& what, const std::string& name, std::set<std::string>& seen) {
  if (name.empty() || name.size() > kMaxNameBytes) {
    problems.push_back(
        fmt::format("{}: the name '{}' has {} bytes, allowed are 1 to {}", what, name, name.size(), kMaxNameBytes));
  } else if (std::ranges::any_of(name,
                                 [](unsigned char c) { return c < 0x20 || c == 0x7f || c == '/' || c == '\\'; })) {
    // AUs name files, and all names stand in tables.
    problems.push_back(fmt::format("{}: the name has a slash, backslash or control character in it", what));
  } else if (!seen.insert(name).second) {
    problems.push_back(fmt::format("{}: the name '{}' occurs twice, names must be unique", what, name));
  }
}

void check_count(Problems& problems, const std::string& what, std::size_t count, std::size_t most) {
  if (count == 0 || count > most)
    problems.push_back(fmt::format("{}: {} of them, allowed are 1 to {}", what, count, most));
}

/// The first marker whose value is wrong, by number and name, and how many more are; empty if none is.
template <class IsWrong>
std::string wrong_marker(const Rig& rig, Eigen::Index& first, IsWrong is_wrong) {
  const auto count = static_cast<Eigen::Index>(rig.marker_count());
  Eigen::Index wrong = 0;
  for (Eigen::Index m = 0; m < count; ++m) {
    if (is_wrong(m) && wrong++ == 0) first = m;
  }
  if (wrong == 0) return "";
  const std::string others = wrong == 1 ? "" : fmt::format(" (and {} more)", wrong - 1);
  return fmt::format("markers[{}] '{}'{}", first, shown(rig.marker_names[static_cast<std::size_t>(first)]), others);
}

/// Of three numbers the one that is not finite, else the farthest from 0.
double worst_of(const Eigen::Vector3d& v) {
  double worst = 0;
  for (const double x : v) {
    if (!std::isfinite(x)) return x;
    if (std::abs(x) > std::abs(worst)) worst = x;
  }
  return worst;
}

bool is_farther_than(const Eigen::Vector3d& v, double most) { return !v.allFinite() || v.cwiseAbs().maxCoeff() > most; }

bool stabilisers_hold_the_head(const Rig& rig) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double total = 0;
  int used = 0;
  for (Eigen::Index m = 0; m < rig.neutral_mm.cols(); ++m) {
    if (!(rig.stabiliser_weight[m] > 0)) continue;
    mean += rig.stabiliser_weight[m] * rig.neutral_mm.col(m);
    total += rig.stabiliser_weight[m];
    ++used;
  }
  if (used < 3) return false;
  mean /= total;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (Eigen::Index m = 0; m < rig.neutral_mm.cols(); ++m) {
    if (!(rig.stabiliser_weight[m] > 0)) continue;
    const Eigen::Vector3d offset = rig.neutral_mm.col(m) - mean;
    spread += rig.stabiliser_weight[m] / total * offset * offset.transpose();
  }
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  return eigenvalues[1] > kCollinearSpreadRatio * kCollinearSpreadRatio * eigenvalues[2];
}

void check_markers(Problems& problems, const Rig& rig) {
  check_count(problems, "markers", rig.marker_count(), kMaxMarkers);
  std::set<std::string> seen;
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    check_name(problems, fmt::format("markers[{}]", m), rig.marker_names[m], seen);
  }
  const Eigen::Index count = static_cast<Eigen::Index>(rig.marker_count());
  Eigen::Index first = 0;
  if (rig.neutral_mm.cols() != count) {
    problems.push_back(fmt::format("neutral_mm: {} columns for {} markers", rig.neutral_mm.cols(), count));
  } else if (const std::string marker = wrong_marker(
                 rig, first, [&](Eigen::Index m) { return is_farther_than(rig.neutral_mm.col(m), kFarthestMm); });
             !marker.empty()) {
    problems.push_back(fmt::format("{}: neutral_mm holds {:g}; a marker lies within {:g} mm of the origin", marker,
                                   worst_of(rig.neutral_mm.col(first)), kFarthestMm));
  }
  if (rig.stabiliser_weight.size() != count) {
    problems.push_back(
        fmt::format("stabiliser_weight: {} entries for {} markers", rig.stabiliser_weight.size(), count));
  } else if (const std::string marker = wrong_marker(rig, first,
                                                     [&](Eigen::Index m) {
                                                       const double weight = rig.stabiliser_weight[m];
                                                       return !(weight >= 0 && weight <= kLargestWeight);
                                                     });
             !marker.empty()) {
    problems.push_back(fmt::format("{}: stabiliser_weight is {:g}; allowed are 0 to {:g}", marker,
                                   rig.stabiliser_weight[first], kLargestWeight));
  } else if (rig.neutral_mm.cols() == count && rig.neutral_mm.allFinite() && !stabilisers_hold_the_head(rig)) {
    problems.push_back(
        "stabiliser_weight: fewer than 3 markers above 0 that are not on one line; give the markers of forehead, nose "
        "bridge or head band a weight");
  }
  if (!rig.fit_distance_mm.empty() && rig.fit_distance_mm.size() != rig.marker_count()) {
    problems.push_back(
        fmt::format("fit_distance_mm: {} entries for {} markers", rig.fit_distance_mm.size(), rig.marker_count()));
  }
  if (rig.fit_distance_mm.size() != rig.marker_count()) return;
  const std::string marker = wrong_marker(rig, first, [&](Eigen::Index m) {
    const double distance = rig.fit_distance_mm[static_cast<std::size_t>(m)];
    return !std::isfinite(distance) || distance < 0;
  });
  if (!marker.empty()) {
    problems.push_back(fmt::format("{}: fit_distance_mm is {:g}; it is a distance from 0 on", marker,
                                   rig.fit_distance_mm[static_cast<std::size_t>(first)]));
  }
}

void check_au(Problems& problems, const RigAu& au, std::size_t marker_count) {
  if (au.displacement_mm.cols() != static_cast<Eigen::Index>(marker_count)) {
    problems.push_back(fmt::format("aus '{}': displacement_mm has {} columns for {} markers", au.name,
                                   au.displacement_mm.cols(), marker_count));
  } else if (!au.displacement_mm.allFinite()) {
    problems.push_back(fmt::format("aus '{}': displacement_mm holds a number that is not finite", au.name));
  } else if (marker_count > 0 && au.displacement_mm.cwiseAbs().maxCoeff() > kFarthestMm) {
    problems.push_back(fmt::format("aus '{}': displacement_mm holds {:g}; no marker moves further than {:g} mm",
                                   au.name, au.displacement_mm.cwiseAbs().maxCoeff(), kFarthestMm));
  } else if (!(au.displacement_mm.squaredNorm() > 0)) {
    problems.push_back(fmt::format("aus '{}': displacement_mm moves no marker; leave the AU out of this rig", au.name));
  }
  if (!(au.upper_bound > 0 && au.upper_bound <= kMaxUpperBound)) {
    problems.push_back(
        fmt::format("aus '{}': upper_bound {} is not above 0 and at most {}", au.name, au.upper_bound, kMaxUpperBound));
  }
}

}  // namespace

std::vector<std::string> Rig::au_names() const {
  std::vector<std::string> names;
  names.reserve(aus.size());
  for (const RigAu& au : aus) names.push_back(au.name);
  return names;
}

std::vector<std::string> problems_of(const Rig& rig) {
  Problems problems;
  check_markers(problems, rig);
  check_count(problems, "aus", rig.au_count(), kMaxAus);
  std::set<std::string> seen;
  for (std::size_t i = 0; i < rig.au_count(); ++i) {
    check_name(problems, fmt::format("aus[{}]", i), rig.aus[i].name, seen);
    // Each AU's picture is called after it, beside those of the neutral and of all.
    const std::string& name = rig.aus[i].name;
    if (name == "." || name == ".." || name == "neutral" || name == "contact_sheet") {
      problems.push_back(
          fmt::format("aus[{}]: '{}' cannot name an AU; call it AU + number + L, R or nothing", i, name));
    }
    check_au(problems, rig.aus[i], rig.marker_count());
  }
  return problems;
}

}  // namespace risorius
