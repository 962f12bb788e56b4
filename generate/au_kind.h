// What a network that shares its weights over AUs is told of an AU's name: which part of the face it moves, and which
// AU is its other side.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

enum class AuKind : std::uint8_t { kBrow, kLid, kMidface, kMouth, kJaw, kOther };
/// Kinds that a network is told; of kOther it hears nothing.
inline constexpr std::size_t kAuKinds = 5;

/// By FACS number ("AU12L" is 12), and mouthLeft and mouthRight.
AuKind kind_of_au(std::string_view name) noexcept;

/// Column of the other side ("AU12R" for "AU12L", "mouthRight" for "mouthLeft"); its own where there is none.
std::vector<std::size_t> other_sides(const std::vector<std::string>& names);

}  // namespace risorius
