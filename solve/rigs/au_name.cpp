#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

constexpr std::string_view kPrefix = "AU";
constexpr std::uint32_t kFnvOffset = 2166136261u;
constexpr std::uint32_t kFnvPrime = 16777619u;

std::uint32_t fnv1a(std::uint32_t hash, char byte) noexcept {
  return (hash ^ static_cast<std::uint8_t>(byte)) * kFnvPrime;
}

}  // namespace

std::optional<AuName> parse_au_name(std::string_view name) noexcept {
  if (!name.starts_with(kPrefix)) return std::nullopt;
  name.remove_prefix(kPrefix.size());
  AuName result;
  if (name.ends_with('L')) result.side = AuSide::kLeft;
  if (name.ends_with('R')) result.side = AuSide::kRight;
  if (result.side != AuSide::kBoth) name.remove_suffix(1);
  if (name.empty() || name.size() > 2 || name.front() == '0') return std::nullopt;
  for (const char digit : name) {
    if (digit < '0' || digit > '9') return std::nullopt;
    result.number = 10 * result.number + (digit - '0');
  }
  return result;
}

std::string format_au_name(AuName name) {
  std::string text = std::string(kPrefix) + std::to_string(name.number);
  if (name.side == AuSide::kLeft) text += 'L';
  if (name.side == AuSide::kRight) text += 'R';
  return text;
}

std::uint32_t au_set_id(const std::vector<std::string>& names) noexcept {
  std::uint32_t hash = kFnvOffset;
  for (const std::string& name : names) {
    for (const char byte : name) hash = fnv1a(hash, byte);
    hash = fnv1a(hash, '\n');
  }
  return hash;
}

}  // namespace risorius
