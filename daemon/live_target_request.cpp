#include "daemon/live_target_request.h"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "replay/performer/expression_vector.h"

namespace risorius {
namespace {

constexpr double kMostIntensityAsked = 1.2;

/// JSON itself has no NaN, and would say null.
std::string shown_number(const nlohmann::json& value) {
  if (value.is_number()) return fmt::format("{}", value.get<double>());
  return shown(value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

double number_of(const nlohmann::json& request, const char* key, double fallback, double least, double most) {
  if (!request.contains(key)) return fallback;
  const nlohmann::json& value = request.at(key);
  if (!value.is_number() || !(value.get<double>() >= least && value.get<double>() <= most))
    throw UserError(key, fmt::format("{} is out of range", shown_number(value)),
                    fmt::format("give a number from {:g} to {:g}{}", least, most,
                                std::string_view(key) == "seconds" ? ", or \"auto\"" : ""));
  return value.get<double>();
}

Eigen::VectorXf vector_of(const nlohmann::json& aus, const std::vector<std::string>& au_names) {
  if (!aus.is_object() || aus.empty())
    throw UserError("au", "is no map of AUs",
                    "write {\"AU12L\": 0.8, \"AU12R\": 0.8}; those that are not named become 0");
  Eigen::VectorXf target = Eigen::VectorXf::Zero(static_cast<Eigen::Index>(au_names.size()));
  for (const auto& [name, value] : aus.items()) {
    const auto found = std::find(au_names.begin(), au_names.end(), name);
    if (found == au_names.end()) {
      std::string names;
      for (const auto& known : au_names) names += (names.empty() ? "" : ", ") + known;
      throw UserError("au", "the stream has no \"" + shown(name) + "\"", "it has " + names);
    }
    target[found - au_names.begin()] = static_cast<float>(number_of(aus, name.c_str(), 0, 0, kMostIntensityAsked));
  }
  return target;
}

}  // namespace

LiveTargetRequest live_target_of(const nlohmann::json& request, const std::vector<std::string>& au_names) {
  for (const auto& [key, value] : request.items()) {
    const bool fits = key == "command" || (key == "stream" && value.is_string()) ||
                      (key == "expression" && value.is_string()) || key == "au" || key == "seconds" ||
                      key == "hold_seconds" || key == "return_seconds";
    if (!fits) {
      throw UserError(shown(key), "is not known here",
                      "give stream, expression (texts) or au (a map), seconds, hold_seconds, return_seconds (numbers; "
                      "seconds may be \"auto\")");
    }
  }
  if (request.contains("expression") == request.contains("au"))
    throw UserError("go_to", "one target is needed", "give an expression, or au: a map of AUs");
  LiveTargetRequest result{request.value("stream", std::string()), {}, {}};
  if (request.contains("au")) {
    result.target.target = vector_of(request.at("au"), au_names);
  } else {
    ExpressionVector expression = expression_vector(request.at("expression").get<std::string>(), au_names);
    result.masked = std::move(expression.masked);
    result.target.target =
        Eigen::Map<const Eigen::VectorXd>(expression.intensities.data(), static_cast<Eigen::Index>(au_names.size()))
            .cast<float>();
  }
  result.is_seconds_auto = request.value("seconds", nlohmann::json()) == "auto";
  result.is_return_auto = result.is_seconds_auto && !request.contains("return_seconds");
  if (!result.is_seconds_auto) result.target.seconds = number_of(request, "seconds", 1, 0.01, 60);
  result.target.hold_s = number_of(request, "hold_seconds", 1, 0, 3600);
  result.target.return_s = number_of(request, "return_seconds", result.target.seconds, 0, 60);
  return result;
}

}  // namespace risorius
