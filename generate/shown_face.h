// What an avatar is shown of a live face: solved frames as they are; while none come, the continuation, and after a
// limit the way to the neutral face; on command the way to a target. Continuous in value, whatever it changes between:
//
//   shown(t) = source(t) + (shown(t_c) - source(t_c)) (1 - s((t - t_c) / D)),   s(u) = 10 u^3 - 15 u^4 + 6 u^5
//
// t_c is the last change to a source whose value was another one there: frames that come again, a target that ends.
// A bridge starts where the frames ended, and a transition where the face is, so that these need no such term.
//
// Of measured frames nothing is changed: this stands beside them. Times are capture times. process, use and pass do not
// allocate. One thread, or a lock around it.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "capture/frames.h"
#include "generate/transition.h"

namespace risorius {

/// kSolved: the frame's own values, solved or mapped. kBridge: predicted, since no frame has AUs. kFade: the same, on
/// its way to neutral. kRejoin: frames again, and what is shown runs into them. kTarget: on its way to a target, or
/// there.
enum class ShownOrigin : std::uint8_t { kSolved, kBridge, kFade, kRejoin, kTarget };
std::string_view word_of(ShownOrigin origin) noexcept;

struct ShownFrame {
  /// Kind predicted, unless the origin is kSolved; header's sequence is that of the last frame.
  AuFrame aus;
  ShownOrigin origin = ShownOrigin::kSolved;
};

struct ShownOptions {
  double max_rate_hz = 60;  ///< [1, 1000], of capture time
  double bridge_s = 0.5;    ///< [0, 2]: how long predictions stand for frames
  double fade_s = 1;        ///< [0.05, 60]: the way to neutral after that
  double rejoin_s = 0.15;   ///< [0, 10]: the way back to the frames
};

/// What a target asks for.
struct LiveTarget {
  Eigen::VectorXf target;  ///< one intensity per AU
  double seconds = 1;      ///< of the way there, (0, 60]
  double hold_s = 1;       ///< there, [0, 3600]
  double return_s = 1;     ///< of the way back to the frames, [0, 60]
};

class ShownFace {
 public:
  /// Rate at which transitions are asked for, and frames of past that they are given.
  static constexpr double kTransitionRate_hz = 120;
  static constexpr Eigen::Index kPastFrames = 20;

  /// `upper_bound` per AU, 1 to kMaxAus. Throws std::invalid_argument.
  explicit ShownFace(std::vector<double> upper_bound, const ShownOptions& options = {});

  /// A frame that was handed on, with AUs or without. True if `out` was written: at most max_rate_hz times a second.
  bool process(const AuFrame& frame, ShownFrame& out) noexcept;
  /// The continuation of a frame that was processed.
  void use(const Continuation& continuation) noexcept;
  /// `silence_ns` after the last frame, and no other has come. False if there is nothing to show: no frame yet, or the
  /// face is neutral by now.
  bool pass(std::int64_t silence_ns, ShownFrame& out) noexcept;
  /// The take ended: until another one brings a face, time passes as in silence.
  void end() noexcept { has_ended_ = has_solved_; }
  bool has_ended() const noexcept { return has_ended_; }

  /// Time has come to `silence_ns` after the last frame: for requests, also where the face has gone neutral and pass()
  /// has shown nothing since.
  void note_time(std::int64_t silence_ns) noexcept;

  /// Whether there is a face that can go somewhere.
  bool has_face() const noexcept { return has_solved_; }
  /// Whether pass() has something to show while no frames come.
  bool is_showing() const noexcept { return has_solved_ && !is_neutral_; }

  /// The request that leads to a target from what is shown now; to be generated anywhere. Allocates.
  TransitionRequest request_of(const LiveTarget& target) const;
  /// The time of what was shown last: where such a request begins.
  std::int64_t now_ns() const noexcept { return shown_ns_; }
  /// Follows `course`, which was generated of `request` and began when `began_ns` was the time.
  void follow(const LiveTarget& target, const TransitionRequest& request, AuMatrix course,
              std::int64_t began_ns) noexcept;
  /// Back to the frames, in the target's return_s.
  void release() noexcept;
  bool has_target() const noexcept { return has_target_; }

 private:
  using Values = std::array<float, kMaxAus>;
  struct Moment {
    std::int64_t time_ns = 0;
    Values x{};
  };
  /// What was, the youngest first.
  class Memory {
   public:
    void add(std::int64_t time_ns, const Values& x) noexcept;
    void clear() noexcept { next_ = count_ = 0; }
    void set_back(std::int64_t ns) noexcept;
    std::size_t size() const noexcept { return count_; }
    const Moment& operator[](std::size_t back) const noexcept {
      return moments_[(next_ + moments_.size() - 1 - back) % moments_.size()];
    }

   private:
    std::vector<Moment> moments_ = std::vector<Moment>(64);
    std::size_t next_ = 0, count_ = 0;
  };

  void reset() noexcept;
  void set_back(std::int64_t ns) noexcept;
  bool is_due(std::int64_t time_ns) noexcept;
  void show(std::int64_t time_ns, ShownFrame& out) noexcept;
  /// What would be shown without target and offset: the last solved frame, or its bridge.
  Values live_source(std::int64_t time_ns) const noexcept;
  float bridged(std::size_t au, double ahead_s) const noexcept;
  float continued(std::size_t au, double ahead_s) const noexcept;
  float deviation_of(std::size_t au, ShownOrigin origin, double silence_s) const noexcept;
  Values target_source(std::int64_t time_ns) const noexcept;
  double offset_left(std::int64_t time_ns) const noexcept;
  Values with_offset(const Values& source, std::int64_t time_ns) const noexcept;
  void change_source(std::int64_t time_ns, const Values& shown, const Values& source, double seconds) noexcept;
  double silence_s(std::int64_t time_ns) const noexcept;

  std::vector<double> upper_bound_;
  ShownOptions options_;
  std::int64_t interval_ns_;

  AuFrame solved_;  // the last frame with AUs
  bool has_solved_ = false, has_ended_ = false, is_bridging_ = false, is_neutral_ = false;
  std::int64_t last_ns_ = 0;  // of the last frame of all
  std::int64_t due_ns_ = 0;
  bool has_due_ = false;

  Continuation ahead_;
  Values ahead_from_{};  // the frame that it continues
  bool has_ahead_ = false;

  Values offset_{};
  std::int64_t offset_began_ns_ = 0;
  double offset_s_ = 0;

  bool has_target_ = false;
  LiveTarget target_;
  AuMatrix course_;
  Values course_start_{};  // of the request's past
  std::int64_t target_began_ns_ = 0;

  std::int64_t shown_ns_ = 0;
  Memory frames_, shown_;
};

}  // namespace risorius
