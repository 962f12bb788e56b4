// The error of a user's mistake: a file, key or value that the program cannot work with.
#pragma once

#include <stdexcept>
#include <string>

namespace risorius {

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
