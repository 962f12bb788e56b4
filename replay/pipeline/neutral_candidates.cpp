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
constexpr double kLeastSeen = 0.5;  // share of a window in which a marker must be seen to be compared
constexpr double kLeastShare =
    0.7;                       // of the take's markers must be compared; those that hardly any window has left out
constexpr double kRare = 0.1;  // share of the windows
constexpr int kMirrorSteps = 15;
/// On the score, for each marker that the take has and the window never sees: a neutral without it cannot place it.
constexpr double kUnseenMarkerFactor = 0.5;

struct SeenFace {
  Points shape;
  std::vector<double> seen;  ///< 1, or 0 and the point is the origin
};

/// The mean face of a window, on the head of its fullest frame; weight 0: hidden too often.
struct Window {
  std::size_t first = 0, last = 0;
  Points shape;
  std::vector<double> weight;
  std::vector<char> seen_once;
  double motion_mm = 0, asymmetry_mm = 0, frequency = 0, score = 0;
};

void read(const MarkerFrame& frame, SeenFace& face) {
  auto& [points, weight] = face;
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

/// Frames first, first + step, ... of a window on the head of the one that sees most; those that have too little in
/// common with it are left out.
std::vector<SeenFace> on_one_head(const std::vector<MarkerFrame>& frames, std::size_t first, std::size_t last) {
  std::vector<SeenFace> faces;
  const std::size_t step = std::max<std::size_t>(1, (last - first + 1) / kFramesPerWindow);
  for (std::size_t t = first; t <= last; t += step) read(frames[t], faces.emplace_back());
  const auto count = [](const SeenFace& face) { return std::ranges::count(face.seen, 1.0); };
  const SeenFace fullest = *std::ranges::max_element(faces, {}, count);
  std::erase_if(faces, [&](SeenFace& face) {
    const RigidAlignment onto = align_rigid(face.shape, fullest.shape, both(face.seen, fullest.seen));
    for (Eigen::Vector3d& p : face.shape) p = onto.to_from * p;
    return !onto.determined;
  });
  return faces;
}

std::optional<Window> window_of(const std::vector<MarkerFrame>& frames, std::size_t first, std::size_t last) {
  const std::vector<SeenFace> faces = on_one_head(frames, first, last);
  if (faces.size() < 2) return std::nullopt;
  const std::size_t markers = faces.front().seen.size();
  Window window{.first = first, .last = last, .shape = Points(markers, Eigen::Vector3d::Zero())};
  window.weight.assign(markers, 0);
  window.seen_once.assign(markers, 0);
  double squares = 0, used = 0;
  for (std::size_t m = 0; m < markers; ++m) {
    double count = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const SeenFace& face : faces) count += face.seen[m], sum += face.seen[m] * face.shape[m];
    window.seen_once[m] = count > 0;
    if (count < kLeastSeen * static_cast<double>(faces.size())) continue;
    window.weight[m] = 1;
    window.shape[m] = sum / count;
    used += 1;
    for (const SeenFace& face : faces)
      squares += face.seen[m] * (face.shape[m] - window.shape[m]).squaredNorm() / count;
  }
  if (used < 3) return std::nullopt;
  window.motion_mm = std::sqrt(squares / used);
  return window;
}

/// Windows that see too little of the face: they look still and alike because what moves is hidden.
void leave_out_sparse(std::vector<Window>& windows) {
  if (windows.empty()) return;
  std::vector<double> count(windows.front().weight.size(), 0);
  for (const Window& window : windows) {
    for (std::size_t m = 0; m < count.size(); ++m) count[m] += window.weight[m];
  }
  const double rare = kRare * static_cast<double>(windows.size());
  const auto markers = std::ranges::count_if(count, [&](double windows_of_it) { return windows_of_it > rare; });
  std::erase_if(windows, [&](const Window& window) {
    double compared = 0;
    for (std::size_t m = 0; m < count.size(); ++m) compared += count[m] > rare ? window.weight[m] : 0;
    return compared < kLeastShare * static_cast<double>(markers);
  });
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
  leave_out_sparse(windows);
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
