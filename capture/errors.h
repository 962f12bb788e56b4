// The error of a user's mistake: a file, key or value that the program cannot work with.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace risorius {

/// What a file or command line holds, fit for a message: at most `longest` bytes, with no control characters.
inline std::string shown(std::string_view text, std::size_t longest = 80) {
  std::string result(text.substr(0, longest));
  // Not in the middle of a UTF-8 character.
  const auto continues = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U; };
  while (result.size() < text.size() && !result.empty() && continues(result.size())) result.pop_back();
  for (char& c : result) c = static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  if (text.size() > longest) result += "...";
  return result;
}

/// Thrown with a message that names the place (file, key, line), what was found there, and what to do about it.
/// Caught once, in main; libraries never print or exit.
class UserError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// "PLACE: PROBLEM (REMEDY)"
  UserError(const std::string& place, const std::string& problem, const std::string& remedy)
      : std::runtime_error(place + ": " + problem + (remedy.empty() ? "" : " (" + remedy + ")")) {}
};

}  // namespace risorius
