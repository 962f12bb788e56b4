// What the service is told: a TOML file in which every key has a default, or no file at all. daemon/README.md lists the
// keys; `risoriusd --print-config` prints the effective ones with their meaning.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "generate/transition_models.h"
#include "replay/pipeline/stage_config.h"

namespace risorius {

/// One [[source]] table: a stream with its own rig, sets and state.
struct SourceConfig {
  std::string name = "face";
  std::string listen = "udp://127.0.0.1:7000";
  std::string rig = "builtin";
  std::string neutral;  ///< "TAKE:FROM-TO", "TAKE:auto"; "" = the rig's own
  std::string units;    ///< "" = as the sender states
  std::string axes;     ///< "" = as the sender states
  std::string zmq_pattern = "pull";
  std::int64_t zmq_high_water_mark = 1000;
  std::string curve_key, curve_clients;  ///< as of OutputConfig
  std::string natnet_markers;            ///< "", "labelled" or "set:NAME": NatnetMarkerMap::build
  std::string natnet_local_address;      ///< "" = by routing
  std::string natnet_multicast_group;    ///< "" = as the server says
  std::int64_t natnet_data_port = 0;     ///< 0 = as the server says
  std::string natnet_timecode = "30";
  std::string qtm_frames = "tcp";
  std::string qtm_label_prefix;
  std::string vicon_subject;
  double vicon_rate_hz = 0;     ///< 0 = as the server states
  std::string livelink_device;  ///< "" = the first that sends
  double livelink_rate_hz = 0;  ///< 0 = as the packets say
  std::int64_t receive_buffer_bytes = 8 << 20;
  StageConfig stages;
};

/// What NatNet does not tell of its timecode.
struct NatnetTimecode {
  std::uint8_t rate = 30;
  bool drop_frame = false;
};
/// "24", "25", "30", "30df", "50" or "60"; empty if it is none of them.
std::optional<NatnetTimecode> parse_natnet_timecode(std::string_view text);

struct OutputConfig {
  std::string publish = "tcp://127.0.0.1:7001";
  std::string control = "tcp://127.0.0.1:7002";
  std::int64_t high_water_mark = 1000;
  double status_interval_s = 1;
  std::string curve_key;      ///< a .key_secret file; "" = no CURVE
  std::string curve_clients;  ///< a folder of .key files, or one; "" = whoever knows our public key
};

struct RecordConfig {
  std::string folder;   ///< "" = no dataset
  std::string session;  ///< "" = no session file
  std::string follow = "always";
  std::string pseudonym, consent, licence;
};

/// The topic `shown` (generate/shown_face.h).
struct ShownConfig {
  double rate_hz = 60;
  double bridge_s = 0.5, fade_s = 1, rejoin_s = 0.15;
  std::string model{kTransitionModelNames.front()};  ///< of the ways to live targets
};

struct LatencyConfig {
  double awake_share = 0.05;  ///< ArrivalForecast
};

struct QueueConfig {
  std::int64_t admission = 1024, publish = 1024, record = 4096;
  std::int64_t session_mib = 16;
};

struct Config {
  OutputConfig output;
  RecordConfig record;
  QueueConfig queues;
  LatencyConfig latency;
  ShownConfig shown;
  std::vector<SourceConfig> sources;  ///< at least one
};

/// One source with all defaults.
Config default_config();

/// Throws UserError that lists all problems together: unknown keys, wrong types, values out of range, each with what to
/// do.
Config load_config(const std::filesystem::path& path);
Config parse_config(std::string_view toml, const std::string& place);

/// TOML that parse_config reads back to the same configuration, every key with its meaning.
std::string print_config(const Config& config);

}  // namespace risorius
