// The words and letters by which messages and tables name the states of frames.
#pragma once

#include <string>
#include <string_view>

#include "capture/frames.h"

namespace risorius {

std::string_view word_of(SolverStatus status) noexcept;
std::string_view word_of(AuFrameKind kind) noexcept;
std::string_view word_of(RejectReason reason) noexcept;
/// "HH:MM:SS:FF", or "HH:MM:SS;FF" if frames are dropped from the count (SMPTE 12M); empty if there is none.
std::string text_of(const Timecode& timecode);
/// '.' measured, 'f' filled, 'r' rejected and not filled, 'o' missing.
char letter_of(MarkerState state) noexcept;
/// 'o' observed, 'h' held, '-' not observed.
char letter_of(AuState state) noexcept;

}  // namespace risorius
