#include "fuzz/text_targets.h"

#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "daemon/config.h"
#include "daemon/control_request.h"
#include "solve/faces/landmark_map.h"
#include "solve/rigs/rig.h"

namespace risorius::fuzz {

void run_rig(std::span<const std::byte> input) {
  try {
    const Rig rig = parse_rig(as_text(input), "input");
    require(problems_of(rig).empty(), "a rig that was read has no problems");
    const std::string written = rig_to_json(rig);
    require(rig_to_json(parse_rig(written, "again")) == written, "written and read, it is the same");
  } catch (const UserError&) {
  }
}

std::vector<Bytes> rig_seeds() {
  return {bytes_of(R"({"format": "risorius-rig", "version": 1, "name": "anna", "facs_edition": "2002", "source": "seed",
"markers": [{"name": "a", "neutral_mm": [0, 0, 0], "stabiliser_weight": 1, "fit_distance_mm": 0.5},
 {"name": "b", "neutral_mm": [10, 0, 0], "stabiliser_weight": 1, "fit_distance_mm": 0},
 {"name": "c", "neutral_mm": [0, 10.5, 0], "stabiliser_weight": 1, "fit_distance_mm": 1},
 {"name": "d", "neutral_mm": [0, -10, 5e0], "stabiliser_weight": 0, "fit_distance_mm": 1}],
"aus": [{"name": "AU12L", "upper_bound": 1.2, "displacement_mm": [[0, 0, 0], [0, 0, 0], [0, 0, 0], [1, 2, 3]]},
 {"name": "jawForward", "displacement_mm": [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 1]]}]})")};
}

void run_landmarks(std::span<const std::byte> input) {
  try {
    parse_landmark_map(as_text(input), "input");
  } catch (const UserError&) {
  }
}

std::vector<Bytes> landmark_seeds() {
  return {bytes_of(R"({"format": "risorius-landmarks", "version": 1, "name": "mylab", "landmarks": {"chin": "Chin",
"mouth_corner_left": "ML", "mouth_corner_right": "MR", "nose_tip": "N", "brow_inner_left": "BL"},
"stabilisers": {"Head": 1, "N": 0.5}})")};
}

void run_config(std::span<const std::byte> input) {
  try {
    const std::string printed = print_config(parse_config(as_text(input), "input"));
    require(print_config(parse_config(printed, "again")) == printed, "printed and read, it is the same");
  } catch (const UserError&) {
  }
}

std::vector<Bytes> config_seeds() {
  return {bytes_of(print_config(default_config())),
          bytes_of("[output]\nstatus_interval_s = 0.5\n[reorder]\ndepth = 4\n[[source]]\nname = \"a\"\nlisten = "
                   "\"udp://127.0.0.1:0\"\nunits = \"cm\"\naxes = \"LUF\"\n[source.fill]\nmax_gap_s = 1\n[[source]]\n"
                   "name = \"b\"\nlisten = \"natnet://host\"\n")};
}

void run_control(std::span<const std::byte> input) {
  // As the control server's socket has it.
  if (input.size() > kMostRequestBytes) return;
  try {
    const nlohmann::json request = parse_control_request(input);
    require(request.at("command").is_string(), "a request has a command");
    // The service shows people what they sent, in messages that are encoded again.
    nlohmann::json::to_msgpack({{"ok", false}, {"error", request.at("command")}});
    request.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  } catch (const UserError&) {
  } catch (const nlohmann::json::exception&) {
    // The parsers' own refusals; the server answers with their text.
  }
}

std::vector<Bytes> control_seeds() {
  const nlohmann::json neutral{{"command", "capture_neutral"}, {"stream", "anna"}, {"seconds", 1.5}};
  const auto packed = nlohmann::json::to_msgpack(neutral);
  const auto bytes = std::as_bytes(std::span(packed));
  return {{bytes.begin(), bytes.end()},
          bytes_of(neutral.dump()),
          bytes_of(R"({"command": "status", "x": [1, {"y": null}]})")};
}

}  // namespace risorius::fuzz
