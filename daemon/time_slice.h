// How long a thread runs before another may have its processor. Linux since 6.12 takes a wish for it without any
// privilege: a thread with short slices, when it wakes, need not wait for one with long slices to finish its own.
// Elsewhere nothing changes.
#pragma once

namespace risorius {

/// Of the calling thread, and of those that it makes from now on: 0.1 ms, the shortest there is. For threads on the
/// way of a frame, which work for less than that and then sleep.
void ask_for_short_slices() noexcept;
/// The system's own again, for threads that nobody waits for.
void ask_for_usual_slices() noexcept;

}  // namespace risorius
