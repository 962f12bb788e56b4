#include "replay/commands/number_check.h"

#include <fmt/format.h>

#include "capture/errors.h"
#include "replay/takes/csv_text.h"

namespace risorius {
namespace {

constexpr std::string_view kAuto = "auto";

}  // namespace

CLI::Validator number_between(double least, double most) {
  const std::string range = fmt::format("{:g} to {:g}", least, most);
  return {[=](const std::string& text) -> std::string {
            const auto value = parse_double(text);
            if (value && *value >= least && *value <= most) return {};
            return fmt::format("\"{}\" is not a number from {}", shown(text), range);
          },
          range, "number_between"};
}

CLI::Validator number_or_auto(double least, double most) {
  const std::string range = fmt::format("{:g} to {:g}", least, most);
  return {[=](const std::string& text) -> std::string {
            const auto value = number_unless_auto(text);
            if (text == kAuto || (value && *value >= least && *value <= most)) return {};
            return fmt::format("\"{}\" is neither \"auto\" nor a number from {}", shown(text), range);
          },
          range + " or auto", "number_or_auto"};
}

CLI::Validator count_or_auto(std::uint64_t most) {
  const std::string range = fmt::format("1 to {}", most);
  return {[=](const std::string& text) -> std::string {
            const auto value = number_unless_auto(text);
            const bool is_count = value && *value >= 1 && *value <= static_cast<double>(most) &&
                                  text.find_first_not_of("0123456789") == std::string::npos;
            if (text == kAuto || is_count) return {};
            return fmt::format("\"{}\" is neither \"auto\" nor a whole number from {}", shown(text), range);
          },
          range + " or auto", "count_or_auto"};
}

std::optional<double> number_unless_auto(const std::string& text) {
  return text == kAuto ? std::nullopt : parse_double(text);
}

CLI::Validator whole_number() {
  return {[](const std::string& text) -> std::string {
            const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
            return digits ? "" : fmt::format("\"{}\" is not a whole number from 0", shown(text));
          },
          "0 or more", "whole_number"};
}

}  // namespace risorius
