// What this program is: recorded with every session, because results are bit-equal only within one version and
// instruction set.
#pragma once

namespace risorius {

inline constexpr const char* kVersion = RISORIUS_VERSION;
inline constexpr const char* kInstructionSet = RISORIUS_INSTRUCTION_SET;

}  // namespace risorius
