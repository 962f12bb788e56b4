#include "capture/frame_words.h"

namespace risorius {

std::string_view word_of(SolverStatus status) noexcept {
  switch (status) {
    case SolverStatus::kNotSolved:
      return "not_solved";
    case SolverStatus::kConverged:
      return "converged";
    case SolverStatus::kIterationLimit:
      return "iteration_limit";
    case SolverStatus::kPoorFit:
      return "poor_fit";
    case SolverStatus::kTooFewMarkers:
      return "too_few_markers";
    case SolverStatus::kMirrored:
      return "mirrored";
    case SolverStatus::kMapped:
      return "mapped";
    case SolverStatus::kNoFace:
      return "no_face";
  }
  return "not_solved";
}

std::string_view word_of(AuFrameKind kind) noexcept {
  switch (kind) {
    case AuFrameKind::kSolved:
      return "solved";
    case AuFrameKind::kPredicted:
      return "predicted";
    case AuFrameKind::kMapped:
      return "mapped";
  }
  return "solved";
}

std::string_view word_of(RejectReason reason) noexcept {
  switch (reason) {
    case RejectReason::kNone:
      return "none";
    case RejectReason::kJump:
      return "jump";
    case RejectReason::kDeviation:
      return "deviation";
    case RejectReason::kNeighbourDistance:
      return "neighbour_distance";
    case RejectReason::kGhost:
      return "ghost";
    case RejectReason::kSwap:
      return "swap";
    case RejectReason::kNotFinite:
      return "not_finite";
  }
  return "none";
}

std::string text_of(const Timecode& timecode) {
  if (timecode.frame_rate == 0) return {};
  std::string text;
  const auto two_digits = [&](unsigned value) {
    if (value < 10) text += '0';
    text += std::to_string(value);
  };
  two_digits(timecode.hours);
  text += ':';
  two_digits(timecode.minutes);
  text += ':';
  two_digits(timecode.seconds);
  text += timecode.drop_frame ? ';' : ':';
  two_digits(timecode.frames);
  return text;
}

char letter_of(MarkerState state) noexcept {
  switch (state) {
    case MarkerState::kMeasured:
      return '.';
    case MarkerState::kFilled:
      return 'f';
    case MarkerState::kRejected:
      return 'r';
    case MarkerState::kMissing:
      return 'o';
  }
  return 'o';
}

char letter_of(AuState state) noexcept {
  switch (state) {
    case AuState::kObserved:
      return 'o';
    case AuState::kHeld:
      return 'h';
    case AuState::kNotObserved:
      return '-';
  }
  return '-';
}

}  // namespace risorius
