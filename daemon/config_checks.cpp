#include "daemon/config_checks.h"

#include <algorithm>
#include <array>
#include <boost/asio/ip/address_v4.hpp>
#include <fmt/format.h>
#include <set>

#include "capture/errors.h"
#include "capture/marker_set.h"
#include "capture/wire/live_link_codec.h"
#include "daemon/address_clashes.h"
#include "daemon/source_address.h"

namespace risorius {
namespace {

constexpr std::size_t kLongestSourceName = 100;

void check_natnet(const SourceConfig& source, const std::string& place, ConfigProblems& problems) {
  const std::string& markers = source.natnet_markers;
  if (!markers.empty() && markers != "labelled" && !(markers.starts_with("set:") && markers.size() > 4)) {
    problems.add(place + ".natnet_markers", "\"" + markers + "\" names no choice of markers",
                 "give \"\", \"labelled\" or \"set:NAME\"");
  }
  const auto check_address = [&](const char* key, const std::string& address, bool multicast) {
    if (address.empty()) return;
    boost::system::error_code error;
    const auto parsed = boost::asio::ip::make_address_v4(address, error);
    if (!error && parsed.is_multicast() == multicast) return;
    problems.add(place + "." + key, "\"" + address + "\" is no such IPv4 address",
                 multicast ? "such as 239.255.42.99, or \"\"" : "such as 192.168.1.10, or \"\"");
  };
  check_address("natnet_local_address", source.natnet_local_address, false);
  check_address("natnet_multicast_group", source.natnet_multicast_group, true);
  if (!parse_natnet_timecode(source.natnet_timecode)) {
    problems.add(place + ".natnet_timecode", "\"" + source.natnet_timecode + "\" is no rate of timecode",
                 "give 24, 25, 30, 30df, 50 or 60");
  }
}

void check_source(const SourceConfig& source, const std::string& place, ConfigProblems& problems) {
  const bool name_is_plain =
      !source.name.empty() && source.name.size() <= kLongestSourceName &&
      source.name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_") ==
          std::string::npos;
  if (!name_is_plain)
    problems.add(place + ".name", fmt::format("\"{}\" cannot name a folder", shown(source.name)),
                 fmt::format("use letters, digits, - and _, at most {} of them", kLongestSourceName));
  try {
    parse_source_address(source.listen);
  } catch (const UserError& error) {
    problems.add(place + ".listen", error.what(), "port 0 lets the system choose");
  }
  if (source.zmq_pattern != "pull" && source.zmq_pattern != "sub") {
    problems.add(place + ".zmq_pattern", "\"" + source.zmq_pattern + "\" is neither \"pull\" nor \"sub\"",
                 "give one of them");
  }
  if (!(source.curve_key.empty() && source.curve_clients.empty()) && !source.listen.starts_with("zmq+")) {
    problems.add(place + (source.curve_key.empty() ? ".curve_clients" : ".curve_key"),
                 source.listen + " cannot be encrypted",
                 "only zmq+tcp:// can: leave it out, or let the sender use zmq+tcp://");
  }
  check_natnet(source, place, problems);
  if (source.qtm_frames != "tcp" && source.qtm_frames != "udp") {
    problems.add(place + ".qtm_frames", "\"" + source.qtm_frames + "\" is neither \"tcp\" nor \"udp\"",
                 "give one of them");
  }
  if (source.livelink_device.size() > kMaxLiveLinkNameBytes) {
    problems.add(place + ".livelink_device", fmt::format("is longer than {} bytes", kMaxLiveLinkNameBytes),
                 "give the subject name that the app shows");
  }
  if (source.livelink_rate_hz > 0 && source.livelink_rate_hz < 1) {
    problems.add(place + ".livelink_rate_hz", fmt::format("{} is below 1", source.livelink_rate_hz),
                 "give 1 to 1000, or 0 = as the packets say");
  }
  if (!source.units.empty() && !parse_unit(source.units)) {
    problems.add(place + ".units", "\"" + source.units + "\" is not a known unit", "give mm, cm, m or \"\"");
  }
  if (!source.axes.empty() && !Axes::parse(source.axes)) {
    problems.add(place + ".axes", "\"" + source.axes + "\" does not name three different directions",
                 "give one of L R, one of U D and one of F B in the order of x y z, such as \"LUF\", or \"\"");
  }
}

/// A key of one protocol would be passed over in a source of another.
void refuse_foreign_keys(const SourceConfig& source, const std::string& place, ConfigProblems& problems) {
  SourceKind kind{};
  try {
    kind = parse_source_address(source.listen).kind;
  } catch (const UserError&) {
    return;  // told already
  }
  const SourceConfig defaults;
  const auto check = [&](SourceKind of, const char* key, const auto SourceConfig::*member) {
    if (source.*member == defaults.*member || kind == of) return;
    problems.add(place + "." + key, "means nothing to " + source.listen,
                 fmt::format("it is for {} sources: leave it out here", scheme_of(of)));
  };
  using S = SourceConfig;
  check(SourceKind::kZmq, "zmq_pattern", &S::zmq_pattern);
  check(SourceKind::kZmq, "zmq_high_water_mark", &S::zmq_high_water_mark);
  check(SourceKind::kNatnet, "natnet_markers", &S::natnet_markers);
  check(SourceKind::kNatnet, "natnet_local_address", &S::natnet_local_address);
  check(SourceKind::kNatnet, "natnet_multicast_group", &S::natnet_multicast_group);
  check(SourceKind::kNatnet, "natnet_data_port", &S::natnet_data_port);
  check(SourceKind::kNatnet, "natnet_timecode", &S::natnet_timecode);
  check(SourceKind::kQtm, "qtm_frames", &S::qtm_frames);
  check(SourceKind::kQtm, "qtm_label_prefix", &S::qtm_label_prefix);
  check(SourceKind::kVicon, "vicon_subject", &S::vicon_subject);
  check(SourceKind::kVicon, "vicon_rate_hz", &S::vicon_rate_hz);
  check(SourceKind::kLiveLink, "livelink_device", &S::livelink_device);
  check(SourceKind::kLiveLink, "livelink_rate_hz", &S::livelink_rate_hz);
}

void refuse_shared_names(const Config& config, ConfigProblems& problems) {
  std::set<std::string> names;
  for (const auto& source : config.sources) {
    if (!names.insert(source.name).second)
      problems.add("source.name", "two sources are called \"" + source.name + "\"", "give each its own name");
  }
}

bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder) {
  if (file.empty() || folder.empty()) return false;
  const auto relative = std::filesystem::absolute(file).lexically_normal().lexically_relative(
      std::filesystem::absolute(folder).lexically_normal());
  return !relative.empty() && *relative.begin() != "..";
}

void check_record(const Config& config, ConfigProblems& problems) {
  if (config.record.follow != "always" && config.record.follow != "tracker") {
    problems.add("record.follow", fmt::format("\"{}\" is neither \"always\" nor \"tracker\"", config.record.follow),
                 "give one of them");
  }
  if (lies_in(config.record.session, config.record.folder)) {
    problems.add("record.session", "lies in record.folder, whose manifest is written before the session ends",
                 "give a file elsewhere");
  }
  const auto tells_recording = [](const SourceConfig& source) {
    return source.listen.starts_with("natnet://") || source.listen.starts_with("qtm://");
  };
  if (config.record.follow == "tracker" && std::ranges::none_of(config.sources, tells_recording)) {
    problems.add("record.follow", "no source is a tracker that tells when it records: nothing would be recorded",
                 "give \"always\", or a natnet:// or qtm:// source");
  }
}

}  // namespace

std::optional<NatnetTimecode> parse_natnet_timecode(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, NatnetTimecode>, 6> kKnown{
      {{"24", {24}}, {"25", {25}}, {"30", {30}}, {"30df", {30, true}}, {"50", {50}}, {"60", {60}}}};
  for (const auto& [name, timecode] : kKnown) {
    if (name == text) return timecode;
  }
  return std::nullopt;
}

void check_config(const Config& config, ConfigProblems& problems) {
  for (std::size_t i = 0; i < config.sources.size(); ++i) {
    const std::string place = fmt::format("source[{}]", i);
    check_source(config.sources[i], place, problems);
    refuse_foreign_keys(config.sources[i], place, problems);
  }
  refuse_shared_names(config, problems);
  refuse_address_clashes(config, problems);
  check_record(config, problems);
}

}  // namespace risorius
