// How deep a JSON text of a user's file may nest. The JSON library prints and copies values by recursion: 100 kB of
// opening brackets would end the program for want of stack.
#pragma once

#include <cstddef>
#include <string_view>

namespace risorius {

inline constexpr std::size_t kDeepestJson = 64;

/// Of a text that is no JSON the answer means nothing; it will not be parsed.
inline bool nests_too_deep(std::string_view json) noexcept {
  std::size_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\') ++i;
      in_string = c != '"';
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepestJson) return true;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return false;
}

}  // namespace risorius
