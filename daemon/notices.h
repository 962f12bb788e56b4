// What somebody at the daemon's terminal should hear of while it runs: a source that comes, falls silent or is lost,
// frames without AUs and why, neutrals, refused datagrams and losses. Each thing once, a growing loss again when it has
// doubled.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace risorius {

class Notices {
 public:
  /// What is new in a status (Service::status) against the one before, as lines without line ends.
  std::vector<std::string> update(const nlohmann::json& status);

 private:
  struct Stream {
    std::string state, rig_problem, absent_markers, unsolved;
    std::map<std::string, std::uint64_t> by_status;
    std::uint64_t neutral_captures = 0, neutral_failures = 0, slips = 0;
    bool time_stood = false;
  };

  void update_stream(const std::string& name, const nlohmann::json& stream, std::vector<std::string>& lines);
  /// The solver's status that most frames since the last update have; empty if there were none.
  static std::string commonest_status(const nlohmann::json& stream, Stream& before);

  std::map<std::string, Stream> streams_;
  std::map<std::string, std::string> record_problems_;  ///< by where they stand
  std::map<std::string, std::uint64_t> told_;           ///< losses, by where and name
};

}  // namespace risorius
