#include "replay/pipeline/neutral_candidates.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "solve/rigs/marker_rigidity.h"

namespace risorius {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr std::size_t kMostWindows = 600;
constexpr std::size_t kFramesPerWindow = 12;
constexpr double kLeastShare = 0.7;  // of the markers must be seen in a window that is compared
constexpr int kMirrorSteps = 15;
/// On the score, for each marker that the take has and the window never sees: a neutral without it cannot place it.
constexpr double kUnseenMarkerFactor = 0.5;

/// The mean face of a window, on the first frame's head; weight 0: not seen throughout.
struct Window {
  std::size_t first = 0, last = 0;
  Points shape;
  std::vector<double> weight;
  std::vector<char> seen_once;
  double motion_mm = 0, asymmetry_mm = 0, frequency = 0, score = 0;
};

void read(const MarkerFrame& frame, Points& points, std::vector<double>& weight) {
  points.resize(frame.count);
  weight.resize(frame.count);
  for (std::size_t m = 0; m < frame.count; ++m) {
    const Position& p = frame.position_mm[m];
    points[m] = {p.x, p.y, p.z};
    weight[m] = frame.state[m] == MarkerState::kMeasured && points[m].allFinite() ? 1 : 0;
    if (weight[m] == 0) points[m].setZero();
  }
}

std::vector<double> both(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> product(a.size());
  for (std::size_t m = 0; m < a.size(); ++m) product[m] = a[m] * b[m];
  return product;
}

/// Root mean square distance of two faces over the markers of both, the one laid on the other.
double distance_mm(const Window& a, const Window& b) {
  const std::vector<double> weight = both(a.weight, b.weight);
  const RigidAlignment onto = align_rigid(a.shape, b.shape, weight);
  return onto.determined ? onto.rms : std::numeric_limits<double>::infinity();
}

std::optional<Window> window_of(const std::vector<MarkerFrame>& frames, std::size_t first, std::size_t last) {
  Window window{.first = first, .last = last};
  Points points;
  std::vector<double> seen, counts;
  std::vector<Points> laid;
  std::vector<std::vector<double>> weights;
  const std::size_t step = std::max<std::size_t>(1, (last - first + 1) / kFramesPerWindow);
  for (std::size_t t = first; t <= last; t += step) {
    read(frames[t], points, seen);
    if (laid.empty()) {
      window.shape = points;
      window.weight = seen;
      window.seen_once.assign(seen.size(), 0);
    } else {
      const RigidAlignment onto = align_rigid(points, laid.front(), both(seen, window.weight));
      if (!onto.determined) return std::nullopt;
      for (Eigen::Vector3d& p : points) p = onto.to_from * p;
      window.weight = both(window.weight, seen);
    }
    for (std::size_t m = 0; m < seen.size(); ++m) {
      if (seen[m] > 0) window.seen_once[m] = 1;
    }
    laid.push_back(points);
  }
  const double used = static_cast<double>(std::ranges::count_if(window.weight, [](double w) { return w > 0; }));
  if (used < 3 || used < kLeastShare * static_cast<double>(window.weight.size())) return std::nullopt;
  double squares = 0;
  for (std::size_t m = 0; m < window.weight.size(); ++m) {
    if (window.weight[m] == 0) continue;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Points& p : laid) mean += p[m] / static_cast<double>(laid.size());
    for (const Points& p : laid) squares += (p[m] - mean).squaredNorm() / static_cast<double>(laid.size());
    window.shape[m] = mean;
  }
  window.motion_mm = std::sqrt(squares / used);
  return window;
}

/// For each marker the one that stands where its mirror image is (which may be itself).
std::vector<std::size_t> mirror_partners(const Window& face) {
  Points mirrored = face.shape;
  for (Eigen::Vector3d& p : mirrored) p.x() = -p.x();
  std::vector<std::size_t> partner(mirrored.size(), 0);
  RigidTransform onto;
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  double count = 0;
  for (std::size_t m = 0; m < mirrored.size(); ++m)
    from += face.weight[m] * mirrored[m], to += face.weight[m] * face.shape[m], count += face.weight[m];
  onto.translation = (to - from) / count;
  for (int step = 0; step < kMirrorSteps; ++step) {
    Points matched(mirrored.size(), Eigen::Vector3d::Zero());
    for (std::size_t m = 0; m < mirrored.size(); ++m) {
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t other = 0; other < mirrored.size(); ++other) {
        if (face.weight[other] == 0) continue;
        const double d = (onto * mirrored[m] - face.shape[other]).squaredNorm();
        if (d < nearest) nearest = d, partner[m] = other;
      }
      matched[m] = face.shape[partner[m]];
    }
    const RigidAlignment next = align_rigid(mirrored, matched, face.weight);
    if (!next.determined) break;
    onto = next.to_from;
  }
  return partner;
}

double asymmetry_mm(const Window& face, const std::vector<std::size_t>& partner) {
  Points mirrored = face.shape, matched(face.shape.size());
  std::vector<double> weight(face.shape.size());
  for (std::size_t m = 0; m < matched.size(); ++m) {
    mirrored[m].x() = -mirrored[m].x();
    matched[m] = face.shape[partner[m]];
    weight[m] = face.weight[m] * face.weight[partner[m]];
  }
  const RigidAlignment onto = align_rigid(mirrored, matched, weight);
  return onto.determined ? onto.rms : std::numeric_limits<double>::infinity();
}

/// Of the markers that other windows see.
std::size_t unseen_markers(const Window& window, const std::vector<char>& seen_somewhere) {
  std::size_t unseen = 0;
  for (std::size_t m = 0; m < seen_somewhere.size(); ++m) unseen += seen_somewhere[m] > window.seen_once[m] ? 1 : 0;
  return unseen;
}

void score(std::vector<Window>& windows, const NeutralSearchOptions& options) {
  for (Window& window : windows) {
    double alike = 0;
    for (const Window& other : windows) alike += distance_mm(window, other) < options.alike_mm;
    window.frequency = alike / static_cast<double>(windows.size());
  }
  const auto usual = std::ranges::max_element(windows, {}, &Window::frequency);
  const std::vector<std::size_t> partner = mirror_partners(*usual);
  for (Window& window : windows) window.asymmetry_mm = asymmetry_mm(window, partner);
  std::vector<char> seen_somewhere(windows.front().seen_once.size(), 0);
  for (const Window& window : windows) {
    for (std::size_t m = 0; m < seen_somewhere.size(); ++m) {
      if (window.seen_once[m] != 0) seen_somewhere[m] = 1;
    }
  }
  const double least_mm = std::ranges::min_element(windows, {}, &Window::asymmetry_mm)->asymmetry_mm;
  for (Window& window : windows) {
    window.asymmetry_mm -= least_mm;
    window.score = window.frequency / usual->frequency * std::exp(-window.motion_mm / options.still_mm) *
                   std::exp(-window.asymmetry_mm / options.symmetric_mm) *
                   std::pow(kUnseenMarkerFactor, static_cast<double>(unseen_markers(window, seen_somewhere)));
  }
}

}  // namespace

std::vector<NeutralCandidate> neutral_candidates(const std::vector<MarkerFrame>& frames,
                                                 const NeutralSearchOptions& options) {
  if (frames.size() < 2) return {};
  const double seconds =
      static_cast<double>(frames.back().header.capture_time_ns - frames.front().header.capture_time_ns) * 1e-9;
  const double rate_hz = seconds > 0 ? static_cast<double>(frames.size() - 1) / seconds : 1;
  const auto length = std::clamp<std::size_t>(static_cast<std::size_t>(options.window_s * rate_hz), 2, frames.size());
  const std::size_t step = std::max<std::size_t>({1, length / 2, frames.size() / kMostWindows});
  std::vector<Window> windows;
  for (std::size_t first = 0; first + length <= frames.size(); first += step) {
    if (auto window = window_of(frames, first, first + length - 1)) windows.push_back(std::move(*window));
  }
  if (windows.empty()) return {};
  score(windows, options);

  std::vector<NeutralCandidate> found;
  std::vector<char> taken(windows.size(), 0);
  while (found.size() < options.most) {
    std::size_t best = windows.size();
    for (std::size_t w = 0; w < windows.size(); ++w) {
      if (taken[w] == 0 && (best == windows.size() || windows[w].score > windows[best].score)) best = w;
    }
    if (best == windows.size() || windows[best].score < 1e-3) break;
    std::size_t from = best, to = best;
    const auto goes_on = [&](std::size_t w) {
      return taken[w] == 0 && windows[w].score > 0.5 * windows[best].score &&
             distance_mm(windows[w], windows[best]) < 0.5 * options.alike_mm;
    };
    const auto longest = static_cast<std::size_t>(options.longest_s * rate_hz);
    while (from > 0 && windows[to].last - windows[from - 1].first < longest && goes_on(from - 1)) --from;
    while (to + 1 < windows.size() && windows[to + 1].last - windows[from].first < longest && goes_on(to + 1)) ++to;
    const Window& w = windows[best];
    const std::size_t first = windows[from].first, last = windows[to].last;
    found.push_back({first, last, static_cast<double>(last - first + 1) / rate_hz, w.motion_mm, w.asymmetry_mm,
                     w.frequency, w.score});
    for (std::size_t k = 0; k < windows.size(); ++k) {
      if (windows[k].first <= last && windows[k].last >= first) taken[k] = 1;
    }
  }
  return found;
}

}  // namespace risorius
