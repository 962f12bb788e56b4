#include "replay/takes/c3d_parameters.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace risorius {
namespace {

char upper(char c) noexcept { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

bool same_name(std::string_view a, std::string_view b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return upper(x) == upper(y); });
}

/// Names of groups and parameters are printable ASCII; anything else means that we are not reading parameters any more.
bool is_plausible_name(std::string_view name) noexcept {
  return std::all_of(name.begin(), name.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

std::string trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return static_cast<unsigned char>(c) <= ' '; };
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  return std::string(text.substr(0, text.find('\0')));
}

}  // namespace

C3dParameters::C3dParameters(std::span<const std::uint8_t> section, C3dProcessor processor,
                             std::vector<std::string>& warnings)
    : processor_(processor) {
  constexpr std::size_t kSectionHeaderBytes = 4;  // reserved, key, number of blocks, processor
  std::size_t at = kSectionHeaderBytes;
  while (const auto next = read_record(section, at, warnings)) at = *next;
  const std::size_t declared_blocks = section.size() < kSectionHeaderBytes ? 0 : section[2];
  if (declared_blocks > 0 && at > declared_blocks * kC3dBlockBytes)
    warnings.push_back("the parameter section is longer than the " + std::to_string(declared_blocks) +
                       " blocks that it declares");
}

std::optional<std::size_t> C3dParameters::read_record(std::span<const std::uint8_t> section, std::size_t at,
                                                      std::vector<std::string>& warnings) {
  // Record: name length (negative = locked), group id (negative = a group), name, offset to the next record, body.
  if (at + 2 > section.size() || section[at] == 0) return {};
  const auto signed_byte = [&](std::size_t place) {
    return static_cast<int>(static_cast<std::int8_t>(section[place]));
  };
  const auto name_bytes = static_cast<std::size_t>(std::abs(signed_byte(at)));
  const int id = signed_byte(at + 1);
  const std::size_t offset_at = at + 2 + name_bytes;
  const bool fits = offset_at + 2 <= section.size();
  const std::string name(reinterpret_cast<const char*>(section.data()) + at + 2, fits ? name_bytes : 0);
  if (!fits || id == 0 || !is_plausible_name(name)) {
    warnings.push_back("the parameter section is damaged at its byte " + std::to_string(at) +
                       ": what follows was not read");
    return {};
  }
  const std::size_t offset = c3d_word(section.data() + offset_at, processor_);
  const std::size_t next = offset_at + offset;
  const bool is_last = offset == 0;
  const std::size_t end = is_last ? section.size() : std::min(section.size(), next);
  const std::size_t body_at = std::min(offset_at + 2, end);
  if (id < 0) {
    groups_.push_back({-id, name});
  } else if (!read_parameter(section.subspan(body_at, end - body_at), {.group_id = id, .name = name}, warnings)) {
    return {};
  }
  if (is_last) return {};
  if (offset < 2 || next > section.size()) {
    warnings.push_back("the parameter after " + name + " lies outside the section: what follows was not read");
    return {};
  }
  return next;
}

bool C3dParameters::read_parameter(std::span<const std::uint8_t> body, Parameter parameter,
                                   std::vector<std::string>& warnings) {
  const int type = body.empty() ? 0 : static_cast<std::int8_t>(body[0]);
  const std::size_t dimension_count = body.size() < 2 ? 0 : body[1];
  if ((type != -1 && type != 1 && type != 2 && type != 4) || dimension_count > 7 || body.size() < 2 + dimension_count) {
    warnings.push_back("parameter " + parameter.name + " has no valid type: what follows was not read");
    return false;
  }
  parameter.type = static_cast<Type>(type);
  const auto dimensions = body.subspan(2, dimension_count);
  parameter.dimensions.assign(dimensions.begin(), dimensions.end());
  const auto data = body.subspan(2 + dimension_count);
  std::size_t declared = static_cast<std::size_t>(std::abs(type));
  for (const std::uint8_t dimension : dimensions) declared = std::min<std::size_t>(declared * dimension, 1u << 24);
  if (declared > data.size())
    warnings.push_back("parameter " + parameter.name + " declares " + std::to_string(declared) + " bytes and has " +
                       std::to_string(data.size()));
  parameter.bytes.assign(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(std::min(declared, data.size())));
  parameters_.push_back(std::move(parameter));
  return true;
}

const C3dParameters::Parameter* C3dParameters::find(std::string_view group, std::string_view name) const noexcept {
  for (const Group& candidate : groups_) {
    if (!same_name(candidate.name, group)) continue;
    for (const Parameter& parameter : parameters_)
      if (parameter.group_id == candidate.id && same_name(parameter.name, name)) return &parameter;
  }
  return nullptr;
}

std::optional<std::uint64_t> C3dParameters::count(std::string_view group, std::string_view name) const noexcept {
  const Parameter* parameter = find(group, name);
  if (parameter == nullptr) return {};
  const std::uint8_t* bytes = parameter->bytes.data();
  const std::size_t size = parameter->bytes.size();
  if (parameter->type == Type::kFloat && size >= 4) {
    const float value = c3d_float(bytes, processor_);
    if (value >= 0 && value < 4294967296.0f && std::floor(value) == value) return static_cast<std::uint64_t>(value);
  } else if (parameter->type == Type::kInteger && size >= 2) {
    const std::uint64_t high = size >= 4 ? c3d_word(bytes + 2, processor_) : 0;
    return (high << 16) | c3d_word(bytes, processor_);
  }
  return {};
}

std::optional<float> C3dParameters::number(std::string_view group, std::string_view name) const noexcept {
  const Parameter* parameter = find(group, name);
  if (parameter == nullptr || parameter->type != Type::kFloat || parameter->bytes.size() < 4) return {};
  return c3d_float(parameter->bytes.data(), processor_);
}

std::vector<std::string> C3dParameters::texts(std::string_view group, std::string_view name) const {
  const Parameter* parameter = find(group, name);
  if (parameter == nullptr || parameter->type != Type::kText) return {};
  const std::string_view text(reinterpret_cast<const char*>(parameter->bytes.data()), parameter->bytes.size());
  const std::size_t width = parameter->dimensions.empty() ? 1 : parameter->dimensions[0];
  std::vector<std::string> rows;
  if (width == 0) return rows;
  // A last row that the section cut short still has its beginning.
  for (std::size_t at = 0; at < text.size(); at += width) rows.push_back(trimmed(text.substr(at, width)));
  return rows;
}

}  // namespace risorius
