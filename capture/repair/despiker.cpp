#include "capture/repair/despiker.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/repair/position_vector.h"
#include "capture/stage.h"

namespace risorius {

static_assert(Stage<Despiker, MarkerFrame, MarkerFrame>);

namespace {

/// What a marker strays before anything is known of it, and how many samples that belief is worth.
constexpr double kPriorStrayingMm2 = 0.6 * 0.6;
constexpr double kPriorSamples = 30;
constexpr double kMemorySamples = 1200;
/// How fast the expected residual follows, and in what time a marker's past becomes worthless while it is hidden.
constexpr double kOffsetS = 0.03;
constexpr double kOffsetMemoryS = 0.5;
/// A marker that was accepted so lately must have leapt to be false.
constexpr double kGoesOnS = 0.1;
/// More of a frame's markers than this are not false at once.
constexpr double kMostFalseShare = 0.25;
/// Noise of two positions, on top of what max_speed_mm_s allows.
constexpr double kSpeedSlackMm = 1.0;
/// A marker this close to another one, as a share of the usual distance, sits on it.
constexpr double kGhostShare = 0.35;
constexpr double kNeighbourShare = 0.5;
constexpr std::uint32_t kRenewNeighboursFrames = 64;

void require(bool good, const char* name, double value, const char* range) {
  if (!good) throw UserError(name, fmt::format("{} is not {}", value, range), "leave it out for the default");
}

}  // namespace

Despiker::Despiker(DespikerOptions options)
    : options_(std::move(options)), head_(options_.head_frame), statistics_(options_.statistics) {
  require(options_.max_speed_mm_s > 0, "max_speed_mm_s", options_.max_speed_mm_s, "> 0");
  require(options_.deviation_multiple >= 3, "deviation_multiple", options_.deviation_multiple, ">= 3");
  require(options_.least_deviation_mm > 0, "least_deviation_mm", options_.least_deviation_mm, "> 0");
  require(options_.most_deviation_mm >= options_.least_deviation_mm, "most_deviation_mm", options_.most_deviation_mm,
          ">= least_deviation_mm");
  require(options_.accept_after_ns > 0, "accept_after_ns", static_cast<double>(options_.accept_after_ns), "> 0");
}

void Despiker::use_marker_set(const MarkerSet& set) {
  if (const auto problems = problems_of(set); !problems.empty()) {
    throw UserError(fmt::format("marker set {}", set.id), problems.front(), "correct the sender's marker set");
  }
  settle();
  const std::vector<int> old_index = index_map(set_.names, set.names);
  head_.use_names(set.names);
  statistics_.remap(old_index);
  neighbours_.resize(set.names.size());
  frames_to_renewal_ = 0;
  std::vector<Track> tracks(set.names.size());
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (old_index[i] >= 0) tracks[i] = tracks_[static_cast<std::size_t>(old_index[i])];
  }
  tracks_ = std::move(tracks);
  trusted_.assign(set.names.size(), 0);
  if (set_.names.empty()) clock_.reset(set.rate_hz);
  set_ = set;
}

void Despiker::reset() noexcept {
  is_settled_ = true;
  head_.reset();
  statistics_.reset();
  std::fill(tracks_.begin(), tracks_.end(), Track{});
  clock_.reset(set_.rate_hz);
  frames_to_renewal_ = 0;
  if (has_waiting_) ledger_.dropped.add();
  has_waiting_ = false;
  ledger_.held.set(0);
}

bool Despiker::push(const MarkerFrame& frame) noexcept {
  if (has_waiting_) return false;
  settle();
  ledger_.received.add();
  if (frame.count != set_.names.size()) {
    ledger_.refused.add();
    return true;
  }
  waiting_ = frame;
  has_waiting_ = true;
  ledger_.held.set(1);
  if (options_.method == DespikeMethod::kDisplacement) process_displacement(waiting_);
  if (options_.method == DespikeMethod::kHeadFrame) process(waiting_);
  return true;
}

bool Despiker::pop(MarkerFrame& frame) noexcept {
  if (!has_waiting_) return false;
  frame = waiting_;
  has_waiting_ = false;
  ledger_.held.set(0);
  ledger_.emitted.add();
  return true;
}

void Despiker::reject(MarkerFrame& frame, std::size_t i, RejectReason reason) noexcept {
  frame.state[i] = MarkerState::kRejected;
  frame.reason[i] = reason;
  rejected_[static_cast<std::size_t>(reason)].add();
}

/// Against the last accepted sample, so that the allowed distance grows while a marker is rejected or missing.
void Despiker::process_displacement(MarkerFrame& frame) noexcept {
  const double step_s = clock_.advance(frame.header.capture_time_ns);
  for (std::size_t i = 0; i < frame.count; ++i) {
    Track& track = tracks_[i];
    track.unseen_s += step_s;
    if (frame.state[i] != MarkerState::kMeasured) continue;
    const Eigen::Vector3d position = to_vector(frame.position_mm[i]);
    if (!position.allFinite()) {
      reject(frame, i, RejectReason::kNotFinite);
    } else if (track.started && (position - track.accepted_mm).norm() > options_.max_speed_mm_s * track.unseen_s) {
      reject(frame, i, RejectReason::kJump);
    } else {
      track.accepted_mm = position;
      track.unseen_s = 0;
      track.started = true;
    }
  }
}

void Despiker::process(MarkerFrame& frame) noexcept {
  step_s_ = clock_.advance(frame.header.capture_time_ns);
  const bool determined = head_.process(frame);
  for (Track& track : tracks_) track.unseen_s += step_s_;
  for (std::size_t i = 0; i < frame.count; ++i) {
    if (frame.state[i] != MarkerState::kMeasured || head_.measured()[i]) continue;
    const bool finite = to_vector(frame.position_mm[i]).allFinite();
    reject(frame, i, finite ? RejectReason::kDeviation : RejectReason::kNotFinite);
  }
  if (!determined) return;  // without a head there is nothing to judge by
  statistics_.observe(head_.position_head_mm(), head_.measured());
  find_false_markers();
  take_back_plausible();
  accept_or_reject(frame);
  is_settled_ = false;
}

void Despiker::settle() noexcept {
  if (is_settled_) return;
  is_settled_ = true;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (trusted_[i]) learn(i);
  }
  head_.learn(step_s_, trusted_);
  statistics_.learn(step_s_);
  if (frames_to_renewal_-- == 0) {
    neighbours_.renew(statistics_);
    frames_to_renewal_ = kRenewNeighboursFrames;
  }
}

/// How far the marker is from where the others, and its own past, expect it.
Eigen::Vector3d Despiker::stray_mm(std::size_t i) const noexcept {
  const Track& track = tracks_[i];
  const double remembered = std::exp(-track.unseen_s / kOffsetMemoryS);
  return head_.position_head_mm()[i] - statistics_.prediction_mm(i) - remembered * track.offset_mm;
}

double Despiker::allowed_mm(std::size_t i) const noexcept {
  const Track& track = tracks_[i];
  const double forgotten = 1 - std::exp(-2 * track.unseen_s / kOffsetMemoryS);
  const double variance = track.straying_mm2 + forgotten * track.residual_mm2;
  return std::clamp(options_.deviation_multiple * std::sqrt(variance), options_.least_deviation_mm,
                    options_.most_deviation_mm);
}

bool Despiker::too_fast(std::size_t i) const noexcept {
  const Track& track = tracks_[i];
  const double moved = (head_.position_head_mm()[i] - track.accepted_mm).norm();
  return track.started && moved > options_.max_speed_mm_s * track.unseen_s + kSpeedSlackMm;
}

/// A movement that the statistics have not seen yet carries a whole region along; a false track goes alone.
bool Despiker::neighbours_stray_alike(std::size_t i) const noexcept {
  const Eigen::Vector3d own = stray_mm(i);
  const NeighbourGraph::Neighbours& neighbours = neighbours_.of(i);
  int alike = 0;
  for (std::size_t k = 0; k < neighbours.count; ++k) {
    const std::size_t j = neighbours.index[k];
    if (!statistics_.visible(j)) continue;
    alike += (own - stray_mm(j)).norm() < 0.5 * own.norm();
  }
  return alike >= 2;
}

/// Takes the worst marker out and judges the rest again, because its error leans on their predictions.
void Despiker::find_false_markers() noexcept {
  for (std::size_t round = 0; round < tracks_.size(); ++round) {
    double worst_ratio = 1;
    std::size_t worst = tracks_.size();
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      if (!statistics_.visible(i) || !tracks_[i].started) continue;
      const double ratio = stray_mm(i).norm() / allowed_mm(i);
      const bool fast = too_fast(i);
      // A false track begins with a leap: what has come here step by step is a movement that the model does not know.
      const double moved = (head_.position_head_mm()[i] - tracks_[i].accepted_mm).norm();
      if (moved <= options_.least_deviation_mm && tracks_[i].unseen_s <= kGoesOnS) continue;
      if (!fast && (ratio <= worst_ratio || neighbours_stray_alike(i))) continue;
      if (ratio <= worst_ratio && worst != tracks_.size()) continue;
      worst_ratio = std::max(ratio, 1.0);
      worst = i;
    }
    if (worst == tracks_.size()) return;
    statistics_.hide(worst);
    statistics_.update();
  }
}

/// A good marker may have looked false only because of a bad one that was taken out after it. And where a large share
/// looks false it is the model that is: markers on a body, or another face under the same names.
void Despiker::take_back_plausible() noexcept {
  bool changed = false;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (!head_.measured()[i] || statistics_.visible(i)) continue;
    if (too_fast(i) || stray_mm(i).norm() > allowed_mm(i)) continue;
    statistics_.unhide(i);
    changed = true;
  }
  if (changed) statistics_.update();
  double doubted = 0, measured = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    measured += head_.measured()[i];
    doubted += head_.measured()[i] && !statistics_.visible(i);
  }
  if (doubted > kMostFalseShare * measured) {
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      if (head_.measured()[i]) statistics_.unhide(i);
    }
    statistics_.update();
  }
}

void Despiker::accept_or_reject(MarkerFrame& frame) noexcept {
  bool changed = false;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    trusted_[i] = 0;
    if (!head_.measured()[i]) continue;
    if (!statistics_.visible(i) && relabelled(i)) {
      tracks_[i].started = false;
      statistics_.unhide(i);
      changed = true;
    }
    trusted_[i] = statistics_.visible(i);
  }
  if (changed) statistics_.update();
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (!trusted_[i] && head_.measured()[i]) reject(frame, i, reason_of(i));
  }
}

/// Whether a rejected marker has stayed where it is, moving as a marker may, for long enough.
bool Despiker::relabelled(std::size_t i) noexcept {
  Track& track = tracks_[i];
  const Eigen::Vector3d position = head_.position_head_mm()[i];
  const bool steady = (position - track.rejected_mm).norm() <= options_.max_speed_mm_s * step_s_ + kSpeedSlackMm;
  track.stayed_s = steady ? track.stayed_s + step_s_ : step_s_;
  track.rejected_mm = position;
  return track.stayed_s * 1e9 > static_cast<double>(options_.accept_after_ns);
}

void Despiker::learn(std::size_t i) noexcept {
  Track& track = tracks_[i];
  const Eigen::Vector3d residual = statistics_.residual_mm(i);
  if (!track.started) {
    track = Track{};
    track.straying_mm2 = track.residual_mm2 = kPriorStrayingMm2;
    track.offset_mm = residual;
    track.started = true;
  } else {
    // Clipped at what was allowed: a single wild sample must not open the gate for the next.
    const double limit = allowed_mm(i) * allowed_mm(i);
    const double rate = 1 / (kPriorSamples + std::min(track.samples, kMemorySamples));
    track.straying_mm2 += rate * (std::min(stray_mm(i).squaredNorm(), limit) / 3 - track.straying_mm2);
    track.residual_mm2 += rate * (residual.squaredNorm() / 3 - track.residual_mm2);
    track.offset_mm += (1 - std::exp(-track.unseen_s / kOffsetS)) * (residual - track.offset_mm);
    track.samples += 1;
  }
  track.accepted_mm = head_.position_head_mm()[i];
  track.unseen_s = 0;
  track.stayed_s = 0;
}

RejectReason Despiker::reason_of(std::size_t i) const noexcept {
  const auto& position = head_.position_head_mm();
  double nearest_mm = 1e30;
  std::size_t nearest = i;
  for (std::size_t j = 0; j < tracks_.size(); ++j) {
    if (j == i || !head_.measured()[j]) continue;
    // Each of the two is where the other is expected.
    const bool other_false = !statistics_.visible(j);
    if (other_false && (position[i] - statistics_.prediction_mm(j)).norm() <= options_.most_deviation_mm &&
        (position[j] - statistics_.prediction_mm(i)).norm() <= options_.most_deviation_mm) {
      return RejectReason::kSwap;
    }
    const double distance = (position[i] - position[j]).norm();
    if (!other_false && distance < nearest_mm) nearest_mm = distance, nearest = j;
  }
  const double usual_mm = (statistics_.prediction_mm(i) - statistics_.prediction_mm(nearest)).norm();
  if (nearest != i && nearest_mm < kGhostShare * usual_mm && nearest_mm < options_.most_deviation_mm) {
    return RejectReason::kGhost;
  }
  if (too_fast(i)) return RejectReason::kJump;
  const double usual_nearest_mm = neighbours_.of(i).nearest_mm;
  if (usual_nearest_mm > 0 && std::abs(nearest_mm - usual_nearest_mm) > kNeighbourShare * usual_nearest_mm) {
    return RejectReason::kNeighbourDistance;
  }
  return RejectReason::kDeviation;
}

}  // namespace risorius
