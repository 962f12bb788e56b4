#include "replay/performer/dynamics.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "capture/errors.h"
#include "replay/shipped_json.h"

namespace risorius {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 2;  // 1 had co-activations by pairs

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

struct TimingField {
  const char* name;
  double Timing::*value;
  double most;
};
constexpr TimingField kTimingFields[] = {{"lag_s", &Timing::lag_s, 0.5},
                                         {"pace", &Timing::pace, 1.5},
                                         {"split_probability", &Timing::split_probability, 1},
                                         {"split_share", &Timing::split_share, 1},
                                         {"split_gap", &Timing::split_gap, 3},
                                         {"shifts_per_second", &Timing::shifts_per_second, 20},
                                         {"shift_renewal", &Timing::shift_renewal, 1},
                                         {"apex_shift", &Timing::apex_shift, 1},
                                         {"persistence", &Timing::persistence, 0.99}};

/// Four decimals: more would be noise, and the file is read by people.
double rounded(double value) { return std::round(1e4 * value) / 1e4; }

Json json_of(const PostureTable& postures) {
  Json shares = PostureTable::kShares, levels = Json::object(), correlation = Json::object();
  for (std::size_t i = 0; i < postures.aus.size(); ++i) {
    Json& of_au = levels[postures.aus[i]] = Json::array();
    for (const double level : postures.levels[i]) of_au.push_back(rounded(level));
    Json& with_earlier = correlation[postures.aus[i]] = Json::array();
    for (std::size_t j = 0; j < i; ++j)
      with_earlier.push_back(rounded(postures.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j))));
  }
  return {{"shares", shares}, {"levels", levels}, {"correlation", correlation}};
}

/// `count` numbers from `least` to `most`.
std::vector<double> numbers_of(const Json& list, std::size_t count, double least, double most, const std::string& field,
                               const std::string& place) {
  const auto is_good = [&](const Json& value) {
    return value.is_number() && value.get<double>() >= least && value.get<double>() <= most;
  };
  if (!list.is_array() || list.size() != count || !std::all_of(list.begin(), list.end(), is_good))
    throw UserError(place, field + " = " + list.dump(),
                    "write " + std::to_string(count) + " numbers from " + Json(least).dump() + " to " +
                        Json(most).dump() + "; risorius perform-fit writes such files");
  return list.get<std::vector<double>>();
}

PostureTable parse_postures(const Json& json, const std::string& place) {
  PostureTable postures;
  const auto object_of = [&](const char* field) {
    const Json object = json.is_object() ? json.value(field, Json::object()) : Json();
    if (!object.is_object())
      throw UserError(place, std::string("postures.") + field + " is no object",
                      "risorius perform-fit writes such files");
    return object;
  };
  const Json levels = object_of("levels"), correlation = object_of("correlation");
  const auto count = static_cast<Eigen::Index>(levels.size());
  postures.correlation = Eigen::MatrixXd::Identity(count, count);
  for (const auto& [au, list] : levels.items()) {
    const std::size_t i = postures.aus.size();
    const auto of_au = numbers_of(list, PostureTable::kShares.size(), 0, 1.2, "postures.levels." + au, place);
    if (!std::is_sorted(of_au.begin(), of_au.end()))
      throw UserError(place, "postures.levels." + au + " falls", "quantiles must not fall");
    std::copy(of_au.begin(), of_au.end(), postures.levels.emplace_back().begin());
    const auto row = numbers_of(correlation.value(au, Json()), i, -1, 1, "postures.correlation." + au, place);
    for (std::size_t j = 0; j < i; ++j) {
      const auto r = static_cast<Eigen::Index>(i), c = static_cast<Eigen::Index>(j);
      postures.correlation(r, c) = postures.correlation(c, r) = row[j];
    }
    postures.aus.push_back(au);
  }
  try {
    PostureSampler{postures};
  } catch (const std::invalid_argument&) {
    throw UserError(place, "postures.correlation is not positive definite",
                    "no set of AUs has these correlations; risorius perform-fit writes such files");
  }
  return postures;
}

}  // namespace

double LogNormal::draw(Random& random) const noexcept {
  return median * std::exp(sigma * std::clamp(random.gaussian(), -2.5, 2.5));
}

double LogNormal::p90() const noexcept { return median * std::exp(1.2815515655446004 * sigma); }

Dynamics parse_dynamics(std::string_view json, const std::string& place) {
  const Json root = Json::parse(json, nullptr, false);
  if (!root.is_object() || root.value("format", Json()) != "risorius-dynamics")
    throw UserError(place, "no \"format\": \"risorius-dynamics\"", "risorius perform-fit writes such files");
  if (root.value("version", Json()) != kVersion)
    throw UserError(place, "version " + root.value("version", Json()).dump() + " is not known",
                    "this program reads version 2; risorius perform-fit writes it");
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
  d.follower_gain = fields.number("follower_gain", nullptr, 0, 2);
  for (const TimingField& field : kTimingFields)
    d.timing.*field.value = fields.number("timing", field.name, 0, field.most);
  d.postures = parse_postures(root.value("postures", Json::object()), place);
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
            {"version", kVersion},
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
  Json timing = Json::object();
  for (const TimingField& field : kTimingFields) timing[field.name] = d.timing.*field.value;
  root["follower_gain"] = d.follower_gain;
  root["timing"] = timing;
  root["postures"] = json_of(d.postures);
  return root.dump(1) + "\n";
}

}  // namespace risorius
