#include "solve/faces/rig_fit.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>
#include <stdexcept>

#include "capture/errors.h"
#include "solve/faces/similarity.h"
#include "solve/rigs/stabilisers.h"

namespace risorius {
namespace {

constexpr std::size_t kFewestLandmarks = 4;
constexpr double kMirrorAdvantage = 0.6;  // a mirrored fit this much closer is no chance
constexpr double kLeastAsideMm = 5;       // rms of the landmarks off the middle: less tells left from right by chance
constexpr double kAlikeCosine = 0.95;     // of two AUs' fields at the markers
constexpr double kConvergedMm = 1e-7;
constexpr double kDegreesPerRadian = 180 / 3.14159265358979323846;

/// Refusals name the layout that was fitted.
[[noreturn]] void refuse(const LandmarkMap& map, const std::string& problem, const std::string& remedy) {
  throw UserError("fit of '" + map.name + "'", problem, remedy);
}

template <class T>
void require(bool good, const char* name, T value, const char* range) {
  if (!good) throw std::invalid_argument(fmt::format("RigFitOptions.{} = {}: must be {}", name, value, range));
}

void check(const RigFitOptions& o) {
  require(o.iterations >= 1 && o.iterations <= 1000, "iterations", o.iterations, "1 to 1000");
  require(o.robust_mm > 0, "robust_mm", o.robust_mm, "> 0");
  require(o.far_mm >= o.robust_mm, "far_mm", o.far_mm, ">= robust_mm");
  require(o.landmark_weight >= 0, "landmark_weight", o.landmark_weight, ">= 0");
  require(o.identity.deviation_mm > 0, "identity.deviation_mm", o.identity.deviation_mm, "> 0");
  require(o.identity.length_mm > 0, "identity.length_mm", o.identity.length_mm, "> 0");
  require(o.landmark_deviation_mm > 0, "landmark_deviation_mm", o.landmark_deviation_mm, "> 0");
  require(o.skin_deviation_mm > 0, "skin_deviation_mm", o.skin_deviation_mm, "> 0");
  require(o.least_motion_mm >= 0, "least_motion_mm", o.least_motion_mm, ">= 0");
  require(o.largest_median_mm > 0, "largest_median_mm", o.largest_median_mm, "> 0");
  require(o.largest_landmark_mm > 0, "largest_landmark_mm", o.largest_landmark_mm, "> 0");
  require(o.smallest_scale > 0 && o.smallest_scale <= o.largest_scale, "smallest_scale", o.smallest_scale,
          "> 0 and not above largest_scale");
  require(o.largest_tilt_degrees > 0 && o.largest_tilt_degrees <= 180, "largest_tilt_degrees", o.largest_tilt_degrees,
          "above 0, at most 180");
}

/// Markers that were seen: names and places in the actor's world, 3 x M.
struct Seen {
  std::vector<std::string> names;
  Eigen::Matrix3Xd world_mm;
};

Seen seen_of(const std::vector<std::string>& names, const Eigen::Matrix3Xd& neutral_mm, const LandmarkMap& map,
             RigFitResult& result) {
  if (static_cast<Eigen::Index>(names.size()) != neutral_mm.cols()) {
    throw std::invalid_argument(fmt::format("fit_rig: {} names for {} positions", names.size(), neutral_mm.cols()));
  }
  std::set<std::string> unique(names.begin(), names.end());
  if (unique.size() != names.size()) refuse(map, "a marker name is there twice", "name each marker once");
  Seen seen{{}, Eigen::Matrix3Xd(3, neutral_mm.cols())};
  for (std::size_t m = 0; m < names.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    if (!neutral_mm.col(column).allFinite()) {
      result.left_out_markers.push_back(names[m]);
      result.warnings.push_back("marker " + names[m] + " was never seen in the neutral and is left out");
      continue;
    }
    seen.world_mm.col(static_cast<Eigen::Index>(seen.names.size())) = neutral_mm.col(column);
    seen.names.push_back(names[m]);
  }
  seen.world_mm.conservativeResize(3, static_cast<Eigen::Index>(seen.names.size()));
  return seen;
}

/// Landmarks of the face (3 x L, the face's mm) and the markers that sit there (3 x L, the actor's world).
struct LandmarkPairs {
  std::vector<std::string> labels;
  Eigen::Matrix3Xd face_mm, world_mm;
};

LandmarkPairs pairs_of(const FaceModel& face, const Seen& seen, const LandmarkMap& map, RigFitResult& result) {
  LandmarkPairs pairs;
  const auto most = static_cast<Eigen::Index>(map.marker_of_landmark.size());
  pairs.face_mm.resize(3, most);
  pairs.world_mm.resize(3, most);
  for (const auto& [landmark, marker] : map.marker_of_landmark) {
    const SurfacePoint* place = face.find_landmark(landmark);
    const auto found = std::find(seen.names.begin(), seen.names.end(), marker);
    if (place == nullptr)
      result.warnings.push_back("landmark " + landmark + " is not on the face '" + face.name() + "'");
    if (found == seen.names.end())
      result.warnings.push_back("landmark " + landmark + ": no marker " + marker + " in the neutral");
    if (place == nullptr || found == seen.names.end()) continue;
    const auto l = static_cast<Eigen::Index>(pairs.labels.size());
    pairs.face_mm.col(l) = face.position_mm(*place);
    pairs.world_mm.col(l) = seen.world_mm.col(found - seen.names.begin());
    pairs.labels.push_back(landmark + " = " + marker);
  }
  const auto count = static_cast<Eigen::Index>(pairs.labels.size());
  if (pairs.labels.size() < kFewestLandmarks) {
    refuse(map,
           fmt::format("only {} of {} landmarks have a marker{}{}", count, most, count > 0 ? ": " : "",
                       fmt::join(pairs.labels, ", ")),
           fmt::format("map at least {} landmarks to markers of this take", kFewestLandmarks));
  }
  pairs.face_mm.conservativeResize(3, count);
  pairs.world_mm.conservativeResize(3, count);
  return pairs;
}

/// The similarity from the landmarks alone; refuses markers that would fit better if left and right were exchanged.
Similarity register_landmarks(const LandmarkPairs& pairs, const LandmarkMap& map) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(pairs.face_mm.cols());
  const SimilarityFit fit = fit_similarity(pairs.face_mm, pairs.world_mm, ones);
  Eigen::Matrix3Xd mirrored = pairs.face_mm;
  mirrored.row(0) *= -1;
  const SimilarityFit mirrored_fit = fit_similarity(mirrored, pairs.world_mm, ones);
  if (!fit.determined)
    refuse(map, "the mapped markers are on one line or in one point", "map landmarks all over the face");
  if (std::sqrt(pairs.face_mm.row(0).squaredNorm() / static_cast<double>(pairs.face_mm.cols())) < kLeastAsideMm) {
    refuse(map, "the mapped landmarks are in the middle of the face, where left and right cannot be told apart",
           "map one at a side, such as a corner of the mouth");
  }
  if (mirrored_fit.determined && mirrored_fit.rms < kMirrorAdvantage * fit.rms) {
    refuse(map,
           fmt::format("mirrored: the landmarks are {:.1f} mm off, but {:.1f} mm with left and right exchanged",
                       fit.rms, mirrored_fit.rms),
           "check the axes of the take and the sides in the map; left is the subject's left");
  }
  return fit.to_from;
}

/// The weight of a marker so far off the skin: Huber's, and none where it is no marker of the face.
double pull_of(double distance_mm, const RigFitOptions& options) {
  if (distance_mm > options.far_mm) return 0;
  return distance_mm <= options.robust_mm ? 1 : options.robust_mm / distance_mm;
}

/// Iterated closest points, from the face to the actor: in this direction a shrinking face does not come closer.
/// Markers pull with Huber's weight; the landmark pairs stay as an anchor along the surface.
Similarity refine(const FaceModel& face, const Seen& seen, const LandmarkPairs& pairs, Similarity world_from_face,
                  const RigFitOptions& options) {
  const Eigen::Index markers = seen.world_mm.cols(), landmarks = pairs.face_mm.cols();
  Eigen::Matrix3Xd from(3, markers + landmarks), to(3, markers + landmarks);
  Eigen::VectorXd weights(markers + landmarks);
  from.rightCols(landmarks) = pairs.face_mm;
  to << seen.world_mm, pairs.world_mm;
  weights.tail(landmarks).setConstant(options.landmark_weight);
  for (int i = 0; i < options.iterations; ++i) {
    const Similarity face_from_world = world_from_face.inverse();
    for (Eigen::Index m = 0; m < markers; ++m) {
      const ClosestPoint closest = face.closest_skin_point(face_from_world * seen.world_mm.col(m));
      const double distance_mm = world_from_face.scale * closest.distance_mm;
      from.col(m) = closest.position_mm;
      weights[m] = pull_of(distance_mm, options);
    }
    const SimilarityFit next = fit_similarity(from, to, weights);
    if (!next.determined) break;
    double moved_mm = 0;
    for (Eigen::Index p = 0; p < from.cols(); ++p) {
      moved_mm = std::max(moved_mm, (next.to_from * from.col(p) - world_from_face * from.col(p)).norm());
    }
    world_from_face = next.to_from;
    if (moved_mm < kConvergedMm) break;
  }
  return world_from_face;
}

constexpr int kIdentityRounds = 6;

/// The generic face bent to the actor.
struct Bent {
  FaceModel face;  ///< at rest, without AUs
  IdentityWarp warp;
};

/// Landmarks pull whole, markers along the skin's normal only: where on the skin a marker sits is what the bent face
/// tells. Markers far off pull less, or not at all.
std::vector<WarpObservation> observe(const FaceModel& generic, const FaceModel& bent, const Seen& seen,
                                     const LandmarkPairs& pairs, const Similarity& world_from_face,
                                     const RigFitOptions& options) {
  const Similarity face_from_world = world_from_face.inverse();
  std::vector<WarpObservation> observations;
  for (Eigen::Index l = 0; l < pairs.face_mm.cols(); ++l) {
    const Eigen::Vector3d from_mm = pairs.face_mm.col(l), to_mm = face_from_world * pairs.world_mm.col(l);
    for (int axis = 0; axis < 3; ++axis) {
      observations.push_back({.at_mm = from_mm,
                              .direction = Eigen::Vector3d::Unit(axis),
                              .shift_mm = (to_mm - from_mm)[axis],
                              .deviation_mm = options.landmark_deviation_mm});
    }
  }
  for (Eigen::Index m = 0; m < seen.world_mm.cols(); ++m) {
    const Eigen::Vector3d at_mm = face_from_world * seen.world_mm.col(m);
    const ClosestPoint closest = bent.closest_skin_point(at_mm);
    const Eigen::Vector3d from_mm = generic.position_mm(closest.place), normal = bent.normal(closest.place);
    const double pull = pull_of(closest.distance_mm * world_from_face.scale, options);
    if (pull <= 0) continue;
    observations.push_back({.at_mm = from_mm,
                            .direction = normal,
                            .shift_mm = normal.dot(at_mm - from_mm),
                            .deviation_mm = options.skin_deviation_mm / std::sqrt(pull)});
  }
  return observations;
}

/// Each round bends the generic face anew, by where the markers lie on the last one. Where the head is stays: a face
/// that fits everywhere holds nothing along its skin, and would slide from round to round.
Bent bend(const FaceModel& generic, const Seen& seen, const LandmarkPairs& pairs, const Similarity& world_from_face,
          const RigFitOptions& options) {
  Bent bent{generic.warped_at_rest({}), {}};
  for (int round = 0; round < kIdentityRounds; ++round) {
    bent.warp = IdentityWarp(observe(generic, bent.face, seen, pairs, world_from_face, options), options.identity);
    bent.face = generic.warped_at_rest(bent.warp);
  }
  return bent;
}

/// At the markers, in the actor's mm.
double bend_rms_mm(const FaceModel& generic, const IdentityWarp& warp, const RigFitResult& result) {
  double squares = 0;
  for (const SurfacePoint& place : result.places)
    squares += warp.displacement_mm(generic.position_mm(place)).squaredNorm();
  return result.scale * std::sqrt(squares / static_cast<double>(result.places.size()));
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void measure_landmarks(const LandmarkPairs& pairs, const Similarity& world_from_face, const LandmarkMap& map,
                       const RigFitOptions& options, RigFitResult& result) {
  double squares = 0;
  std::string worst;
  for (Eigen::Index l = 0; l < pairs.face_mm.cols(); ++l) {
    const double residual_mm = (world_from_face * pairs.face_mm.col(l) - pairs.world_mm.col(l)).norm();
    squares += residual_mm * residual_mm;
    if (residual_mm <= result.largest_landmark_residual_mm) continue;
    result.largest_landmark_residual_mm = residual_mm;
    worst = pairs.labels[static_cast<std::size_t>(l)];
  }
  result.landmark_rms_mm = std::sqrt(squares / static_cast<double>(pairs.face_mm.cols()));
  // In the face's mm: of a wrong unit the landmarks are not to blame.
  if (result.largest_landmark_residual_mm > options.largest_landmark_mm * std::max(1.0, world_from_face.scale)) {
    refuse(map,
           fmt::format("{} is {:.1f} mm off (at most {:.1f})", worst, result.largest_landmark_residual_mm,
                       options.largest_landmark_mm),
           "check this line of the map, the unit and the axes");
  }
}

void refuse_absurd(const Similarity& world_from_face, const LandmarkMap& map, const RigFitOptions& options,
                   const RigFitResult& result) {
  const double scale = world_from_face.scale;
  if (scale < options.smallest_scale || scale > options.largest_scale) {
    refuse(map,
           fmt::format("the actor would be {:.3g} times the face ({:.2g} to {:.2g} is plausible)", scale,
                       options.smallest_scale, options.largest_scale),
           "check the unit of the take");
  }
  const Eigen::Vector3d up = world_from_face.rotation * Eigen::Vector3d::UnitY();
  const double tilt_degrees = kDegreesPerRadian * std::acos(std::clamp(up.y(), -1.0, 1.0));
  if (tilt_degrees > options.largest_tilt_degrees) {
    refuse(map,
           fmt::format("the head's up is {:.0f} degrees off the world's (at most {:.0f})", tilt_degrees,
                       options.largest_tilt_degrees),
           "check the axes of the take");
  }
  if (result.median_distance_mm > options.largest_median_mm) {
    refuse(map,
           fmt::format("the markers are {:.1f} mm off the skin in the median (at most {:.1f})",
                       result.median_distance_mm, options.largest_median_mm),
           "check the map and the neutral");
  }
}

/// Places the markers on the skin.
void place(const FaceModel& face, const Seen& seen, const Similarity& world_from_face, RigFitResult& result) {
  const Similarity face_from_world = world_from_face.inverse();
  result.places.clear();
  result.rig.fit_distance_mm.clear();
  for (Eigen::Index m = 0; m < seen.world_mm.cols(); ++m) {
    const ClosestPoint closest = face.closest_skin_point(face_from_world * seen.world_mm.col(m));
    result.places.push_back(closest.place);
    result.rig.fit_distance_mm.push_back(world_from_face.scale * closest.distance_mm);
  }
  result.median_distance_mm = median_of(result.rig.fit_distance_mm);
  result.scale = world_from_face.scale;
}

/// Leaves out what is no marker of the face, and says so.
void leave_out_far(const FaceModel& face, const Similarity& world_from_face, const LandmarkMap& map,
                   const RigFitOptions& options, Seen& seen, RigFitResult& result) {
  const Similarity face_from_world = world_from_face.inverse();
  Eigen::Index kept = 0;
  for (Eigen::Index m = 0; m < seen.world_mm.cols(); ++m) {
    std::string& name = seen.names[static_cast<std::size_t>(m)];
    const double distance_mm =
        world_from_face.scale * face.closest_skin_point(face_from_world * seen.world_mm.col(m)).distance_mm;
    if (distance_mm > options.far_mm && !map.stabiliser_weight.contains(name)) {
      result.warnings.push_back(fmt::format(
          "marker {} is {:.0f} mm off the skin and is left out (a marker of the face? then its name or its place in "
          "the neutral is wrong)",
          name, distance_mm));
      result.left_out_markers.push_back(name);
      continue;
    }
    seen.world_mm.col(kept) = seen.world_mm.col(m);
    std::swap(seen.names[static_cast<std::size_t>(kept++)], name);
  }
  seen.world_mm.conservativeResize(3, kept);
  seen.names.resize(static_cast<std::size_t>(kept));
}

/// The rig's neutral and shapes in the head frame; a shape goes through the bend of the place where it acts.
void transfer(const FaceModel& face, const IdentityWarp& warp, const Seen& seen, const Similarity& world_from_face,
              const RigFitOptions& options, RigFitResult& result) {
  Rig& rig = result.rig;
  const Eigen::Index markers = seen.world_mm.cols();
  result.head_from_world = RigidTransform{world_from_face.rotation, world_from_face.translation}.inverse();
  rig.marker_names = seen.names;
  rig.neutral_mm.resize(3, markers);
  std::vector<Eigen::Matrix3d> carries;
  for (Eigen::Index m = 0; m < markers; ++m) {
    rig.neutral_mm.col(m) = result.head_from_world * seen.world_mm.col(m);
    carries.push_back(result.scale * warp.jacobian(face.position_mm(result.places[static_cast<std::size_t>(m)])));
  }
  for (const FaceAu& shape : face.aus()) {
    if (!shape.in_rigs) continue;
    RigAu au{shape.name, Eigen::Matrix3Xd(3, markers), shape.upper_bound};
    for (std::size_t m = 0; m < carries.size(); ++m)
      au.displacement_mm.col(static_cast<Eigen::Index>(m)) =
          carries[m] * face.at(shape.displacement_mm, result.places[m]);
    const bool is_seen = au.displacement_mm.colwise().norm().maxCoeff() >= options.least_motion_mm;
    if (is_seen) {
      rig.aus.push_back(std::move(au));
    } else {
      result.dropped_aus.push_back(shape.name);
    }
  }
}

void warn_of_aus_alike(RigFitResult& result) {
  const std::vector<RigAu>& aus = result.rig.aus;
  for (std::size_t a = 0; a < aus.size(); ++a) {
    for (std::size_t b = a + 1; b < aus.size(); ++b) {
      const Eigen::Matrix3Xd &first = aus[a].displacement_mm, &second = aus[b].displacement_mm;
      const double cosine = first.cwiseProduct(second).sum() / (first.norm() * second.norm());
      if (cosine <= kAlikeCosine) continue;  // opposites (jaw left, jaw right) are told apart by x >= 0
      result.warnings.push_back(
          fmt::format("{} and {} look alike to these markers (cosine {:.3f})", aus[a].name, aus[b].name, cosine));
    }
  }
}

void set_stabilisers(const LandmarkMap& map, RigFitResult& result) {
  Rig& rig = result.rig;
  rig.stabiliser_weight = Eigen::VectorXd::Zero(rig.neutral_mm.cols());
  for (std::size_t m = 0; m < rig.marker_names.size(); ++m) {
    const auto found = map.stabiliser_weight.find(rig.marker_names[m]);
    if (found != map.stabiliser_weight.end()) rig.stabiliser_weight[static_cast<Eigen::Index>(m)] = found->second;
  }
  std::vector<std::string> unknown;
  for (const auto& [marker, weight] : map.stabiliser_weight) {
    if (std::ranges::find(rig.marker_names, marker) == rig.marker_names.end()) unknown.push_back(marker);
  }
  if (!unknown.empty()) {
    result.warnings.push_back(fmt::format("the map's stabilisers {} are no markers of the neutral, which has: {}",
                                          fmt::join(unknown, ", "), fmt::join(rig.marker_names, " ")));
  }
  if (hold_still(rig.neutral_mm, rig.stabiliser_weight)) return;
  rig.stabiliser_weight.setZero();
  std::vector<std::string> names;
  for (const Eigen::Index m : choose_stabilisers(rig.neutral_mm, rig.aus)) {
    rig.stabiliser_weight[m] = 1;
    names.push_back(rig.marker_names[static_cast<std::size_t>(m)]);
  }
  result.warnings.push_back(
      fmt::format("the map's stabilisers do not hold the head; chosen as least moved: {}", fmt::join(names, ", ")));
  if (!hold_still(rig.neutral_mm, rig.stabiliser_weight)) {
    refuse(map, "no three markers that hold the head are off one line", "name stabilisers in the map");
  }
}

}  // namespace

RigFitResult fit_rig(const FaceModel& face, const std::vector<std::string>& marker_names,
                     const Eigen::Matrix3Xd& neutral_mm, const LandmarkMap& map, const RigFitOptions& options) {
  check(options);
  RigFitResult result;
  Seen seen = seen_of(marker_names, neutral_mm, map, result);
  const LandmarkPairs pairs = pairs_of(face, seen, map, result);
  const Similarity first = register_landmarks(pairs, map);
  const Similarity world_from_face = refine(face, seen, pairs, first, options);
  // What is absurd is absurd of the generic face: a bent one comes close to anything.
  measure_landmarks(pairs, world_from_face, map, options, result);
  place(face, seen, world_from_face, result);
  refuse_absurd(world_from_face, map, options, result);
  leave_out_far(face, world_from_face, map, options, seen, result);
  place(face, seen, world_from_face, result);
  IdentityWarp warp;
  if (options.with_identity) {
    const Bent bent = bend(face, seen, pairs, world_from_face, options);
    warp = bent.warp;
    result.generic_median_distance_mm = result.median_distance_mm;
    place(bent.face, seen, world_from_face, result);
    result.identity_rms_mm = bend_rms_mm(face, warp, result);
  }
  transfer(face, warp, seen, world_from_face, options, result);
  set_stabilisers(map, result);
  warn_of_aus_alike(result);
  result.rig.name = map.name;
  result.rig.source =
      fmt::format("fit of {} to {} markers: scale {:.3f}, median distance {:.1f} mm, landmarks {:.1f} mm rms",
                  face.name(), seen.names.size(), result.scale, result.median_distance_mm, result.landmark_rms_mm);
  return result;
}

}  // namespace risorius
