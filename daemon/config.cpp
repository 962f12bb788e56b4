#include "daemon/config.h"

#include <algorithm>

#include "daemon/config_checks.h"

namespace risorius {
namespace {

constexpr double kGigabyte = 1 << 30;
constexpr std::size_t kMostSources = 64;

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
void visit_latency(V& v, C& c) {
  v.number("awake_share", c.awake_share, 0, 1,
           "of a frame time (at most 0.3 ms of it, divided by the sources), that threads may be awake before a frame "
           "is due, "
           "for it to pass sooner; 0 = they sleep");
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
    config.sources.push_back(std::move(source));
  }
}

}  // namespace

Config default_config() { return Config{.sources = {SourceConfig{}}}; }

namespace {

Config config_of(const toml::table& table, const std::string& place) {
  Config config;
  ConfigProblems problems;
  TomlReader root(table, "", problems);
  root.table("output", [&](auto& v) { visit_output(v, config.output); });
  root.table("record", [&](auto& v) { visit_record(v, config.record); });
  root.table("queues", [&](auto& v) { visit_queues(v, config.queues); });
  root.table("latency", [&](auto& v) { visit_latency(v, config.latency); });
  root.table("shown", [&](auto& v) { visit_shown(v, config.shown); });
  const auto models = kTransitionModelNames;
  if (std::find(models.begin(), models.end(), config.shown.model) == models.end())
    problems.add("shown.model", "\"" + config.shown.model + "\" is not known", shown_models());
  StageConfig defaults;
  read_stage_tables(root, defaults);
  read_sources(root, defaults, problems, config);
  root.refuse_unknown();
  check_config(config, problems);
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
  printer.table("latency", [&](auto& v) { visit_latency(v, config.latency); });
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
