#include "solve/faces/landmark_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "solve/faces/shipped_maps.h"
#include "solve/rigs/json_depth.h"

namespace risorius {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::string_view, 5> kKeys{"format", "version", "name", "landmarks", "stabilisers"};

/// A member that must be there; `remedy` says what it looks like.
const Json& member(const Json& object, const char* key, const std::string& place, const std::string& remedy) {
  const auto found = object.find(key);
  if (found == object.end()) throw UserError(place, std::string("no \"") + key + "\"", remedy);
  return *found;
}

void read_landmarks(const Json& landmarks, const std::string& place, LandmarkMap& map) {
  const std::string remedy = R"(write "landmarks": {"mouth_corner_left": "MARKER", ...})";
  if (!landmarks.is_object()) throw UserError(place, "\"landmarks\" is not an object", remedy);
  std::map<std::string, std::string> landmark_of_marker;
  for (const auto& [landmark, marker] : landmarks.items()) {
    if (!marker.is_string() || marker.get_ref<const std::string&>().empty()) {
      throw UserError(place, "landmarks." + landmark + " is not a marker name", remedy);
    }
    const auto [other, is_new] = landmark_of_marker.emplace(marker.get<std::string>(), landmark);
    if (!is_new) {
      throw UserError(place, "marker " + other->first + " is given to both " + other->second + " and " + landmark,
                      "give each landmark its own marker");
    }
    map.marker_of_landmark.emplace(landmark, marker.get<std::string>());
  }
}

void read_stabilisers(const Json& stabilisers, const std::string& place, LandmarkMap& map) {
  const std::string remedy = R"(write "stabilisers": {"MARKER": 1, ...} or leave it out)";
  if (!stabilisers.is_object()) throw UserError(place, "\"stabilisers\" is not an object", remedy);
  for (const auto& [marker, weight] : stabilisers.items()) {
    const bool good = weight.is_number() && std::isfinite(weight.get<double>()) && weight.get<double>() > 0;
    if (!good) throw UserError(place, "stabilisers." + marker + " = " + weight.dump() + " is not a weight > 0", remedy);
    map.stabiliser_weight.emplace(marker, weight.get<double>());
  }
}

}  // namespace

LandmarkMap parse_landmark_map(std::string_view json, const std::string& place) {
  if (nests_too_deep(json)) throw UserError(place, "nests too deep", "see solve/faces/landmark_map.h for the format");
  const Json root = Json::parse(json, nullptr, false);
  if (!root.is_object()) throw UserError(place, "not a JSON object", "see solve/faces/landmark_map.h for the format");
  if (root.value("format", Json()) != "risorius-landmarks") {
    throw UserError(place, "\"format\" is not \"risorius-landmarks\"", "is this a landmark map?");
  }
  if (root.value("version", Json()) != 1) {
    throw UserError(place, "version " + root.value("version", Json()).dump() + " is not known",
                    "this program reads version 1");
  }
  for (const auto& [key, value] : root.items()) {
    if (std::ranges::find(kKeys, key) == kKeys.end())
      throw UserError(place, "unknown key \"" + key + "\"",
                      "known here: format, version, name, landmarks, stabilisers");
  }
  LandmarkMap map;
  const Json& name = member(root, "name", place, R"(write "name": "LAYOUT")");
  if (!name.is_string()) throw UserError(place, "\"name\" is not a string", R"(write "name": "LAYOUT")");
  map.name = name.get<std::string>();
  read_landmarks(member(root, "landmarks", place, R"(write "landmarks": {"mouth_corner_left": "MARKER", ...})"), place,
                 map);
  if (const auto found = root.find("stabilisers"); found != root.end()) read_stabilisers(*found, place, map);
  return map;
}

LandmarkMap load_landmark_map(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  // A folder opens, too, and fails only when read.
  if (!file || !std::filesystem::is_regular_file(path))
    throw UserError(path.string(), "cannot be read", "check the path");
  const std::string json((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return parse_landmark_map(json, path.string());
}

LandmarkMap find_landmark_map(const std::string& name_or_path) {
  std::string shipped_names;
  for (const ShippedMap& shipped : shipped_landmark_maps()) {
    if (shipped.name == name_or_path) return parse_landmark_map(shipped.json, name_or_path);
    shipped_names += (shipped_names.empty() ? "" : ", ") + std::string(shipped.name);
  }
  if (!std::filesystem::exists(name_or_path)) {
    throw UserError(name_or_path, "no such landmark map", "give a file, or one of: " + shipped_names);
  }
  return load_landmark_map(name_or_path);
}

}  // namespace risorius
