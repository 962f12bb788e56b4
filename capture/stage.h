// A stage is a block on a chip: push a value in, pop values out until there are none, flush at the end of a take.
//
//   in --valid--> [ push | ... | pop ] --valid--> out
//      <-ready---                      <--ready--
//
// It has no thread, clock, socket, file or log. Time comes in the frames; where it must act without one, as a Tick.
// What a frame still has to teach a stage once it has been handed on may wait for an optional `settle()`, off the frame's
// way; a push that finds it undone does it first, so that no value depends on who calls it when.
// Constructors and `use_marker_set` validate and allocate; push, pop, tick and flush do neither and are noexcept.
#pragma once

#include <concepts>

#include "capture/counters.h"
#include "capture/frames.h"

namespace risorius {

/// push returns false when the stage is not ready: nothing was consumed, the caller keeps the value, pops, and pushes
/// again.
template <class S, class In, class Out>
concept Stage = requires(S s, const S& cs, const In& in, Out& out, Tick t) {
  { s.push(in) }
  noexcept->std::same_as<bool>;
  { s.pop(out) }
  noexcept->std::same_as<bool>;
  { s.tick(t) }
  noexcept;
  { s.flush() }
  noexcept;
  { cs.ledger() }
  noexcept->std::same_as<const StageLedger&>;
};

}  // namespace risorius
