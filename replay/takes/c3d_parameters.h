// The parameter section of a C3D file: named groups of named arrays. Everything in it is untrusted: a parameter never
// holds more bytes than its record has, and reading stops with a warning where the section stops making sense.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "replay/takes/c3d_numbers.h"

namespace risorius {

class C3dParameters {
 public:
  C3dParameters() = default;
  /// `section` starts at its own four-byte header and ends where the data begins. Appends to `warnings`.
  C3dParameters(std::span<const std::uint8_t> section, C3dProcessor processor, std::vector<std::string>& warnings);

  bool has(std::string_view group, std::string_view name) const noexcept { return find(group, name) != nullptr; }
  /// The first value as an unsigned count: a 16-bit integer (negative means above 32767), a float with a whole value,
  /// or two 16-bit integers (low word first). Empty if absent or none of these.
  std::optional<std::uint64_t> count(std::string_view group, std::string_view name) const noexcept;
  /// The first value of a float parameter.
  std::optional<float> number(std::string_view group, std::string_view name) const noexcept;
  /// The rows of a character parameter without trailing blanks; empty if absent.
  std::vector<std::string> texts(std::string_view group, std::string_view name) const;

 private:
  enum class Type : std::int8_t { kText = -1, kByte = 1, kInteger = 2, kFloat = 4 };
  struct Parameter {
    int group_id = 0;
    std::string name;
    Type type = Type::kByte;
    std::vector<std::uint8_t> dimensions;
    std::vector<std::uint8_t> bytes;
  };
  struct Group {
    int id = 0;
    std::string name;
  };

  const Parameter* find(std::string_view group, std::string_view name) const noexcept;
  /// Reads the record at `at`; gives the place of the next one, if there is one.
  std::optional<std::size_t> read_record(std::span<const std::uint8_t> section, std::size_t at,
                                         std::vector<std::string>& warnings);
  bool read_parameter(std::span<const std::uint8_t> body, Parameter parameter, std::vector<std::string>& warnings);

  C3dProcessor processor_ = C3dProcessor::kIntel;
  std::vector<Group> groups_;
  std::vector<Parameter> parameters_;
};

}  // namespace risorius
