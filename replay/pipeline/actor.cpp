#include "replay/pipeline/actor.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/errors.h"
#include "replay/atomic_file.h"
#include "solve/rigs/json_depth.h"

namespace risorius {
namespace {

using Json = nlohmann::json;

constexpr double kMostGain = 10;

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || !std::filesystem::is_regular_file(path))
    throw UserError(path.string(), "cannot be read", "check the path");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string text_of(const Json& root, const char* key, const std::string& place) {
  const auto found = root.find(key);
  if (found == root.end()) return {};
  if (!found->is_string()) throw UserError(place, fmt::format("\"{}\" is not a text", key), "put it in quotes");
  return found->get<std::string>();
}

const Json& object_of(const Json& root, const char* key, const std::string& place) {
  static const Json kEmpty = Json::object();
  const auto found = root.find(key);
  if (found == root.end()) return kEmpty;
  if (!found->is_object()) throw UserError(place, fmt::format("\"{}\" is not an object", key), "write {\"NAME\": ...}");
  return *found;
}

void read_names(const Json& root, const std::string& place, Actor& actor) {
  std::set<std::string> used;
  for (const auto& [tracker, marker] : object_of(root, "names", place).items()) {
    const bool is_marker = marker.is_string() && std::ranges::find(actor.rig.marker_names, marker.get<std::string>()) !=
                                                     actor.rig.marker_names.end();
    if (!is_marker)
      throw UserError(place, fmt::format("names.{} = {} is no marker of the rig", shown(tracker), shown(marker.dump())),
                      fmt::format("the rig has {}", fmt::join(actor.rig.marker_names, " ")));
    if (!used.insert(marker.get<std::string>()).second)
      throw UserError(place, fmt::format("names: {} is given twice", marker.get<std::string>()),
                      "map each marker once");
    actor.names.emplace(tracker, marker.get<std::string>());
  }
}

void read_gains(const Json& root, const std::string& place, Actor& actor) {
  for (const auto& [au, gain] : object_of(root, "gains", place).items()) {
    if (std::ranges::find(actor.rig.aus, au, &RigAu::name) == actor.rig.aus.end()) {
      throw UserError(place, fmt::format("gains.{}: the rig has no such AU", shown(au)),
                      fmt::format("it has {}", fmt::join(actor.rig.au_names(), " ")));
    }
    if (!gain.is_number() || !(gain.get<double>() > 0 && gain.get<double>() <= kMostGain)) {
      throw UserError(place, fmt::format("gains.{} = {} is no gain", au, shown(gain.dump())),
                      "give a number above 0, at most 10");
    }
    actor.gains.emplace(au, gain.get<double>());
  }
}

void read_neutrals(const Json& root, const std::string& place, Actor& actor) {
  const auto found = root.find("neutrals");
  if (found == root.end()) return;
  if (!found->is_array())
    throw UserError(place, "\"neutrals\" is not a list",
                    "write [{\"date\": ..., \"place\": ..., \"position_mm\": {...}}]");
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Json& entry = (*found)[i];
    const std::string where = fmt::format("{}: neutrals[{}]", place, i);
    if (!entry.is_object())
      throw UserError(where, "is not an object", "write {\"date\": ..., \"place\": ..., \"position_mm\": {...}}");
    ActorNeutral neutral{
        .date = text_of(entry, "date", where), .place = text_of(entry, "place", where), .position_mm = {}};
    for (const auto& [marker, p] : object_of(entry, "position_mm", where).items()) {
      const bool good =
          p.is_array() && p.size() == 3 && std::ranges::all_of(p, [](const Json& v) { return v.is_number(); });
      if (!good || std::ranges::find(actor.rig.marker_names, marker) == actor.rig.marker_names.end()) {
        throw UserError(
            where,
            fmt::format("position_mm.{} = {} is no position of a marker of the rig", shown(marker), shown(p.dump())),
            "write [x, y, z] in mm");
      }
      neutral.position_mm.emplace(marker, Eigen::Vector3d(p[0].get<double>(), p[1].get<double>(), p[2].get<double>()));
    }
    actor.neutrals.push_back(std::move(neutral));
  }
}

}  // namespace

bool is_actor_folder(const std::filesystem::path& folder) {
  return std::filesystem::is_regular_file(folder / kActorFile);
}

Actor load_actor(const std::filesystem::path& folder) {
  const std::string place = (folder / kActorFile).string();
  const std::string text = read_file(folder / kActorFile);
  if (nests_too_deep(text)) throw UserError(place, "nests too deep", "see replay/README.md, \"Actors\"");
  const Json root = Json::parse(text, nullptr, false);
  if (!root.is_object()) throw UserError(place, "not a JSON object", "see replay/README.md, \"Actors\"");
  if (root.value("format", Json()) != "risorius-actor" || root.value("version", Json()) != 1) {
    throw UserError(place, "is no actor profile of version 1", "make one with risorius actor new");
  }
  for (const auto& [key, value] : root.items()) {
    static const std::set<std::string> kKnown{"format", "version", "pseudonym", "date",
                                              "note",   "names",   "gains",     "neutrals"};
    if (!kKnown.contains(key))
      throw UserError(place, fmt::format("key \"{}\" is not known", shown(key)),
                      fmt::format("known are {}", fmt::join(kKnown, " ")));
  }
  Actor actor{.pseudonym = text_of(root, "pseudonym", place),
              .date = text_of(root, "date", place),
              .note = text_of(root, "note", place),
              .rig = load_rig(folder / "rig.json")};
  read_names(root, place, actor);
  read_gains(root, place, actor);
  read_neutrals(root, place, actor);
  static_cast<void>(rig_of_actor(actor));
  return actor;
}

void save_actor(const Actor& actor, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw UserError(folder.string(), "cannot make this folder: " + error.message(), "choose another");
  save_rig(actor.rig, folder / "rig.json");
  Json root{{"format", "risorius-actor"},   {"version", 1},
            {"pseudonym", actor.pseudonym}, {"date", actor.date},
            {"note", actor.note},           {"names", actor.names},
            {"gains", actor.gains},         {"neutrals", Json::array()}};
  for (const ActorNeutral& neutral : actor.neutrals) {
    Json positions = Json::object();
    for (const auto& [marker, p] : neutral.position_mm) positions[marker] = {p.x(), p.y(), p.z()};
    root["neutrals"].push_back({{"date", neutral.date}, {"place", neutral.place}, {"position_mm", positions}});
  }
  AtomicFile file(folder / kActorFile);
  file.write(root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  file.commit();
}

Rig rig_of_actor(const Actor& actor) {
  Rig rig = actor.rig;
  if (!actor.neutrals.empty()) {
    const ActorNeutral& newest = actor.neutrals.back();
    for (std::size_t m = 0; m < rig.marker_count(); ++m) {
      const auto found = newest.position_mm.find(rig.marker_names[m]);
      if (found != newest.position_mm.end()) rig.neutral_mm.col(static_cast<Eigen::Index>(m)) = found->second;
    }
    rig.source += "; neutral of " + newest.place;
  }
  // Twice the gain, half the field: the same markers read twice the intensity.
  for (RigAu& au : rig.aus) {
    const auto found = actor.gains.find(au.name);
    if (found != actor.gains.end()) au.displacement_mm /= found->second;
  }
  for (const auto& [tracker, marker] : actor.names) {
    const auto found = std::ranges::find(actor.rig.marker_names, marker);
    if (found != actor.rig.marker_names.end())
      rig.marker_names[static_cast<std::size_t>(found - actor.rig.marker_names.begin())] = tracker;
  }
  if (const auto problems = problems_of(rig); !problems.empty()) {
    throw UserError("actor " + actor.pseudonym, problems.front(), "correct names, gains and neutrals in actor.json");
  }
  return rig;
}

Rig load_rig_or_actor(const std::filesystem::path& path) {
  return is_actor_folder(path) ? rig_of_actor(load_actor(path)) : load_rig(path);
}

}  // namespace risorius
