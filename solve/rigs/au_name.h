// Names of action units: "AU" + FACS number + optional "L" or "R" (the subject's side), such as "AU12L" or "AU9".
// Other names are legitimate (shapes that FACS does not number) but have no number and no side.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

enum class AuSide : std::uint8_t { kBoth, kLeft, kRight };

struct AuName {
  int number = 0;  ///< FACS number, 1 to 99
  AuSide side = AuSide::kBoth;
  friend bool operator==(const AuName&, const AuName&) = default;
};

/// Empty if the name is not exactly what format_au_name writes (so "AU01", "au1" and "AU12l" have no number).
std::optional<AuName> parse_au_name(std::string_view name) noexcept;

/// "AU12L" from {12, kLeft}.
std::string format_au_name(AuName name);

/// 32-bit FNV-1a over the names, each ended by a newline: the `set_id` of AuFrames of these AUs. Equal names in equal
/// order give an equal id on every machine.
std::uint32_t au_set_id(const std::vector<std::string>& names) noexcept;

}  // namespace risorius
