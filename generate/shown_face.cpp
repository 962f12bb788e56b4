#include "generate/shown_face.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <stdexcept>

namespace risorius {
namespace {

/// 73 years either way: no clock goes farther, and sums and differences of what is nearer do not overflow.
constexpr std::int64_t kFarthestNs = std::int64_t{1} << 61U;

using Eigen::Index;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

void require(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(fmt::format("{} {} is not in [{}, {}]", name, value, least, most));
}

double seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) * 1e-9; }

/// s(u): from 0 to 1 with minimum jerk, held outside.
double eased(double u) noexcept {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (10 + u * (-15 + 6 * u));
}

bool has_aus(const AuFrame& frame) noexcept {
  return frame.kind != AuFrameKind::kPredicted &&
         (frame.status == SolverStatus::kConverged || frame.status == SolverStatus::kIterationLimit ||
          frame.status == SolverStatus::kMapped);
}

}  // namespace

std::string_view word_of(ShownOrigin origin) noexcept {
  switch (origin) {
    case ShownOrigin::kSolved:
      return "solved";
    case ShownOrigin::kBridge:
      return "bridge";
    case ShownOrigin::kFade:
      return "fade";
    case ShownOrigin::kRejoin:
      return "rejoin";
    case ShownOrigin::kTarget:
      return "target";
  }
  return "solved";
}

void ShownFace::Memory::add(std::int64_t time_ns, const Values& x) noexcept {
  moments_[next_] = {time_ns, x};
  next_ = (next_ + 1) % moments_.size();
  count_ = std::min(count_ + 1, moments_.size());
}

void ShownFace::Memory::set_back(std::int64_t ns) noexcept {
  for (Moment& moment : moments_) moment.time_ns -= ns;
}

ShownFace::ShownFace(std::vector<double> upper_bound, const ShownOptions& options)
    : upper_bound_(std::move(upper_bound)), options_(options) {
  require("ShownFace: number of AUs", static_cast<double>(upper_bound_.size()), 1, kMaxAus);
  for (const double bound : upper_bound_) require("ShownFace: upper bound", bound, 1e-9, 2);
  require("ShownOptions.max_rate_hz", options.max_rate_hz, 1, 1000);
  require("ShownOptions.bridge_s", options.bridge_s, 0, 2);
  require("ShownOptions.fade_s", options.fade_s, 0.05, 60);
  require("ShownOptions.rejoin_s", options.rejoin_s, 0, 10);
  interval_ns_ = std::llround(1e9 / options.max_rate_hz);
}

void ShownFace::reset() noexcept {
  has_solved_ = has_ended_ = is_bridging_ = is_neutral_ = has_due_ = has_ahead_ = has_target_ = false;
  offset_s_ = 0;
  frames_.clear();
  shown_.clear();
}

/// The source goes on where it stood still, while time was passed in its stead: all that was shown since is moved to
/// before it.
void ShownFace::set_back(std::int64_t ns) noexcept {
  shown_.set_back(ns);
  shown_ns_ -= ns;
  target_began_ns_ -= ns;
  offset_began_ns_ -= ns;
}

bool ShownFace::process(const AuFrame& frame, ShownFrame& out) noexcept {
  if (frame.count != upper_bound_.size()) return false;
  const std::int64_t now_ns = frame.header.capture_time_ns;
  if (now_ns < -kFarthestNs || now_ns > kFarthestNs) return false;
  std::optional<Values> before;  // of the take before this one, which is rejoined: clocks may have begun anew
  if (has_solved_ && frame.header.set_id != solved_.header.set_id) {
    reset();
  } else if (has_ended_ || (has_solved_ && now_ns < last_ns_)) {
    if (!has_aus(frame)) {
      end();
      return false;
    }
    if (shown_.size() > 0) before = shown_[0].x;
    reset();
  }
  last_ns_ = now_ns;
  if (has_aus(frame)) {
    Values x{};
    for (std::size_t au = 0; au < upper_bound_.size(); ++au) x[au] = static_cast<float>(frame.intensity[au]);
    if (before) change_source(now_ns, *before, x, options_.rejoin_s);
    const bool has_stood_still = is_bridging_ && shown_.size() > 0 && shown_ns_ > now_ns;
    if (has_stood_still) set_back(shown_ns_ - now_ns);
    if (is_bridging_ && !has_target_) {
      const Values shown = has_stood_still ? shown_[0].x : with_offset(live_source(now_ns), now_ns);
      change_source(now_ns, shown, x, options_.rejoin_s);
    }
    is_bridging_ = is_neutral_ = false;
    has_solved_ = true;
    solved_ = frame;
    frames_.add(now_ns, x);
  } else if (has_solved_) {
    is_bridging_ = true;
    solved_.header.sequence = frame.header.sequence;
  }
  if (!has_solved_ || (is_neutral_ && !has_target_) || !is_due(now_ns)) return false;
  show(now_ns, out);
  return true;
}

/// On a grid, as the Continuer's (continuation.cpp).
bool ShownFace::is_due(std::int64_t time_ns) noexcept {
  if (!has_due_) due_ns_ = time_ns;
  has_due_ = true;
  if (time_ns < due_ns_ - interval_ns_ / 4) return false;
  due_ns_ = time_ns > due_ns_ + interval_ns_ ? time_ns + interval_ns_ : due_ns_ + interval_ns_;
  return true;
}

void ShownFace::use(const Continuation& continuation) noexcept {
  if (continuation.au_count != upper_bound_.size()) return;
  for (std::size_t back = 0; back < frames_.size(); ++back) {
    if (frames_[back].time_ns != continuation.header.capture_time_ns) continue;
    ahead_ = continuation;
    ahead_from_ = frames_[back].x;
    has_ahead_ = true;
    return;
  }
}

bool ShownFace::pass(std::int64_t silence_ns, ShownFrame& out) noexcept {
  if (!has_solved_ || silence_ns <= 0 || (is_neutral_ && !has_target_)) return false;
  is_bridging_ = true;
  show(last_ns_ + silence_ns, out);
  return true;
}

void ShownFace::note_time(std::int64_t silence_ns) noexcept {
  if (!is_neutral_ || has_target_ || silence_ns <= 0) return;
  shown_ns_ = last_ns_ + silence_ns;
  shown_.clear();
  shown_.add(shown_ns_, Values{});
}

void ShownFace::show(std::int64_t time_ns, ShownFrame& out) noexcept {
  if (has_target_ && seconds(time_ns - target_began_ns_) >= target_.seconds + target_.hold_s) {
    change_source(time_ns, with_offset(target_source(time_ns), time_ns), live_source(time_ns), target_.return_s);
    has_target_ = false;
  }
  const double silent_s = silence_s(time_ns);
  out.origin = has_target_                ? ShownOrigin::kTarget
               : is_bridging_             ? (silent_s <= options_.bridge_s ? ShownOrigin::kBridge : ShownOrigin::kFade)
               : offset_left(time_ns) > 0 ? ShownOrigin::kRejoin
                                          : ShownOrigin::kSolved;
  const Values x = with_offset(has_target_ ? target_source(time_ns) : live_source(time_ns), time_ns);
  out.aus = solved_;
  out.aus.header.capture_time_ns = time_ns;
  if (out.origin != ShownOrigin::kSolved) out.aus.kind = AuFrameKind::kPredicted;
  for (std::size_t au = 0; au < upper_bound_.size(); ++au) {
    out.aus.intensity[au] = x[au];
    if (out.origin == ShownOrigin::kSolved) continue;
    out.aus.standard_deviation[au] = deviation_of(au, out.origin, silent_s);
    if (has_target_) out.aus.state[au] = AuState::kHeld;  // known, though nobody observes it
  }
  shown_ns_ = time_ns;
  shown_.add(time_ns, x);
  const bool has_faded = is_bridging_ && silent_s >= options_.bridge_s + options_.fade_s;
  is_neutral_ = has_faded && !has_target_ && offset_left(time_ns) <= 0;
}

double ShownFace::silence_s(std::int64_t time_ns) const noexcept {
  return seconds(difference_ns(time_ns, solved_.header.capture_time_ns));
}

ShownFace::Values ShownFace::live_source(std::int64_t time_ns) const noexcept {
  Values x{};
  const double silent_s = silence_s(time_ns);
  for (std::size_t au = 0; au < upper_bound_.size(); ++au)
    x[au] = is_bridging_ ? bridged(au, silent_s) : static_cast<float>(solved_.intensity[au]);
  return x;
}

/// The continuation, moved so that it starts at the last frame; then the way to neutral.
float ShownFace::bridged(std::size_t au, double ahead_s) const noexcept {
  const auto last = static_cast<float>(solved_.intensity[au]);
  const bool predictable = has_ahead_ && !std::isnan(ahead_.standard_deviation[0][au]);
  float value = last;
  if (predictable) {
    const double lag_s = silence_s(ahead_.header.capture_time_ns) * -1;
    value = continued(au, lag_s + std::min(ahead_s, options_.bridge_s)) + (last - continued(au, lag_s));
  }
  const double left = 1 - eased((ahead_s - options_.bridge_s) / options_.fade_s);
  return std::clamp(value, 0.0F, static_cast<float>(upper_bound_[au])) * static_cast<float>(left);
}

/// Monotone cubic (Fritsch & Butland 1984) through the frame that is continued and the predictions; held behind the
/// last.
float ShownFace::continued(std::size_t au, double ahead_s) const noexcept {
  const std::size_t last = std::min<std::size_t>(ahead_.step_count, kMaxContinuationSteps);
  std::size_t node = 0;  // the one before ahead_s
  while (node < last && seconds(ahead_.ahead_ns[node]) <= ahead_s) ++node;
  if (node == last) return last == 0 ? ahead_from_[au] : ahead_.intensity[last - 1][au];

  // Up to four nodes around: before, from, to, after.
  struct Node {
    double time_s, value;
  };
  const auto at = [&](std::size_t n) {
    return n == 0 ? Node{0, ahead_from_[au]} : Node{seconds(ahead_.ahead_ns[n - 1]), ahead_.intensity[n - 1][au]};
  };
  const Node from = at(node), to = at(node + 1);
  const auto secant = [](const Node& a, const Node& b) { return (b.value - a.value) / (b.time_s - a.time_s); };
  const auto slope = [&](const Node& before, const Node& here, const Node& after) {
    const double left = secant(before, here), right = secant(here, after);
    if (left * right <= 0) return 0.0;
    const double h = here.time_s - before.time_s, k = after.time_s - here.time_s;
    return 3 * (h + k) / ((2 * k + h) / left + (k + 2 * h) / right);
  };
  const double slope_from = node == 0 ? secant(from, to) : slope(at(node - 1), from, to);
  const double slope_to = node + 1 == last ? 0 : slope(from, to, at(node + 2));
  const double width = to.time_s - from.time_s, u = std::max(0.0, ahead_s - from.time_s) / width;
  const double u2 = u * u, u3 = u2 * u, share = 3 * u2 - 2 * u3;
  return static_cast<float>(from.value * (1 - share) + to.value * share +
                            width * ((u3 - 2 * u2 + u) * slope_from + (u3 - u2) * slope_to));
}

float ShownFace::deviation_of(std::size_t au, ShownOrigin origin, double silent_s) const noexcept {
  if (origin != ShownOrigin::kBridge || !has_ahead_ || ahead_.step_count == 0) return kNone;
  const double ahead_s =
      silent_s + seconds(difference_ns(solved_.header.capture_time_ns, ahead_.header.capture_time_ns));
  double before_s = 0, before = 0;
  for (std::size_t step = 0; step < ahead_.step_count; ++step) {
    const double at_s = seconds(ahead_.ahead_ns[step]), here = ahead_.standard_deviation[step][au];
    if (ahead_s <= at_s) return static_cast<float>(before + (here - before) * (ahead_s - before_s) / (at_s - before_s));
    before_s = at_s;
    before = here;
  }
  return static_cast<float>(before);
}

double ShownFace::offset_left(std::int64_t time_ns) const noexcept {
  return offset_s_ > 0 ? 1 - eased(seconds(difference_ns(time_ns, offset_began_ns_)) / offset_s_) : 0;
}

ShownFace::Values ShownFace::with_offset(const Values& source, std::int64_t time_ns) const noexcept {
  const auto left = static_cast<float>(offset_left(time_ns));
  if (left <= 0) return source;
  Values x = source;
  for (std::size_t au = 0; au < upper_bound_.size(); ++au)
    x[au] = std::clamp(source[au] + left * offset_[au], 0.0F, static_cast<float>(upper_bound_[au]));
  return x;
}

void ShownFace::change_source(std::int64_t time_ns, const Values& shown, const Values& source,
                              double duration_s) noexcept {
  for (std::size_t au = 0; au < upper_bound_.size(); ++au) offset_[au] = shown[au] - source[au];
  offset_began_ns_ = time_ns;
  offset_s_ = duration_s;
}

TransitionRequest ShownFace::request_of(const LiveTarget& target) const {
  require("seconds", target.seconds, 1e-3, 60);
  require("hold", target.hold_s, 0, 3600);
  require("return", target.return_s, 0, 60);
  const auto aus = static_cast<Index>(upper_bound_.size());
  if (target.target.size() != aus || !target.target.allFinite())
    throw std::invalid_argument("ShownFace: a target of another number of AUs, or one that is not finite");
  if (shown_.size() == 0) throw std::invalid_argument("ShownFace: nothing was shown yet");
  TransitionRequest request{.past = AuMatrix(kPastFrames, aus),
                            .target = target.target,
                            .frames = std::max<Index>(1, std::llround(target.seconds * kTransitionRate_hz)),
                            .rate_hz = kTransitionRate_hz};
  std::size_t back = 0;
  for (Index row = kPastFrames - 1; row >= 0; --row) {
    const double wanted_s = static_cast<double>(kPastFrames - 1 - row) / kTransitionRate_hz;
    const auto age_s = [&](std::size_t b) { return seconds(shown_ns_ - shown_[b].time_ns); };
    while (back + 1 < shown_.size() && age_s(back + 1) < wanted_s) ++back;
    const bool has_older = back + 1 < shown_.size();
    const double step_s = has_older ? age_s(back + 1) - age_s(back) : 0;
    const double share = step_s > 0 ? std::clamp((wanted_s - age_s(back)) / step_s, 0.0, 1.0) : 0;
    const Moment &newer = shown_[back], &older = shown_[has_older ? back + 1 : back];
    for (Index au = 0; au < aus; ++au) {
      const auto i = static_cast<std::size_t>(au);
      request.past(row, au) = newer.x[i] + static_cast<float>(share) * (older.x[i] - newer.x[i]);
    }
  }
  return request;
}

void ShownFace::follow(const LiveTarget& target, const TransitionRequest& request, AuMatrix course,
                       std::int64_t began_ns) noexcept {
  const auto aus = static_cast<Index>(upper_bound_.size());
  if (!has_solved_ || shown_.size() == 0 || course.rows() < 1 || course.cols() != aus) return;
  const Values before = shown_[0].x;
  has_target_ = true;
  is_neutral_ = false;
  target_ = target;
  course_ = std::move(course);
  for (Index au = 0; au < aus; ++au) course_start_[static_cast<std::size_t>(au)] = request.past(kPastFrames - 1, au);
  target_began_ns_ = began_ns;
  // The face went on while the course was made.
  change_source(shown_ns_, before, target_source(shown_ns_), options_.rejoin_s);
}

ShownFace::Values ShownFace::target_source(std::int64_t time_ns) const noexcept {
  const double at = std::clamp(seconds(difference_ns(time_ns, target_began_ns_)) * kTransitionRate_hz, 0.0,
                               static_cast<double>(course_.rows()));  // row k is at k + 1
  const auto row = static_cast<Index>(at);
  const auto share = static_cast<float>(at - static_cast<double>(row));
  Values x{};
  for (std::size_t au = 0; au < upper_bound_.size(); ++au) {
    const auto column = static_cast<Index>(au);
    const Index to = std::min(row, course_.rows() - 1);
    const float from = row == 0 ? course_start_[au] : course_(row - 1, column);
    x[au] = std::clamp(from + share * (course_(to, column) - from), 0.0F, static_cast<float>(upper_bound_[au]));
  }
  return x;
}

void ShownFace::release() noexcept {
  if (!has_target_) return;
  has_target_ = false;
  is_neutral_ = false;  // what is left of the target has to fade
  change_source(shown_ns_, shown_[0].x, live_source(shown_ns_), target_.return_s);
}

}  // namespace risorius
