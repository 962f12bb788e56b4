// An actor profile: one folder that keeps together what belongs to one person.
//
//     anna/actor.json   format, version, pseudonym, date, note, names, gains, neutrals
//     anna/rig.json     the rig
//
// `names` maps a tracker's marker names to the rig's ({"LMouth": "Mouth_Lend"}); `gains` multiplies intensities
// ({"AU12L": 1.1}: this actor's smile reads 10 % stronger); `neutrals` are the neutrals of sessions, newest last, as
// positions of the rig's markers in the head frame. The rig of an actor has all three applied.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "solve/rigs/rig.h"

namespace risorius {

inline constexpr const char* kActorFile = "actor.json";

struct ActorNeutral {
  std::string date;                                    ///< YYYY-MM-DD
  std::string place;                                   ///< "TAKE:FROM-TO"
  std::map<std::string, Eigen::Vector3d> position_mm;  ///< by the rig's marker
};

struct Actor {
  std::string pseudonym, date, note;
  std::map<std::string, std::string> names;
  std::map<std::string, double> gains;  ///< above 0, at most 10
  std::vector<ActorNeutral> neutrals;
  Rig rig;  ///< as it stands in rig.json
};

bool is_actor_folder(const std::filesystem::path& folder);

/// Throws UserError naming file, field, value and remedy; also where names, gains or neutrals do not fit the rig.
Actor load_actor(const std::filesystem::path& folder);

/// Makes the folder, or replaces its files atomically. Throws UserError.
void save_actor(const Actor& actor, const std::filesystem::path& folder);

/// The rig with the newest neutral, the tracker's names and the gains.
Rig rig_of_actor(const Actor& actor);

/// A rig file, or an actor's folder. Throws UserError.
Rig load_rig_or_actor(const std::filesystem::path& path);

}  // namespace risorius
