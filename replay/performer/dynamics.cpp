#include "replay/performer/dynamics.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "replay/shipped_json.h"

namespace risorius {
namespace {

using Json = nlohmann::ordered_json;

/// Reads numbers by their path, such as "onset_s.median", within a range.
class Fields {
 public:
  Fields(const Json& root, std::string place) : root_(root), place_(std::move(place)) {}

  double number(const char* group, const char* field, double least, double most) const {
    const Json* at = &root_;
    for (const char* key : {group, field}) {
      if (key == nullptr) continue;
      const auto found = at->is_object() ? at->find(key) : at->end();
      if (found == at->end()) fail(group, field, "is missing", least, most);
      at = &*found;
    }
    if (!at->is_number() || !(at->get<double>() >= least && at->get<double>() <= most))
      fail(group, field, "= " + at->dump(), least, most);
    return at->get<double>();
  }
  LogNormal log_normal(const char* group, double most) const {
    return {number(group, "median", 1e-3, most), number(group, "sigma", 0, 2)};
  }
  Wander wander(const char* group) const {
    return {number(group, "deviation", 0, 0.2), number(group, "time_constant_s", 1e-3, 1e3)};
  }

 private:
  [[noreturn]] void fail(const char* group, const char* field, const std::string& problem, double least,
                         double most) const {
    std::string name = group;
    if (field != nullptr) name += "." + std::string(field);
    throw UserError(place_, name + " " + problem,
                    "a number from " + Json(least).dump() + " to " + Json(most).dump() +
                        "; risorius perform-fit writes such files");
  }
  const Json& root_;
  std::string place_;
};

Json json_of(const LogNormal& d) { return {{"median", d.median}, {"sigma", d.sigma}}; }
Json json_of(const Wander& w) { return {{"deviation", w.deviation}, {"time_constant_s", w.time_constant_s}}; }

}  // namespace

double LogNormal::draw(Random& random) const noexcept {
  return median * std::exp(sigma * std::clamp(random.gaussian(), -2.5, 2.5));
}

double LogNormal::p90() const noexcept { return median * std::exp(1.2815515655446004 * sigma); }

Dynamics parse_dynamics(std::string_view json, const std::string& place) {
  const Json root = Json::parse(json, nullptr, false);
  if (!root.is_object() || root.value("format", Json()) != "risorius-dynamics")
    throw UserError(place, "no \"format\": \"risorius-dynamics\"", "risorius perform-fit writes such files");
  if (root.value("version", Json()) != 1)
    throw UserError(place, "version " + root.value("version", Json()).dump() + " is not known",
                    "this program reads version 1");
  const Fields fields(root, place);
  Dynamics d;
  for (const auto& [key, text] : {std::pair{"source", &d.source}, {"licence", &d.licence}, {"made_by", &d.made_by}}) {
    if (const Json value = root.value(key, Json("")); value.is_string()) *text = value.get<std::string>();
  }
  d.onset_s = fields.log_normal("onset_s", 10);
  d.hold_s = fields.log_normal("hold_s", 60);
  d.offset_s = fields.log_normal("offset_s", 10);
  d.rest_s = fields.log_normal("rest_s", 60);
  d.peak = fields.log_normal("peak", 1);
  d.repeat_probability = fields.number("repeat_probability", nullptr, 0, 0.95);
  d.onset_skew = fields.number("onset_skew", nullptr, 0.3, 3);
  d.offset_skew = fields.number("offset_skew", nullptr, 0.3, 3);
  d.side_lag_s = fields.number("side_lag_s", nullptr, 0, 0.5);
  d.side_gain = fields.number("side_gain", nullptr, 0, 1);
  d.micro_motion = fields.wander("micro_motion");
  d.rest_drift = fields.wander("rest_drift");
  const Json co_actions = root.value("co_actions", Json::object());
  for (const auto& [au, list] : co_actions.items()) {
    for (const auto& [other, pair] : list.items()) {
      const bool good = pair.is_array() && pair.size() == 2 && pair[0].is_number() && pair[1].is_number();
      if (!good)
        throw UserError(place, "co_actions." + au + "." + other + " = " + pair.dump(), "write [PROBABILITY, RATIO]");
      d.co_actions[au].push_back({other, pair[0].get<double>(), pair[1].get<double>()});
    }
  }
  return d;
}

Dynamics load_dynamics(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || !std::filesystem::is_regular_file(path))
    throw UserError(path.string(), "cannot be read", "check the path");
  const std::string json((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return parse_dynamics(json, path.string());
}

const Dynamics& shipped_dynamics() {
  static const Dynamics dynamics = parse_dynamics(shipped_json("dynamics"), "dynamics");
  return dynamics;
}

std::string dynamics_to_json(const Dynamics& d) {
  Json root{{"format", "risorius-dynamics"},
            {"version", 1},
            {"source", d.source},
            {"licence", d.licence},
            {"made_by", d.made_by},
            {"onset_s", json_of(d.onset_s)},
            {"hold_s", json_of(d.hold_s)},
            {"offset_s", json_of(d.offset_s)},
            {"rest_s", json_of(d.rest_s)},
            {"peak", json_of(d.peak)},
            {"repeat_probability", d.repeat_probability},
            {"onset_skew", d.onset_skew},
            {"offset_skew", d.offset_skew},
            {"side_lag_s", d.side_lag_s},
            {"side_gain", d.side_gain},
            {"micro_motion", json_of(d.micro_motion)},
            {"rest_drift", json_of(d.rest_drift)}};
  Json co_actions = Json::object();
  for (const auto& [au, list] : d.co_actions) {
    Json others = Json::object();
    for (const CoAction& action : list) others[action.au] = Json::array({action.probability, action.ratio});
    co_actions[au] = others;
  }
  root["co_actions"] = co_actions;
  return root.dump(1) + "\n";
}

}  // namespace risorius
