#include "daemon/config.h"

#include <algorithm>
#include <array>
#include <boost/asio/ip/address_v4.hpp>
#include <set>

#include "capture/errors.h"
#include "capture/marker_set.h"
#include "capture/wire/live_link_codec.h"
#include "daemon/source_address.h"

namespace risorius {
namespace {

constexpr double kGigabyte = 1 << 30;
constexpr std::size_t kMostSources = 64;
constexpr std::size_t kLongestSourceName = 100;

/// What the model may be, in words.
const std::string& shown_models() {
  static const std::string text = [] {
    std::string names = "the way to a live target: ";
    for (const std::string_view name : kTransitionModelNames)
      names += fmt::format("{}\"{}\"", names.ends_with(' ') ? "" : ", ", name);
    return names;
  }();
  return text;
}

// Each key once: name, range, meaning. V is TomlReader or TomlPrinter.

template <class V, class C>
void visit_curve(V& v, C& c) {
  v.text("curve_key", c.curve_key,
         "CURVE: a .key_secret file of `risorius keys`; \"\" = anybody may connect, and nothing is encrypted");
  v.text("curve_clients", c.curve_clients,
         "CURVE: folder of the .key files of those who may connect; \"\" = whoever knows our public key");
}

template <class V, class C>
void visit_output(V& v, C& c) {
  v.text("publish", c.publish, "ZeroMQ PUB address for markers, au, continuation, status");
  v.text("control", c.control, "ZeroMQ address for control messages");
  v.number("high_water_mark", c.high_water_mark, 1, 1e6, "messages kept for a slow subscriber before it loses some");
  visit_curve(v, c);
  v.number("status_interval_s", c.status_interval_s, 0.1, 3600, "seconds between status messages");
}

template <class V, class C>
void visit_record(V& v, C& c) {
  v.text("folder", c.folder, "dataset folder to make and record into; \"\" = do not record");
  v.text("session", c.session, "MCAP file to make and record the whole session into; \"\" = do not");
  v.text("follow", c.follow, "\"always\", or \"tracker\": record only while the tracker (Motive, QTM) itself records");
  v.text("pseudonym", c.pseudonym, "of the recorded person, kept with the data");
  v.text("consent", c.consent, "reference to the person's consent, kept with the data");
  v.text("licence", c.licence, "of the dataset, kept with the data");
}

template <class V, class C>
void visit_queues(V& v, C& c) {
  v.number("admission", c.admission, 16, 65536,
           "frames from the sources to the pipeline; full: the newest is dropped, counted");
  v.number("publish", c.publish, 16, 65536, "frames to the publisher; full: not published, counted");
  v.number("record", c.record, 16, 65536, "frames to the recorder; full: not recorded, counted");
  v.number("session_mib", c.session_mib, 1, 1024,
           "MiB of each of the two queues to the session's file; full: not recorded, counted");
}

template <class V, class C>
void visit_shown(V& v, C& c) {
  v.number("rate_hz", c.rate_hz, 1, 1000, "messages per second of capture time");
  v.number("bridge_s", c.bridge_s, 0, 2, "predictions stand so long for frames that do not come");
  v.number("fade_s", c.fade_s, 0.05, 60, "then the face becomes neutral in so long");
  v.number("rejoin_s", c.rejoin_s, 0, 10, "and runs into the frames in so long when they come again");
  v.text("model", c.model, shown_models());
}

template <class V, class C>
void visit_source(V& v, C& c) {
  v.text("name", c.name, "name of the stream, in messages and folders");
  v.text("listen", c.listen,
         "udp://ADDRESS:PORT, zmq+tcp://ADDRESS:PORT, natnet://HOST, qtm://HOST, vicon://HOST or livelink://ADDRESS");
  v.text("zmq_pattern", c.zmq_pattern, "for zmq+tcp: \"pull\" (senders PUSH, flow control) or \"sub\" (senders PUB)");
  v.number("zmq_high_water_mark", c.zmq_high_water_mark, 1, 1e6,
           "for zmq+tcp: messages kept of each sender before it waits (pull) or loses some (sub)");
  visit_curve(v, c);
  v.text("natnet_markers", c.natnet_markers,
         "for natnet: \"\" = all that have names, \"labelled\" = labelled ones only, \"set:NAME\" = of one marker set");
  v.text("natnet_local_address", c.natnet_local_address, "for natnet: of our interface; \"\" = by routing");
  v.text("natnet_multicast_group", c.natnet_multicast_group, "for natnet: \"\" = as the server says");
  v.number("natnet_data_port", c.natnet_data_port, 0, 65535, "for natnet: 0 = as the server says");
  v.text("natnet_timecode", c.natnet_timecode,
         "for natnet: frames per second of the timecode: 24, 25, 30, 30df (drop-frame), 50, 60");
  v.text("qtm_frames", c.qtm_frames, "for qtm: over \"tcp\" or \"udp\"");
  v.text("qtm_label_prefix", c.qtm_label_prefix,
         "for qtm: take only labels that begin so, and take it off; \"\" = all labels");
  v.text("vicon_subject", c.vicon_subject, "for vicon: the subject to take; \"\" = all");
  v.number("vicon_rate_hz", c.vicon_rate_hz, 0, 10000, "for vicon: frames per second of a server that states none");
  v.text("livelink_device", c.livelink_device,
         "for livelink: the subject name that the app shows; \"\" = the first that sends");
  v.number("livelink_rate_hz", c.livelink_rate_hz, 0, 1000,
           "for livelink: frames per second, where the app counts in a finer base; 0 = as its packets say");
  v.text("rig", c.rig, "\"builtin\", the path of a rig file, or an actor's folder");
  v.text(
      "neutral", c.neutral,
      "of this session, in the place of the rig's: \"TAKE:FROM-TO\" (frames) or \"TAKE:auto\"; \"\" = the rig's own");
  v.text("units", c.units, "\"\" = as the sender states; else mm, cm, m");
  v.text("axes", c.axes, "\"\" = as the sender states; else three of L R U D F B");
  v.number("receive_buffer_bytes", c.receive_buffer_bytes, 4096, kGigabyte, "socket buffer asked of the kernel (UDP)");
}

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

void read_sources(TomlReader& root, const StageConfig& defaults, ConfigProblems& problems, Config& config) {
  const toml::node* node = root.find("source");
  if (node == nullptr) {
    config.sources = {SourceConfig{.stages = defaults}};
    return;
  }
  const toml::array* tables = node->as_array();
  if (tables == nullptr || !tables->is_homogeneous(toml::node_type::table)) {
    problems.add("source", "is not a list of tables", "write [[source]], once for each stream");
    return;
  }
  if (tables->size() > kMostSources)
    problems.add("source", fmt::format("{} sources", tables->size()), fmt::format("at most {}", kMostSources));
  for (std::size_t i = 0; i < tables->size(); ++i) {
    SourceConfig source{.stages = defaults};
    const std::string place = fmt::format("source[{}]", i);
    TomlReader reader(*(*tables)[i].as_table(), place, problems);
    visit_source(reader, source);
    read_stage_tables(reader, source.stages);
    reader.refuse_unknown();
    check_source(source, place, problems);
    config.sources.push_back(std::move(source));
  }
}

void refuse_shared_names_and_ports(const Config& config, ConfigProblems& problems) {
  std::set<std::string> names, addresses;
  for (const auto& source : config.sources) {
    if (!names.insert(source.name).second)
      problems.add("source.name", "two sources are called \"" + source.name + "\"", "give each its own name");
    const bool any_port = source.listen.ends_with(":0");
    // Two subjects of one server are two connections.
    const bool connects = source.listen.starts_with("vicon://") || source.listen.starts_with("qtm://");
    if (!any_port && !connects && !addresses.insert(source.listen).second) {
      problems.add("source.listen", "two sources listen on " + source.listen, "give each its own port");
    }
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

Config default_config() { return Config{.sources = {SourceConfig{}}}; }

namespace {

bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder) {
  if (file.empty() || folder.empty()) return false;
  const auto relative = std::filesystem::absolute(file).lexically_normal().lexically_relative(
      std::filesystem::absolute(folder).lexically_normal());
  return !relative.empty() && *relative.begin() != "..";
}

Config config_of(const toml::table& table, const std::string& place) {
  Config config;
  ConfigProblems problems;
  TomlReader root(table, "", problems);
  root.table("output", [&](auto& v) { visit_output(v, config.output); });
  root.table("record", [&](auto& v) { visit_record(v, config.record); });
  if (config.record.follow != "always" && config.record.follow != "tracker") {
    problems.add("record.follow", fmt::format("\"{}\" is neither \"always\" nor \"tracker\"", config.record.follow),
                 "give one of them");
  }
  if (lies_in(config.record.session, config.record.folder)) {
    problems.add("record.session", "lies in record.folder, whose manifest is written before the session ends",
                 "give a file elsewhere");
  }
  const bool any_port = config.output.publish.ends_with(":*") || config.output.publish.ends_with(":0");
  if (!any_port && config.output.publish == config.output.control) {
    problems.add("output.control", "is the address of publish, too: " + config.output.control,
                 "give each an address of its own");
  }
  root.table("queues", [&](auto& v) { visit_queues(v, config.queues); });
  root.table("shown", [&](auto& v) { visit_shown(v, config.shown); });
  const auto models = kTransitionModelNames;
  if (std::find(models.begin(), models.end(), config.shown.model) == models.end())
    problems.add("shown.model", "\"" + config.shown.model + "\" is not known", shown_models());
  StageConfig defaults;
  read_stage_tables(root, defaults);
  read_sources(root, defaults, problems, config);
  root.refuse_unknown();
  refuse_shared_names_and_ports(config, problems);
  throw_if_any(problems, place);
  return config;
}

}  // namespace

Config parse_config(std::string_view text, const std::string& place) {
  return config_of(parse_toml(text, place), place);
}

Config load_config(const std::filesystem::path& path) { return config_of(parse_toml_file(path), path.string()); }

std::string print_config(const Config& config) {
  TomlPrinter printer;
  printer.table("output", [&](auto& v) { visit_output(v, config.output); });
  printer.table("record", [&](auto& v) { visit_record(v, config.record); });
  printer.table("queues", [&](auto& v) { visit_queues(v, config.queues); });
  printer.table("shown", [&](auto& v) { visit_shown(v, config.shown); });
  for (const auto& source : config.sources) {
    TomlPrinter stream("source");
    visit_source(stream, source);
    print_stage_tables(stream, source.stages);
    printer.raw("\n[[source]]\n" + stream.printed());
  }
  return printer.printed();
}

}  // namespace risorius
