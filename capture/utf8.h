// Names go into JSON, CSV and web pages: whatever is not clean UTF-8 stays outside, or is mended at the door.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace risorius {

/// The length of the UTF-8 character at the front of `text` (RFC 3629), 0 if it is malformed or a control character.
std::size_t utf8_length(std::string_view text) noexcept;

/// Well-formed, and without control characters.
bool is_clean_utf8(std::string_view text) noexcept;

/// Text of an old program's file: as it is if it is clean, else each byte that is not part of UTF-8 as the character
/// that it is in Latin-1 (or '?' for a control character).
std::string utf8_of(std::string_view bytes);

}  // namespace risorius
