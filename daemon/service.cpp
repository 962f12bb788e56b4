// The whole service on one screen. Threads, and the bounded channels between them:
//
//   I/O thread (run)                    pipeline thread                      publisher thread -> ZeroMQ PUB
//   socket -> decoder -> reorder ==admitted_==> despike -> fill -> solve ==to_publish_==^
//   control, signals, status timer              face shapes -> map ------'
//                                                     '-> continue ==continuations_==^ -> shown
//                                                                      '==to_record_==> recorder thread -> dataset
//                                                                      folder
//   datagrams, admitted items ==ring==> session thread <==ring== what was published; -> MCAP file
//
// Data flows to the right only. A value never depends on how fast a thread is: frames are dropped at admission or not
// at all.
#include "daemon/service.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <csignal>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <thread>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "capture/version.h"
#include "capture/wire/live_link_codec.h"
#include "daemon/make_source.h"
#include "daemon/status.h"
#include "replay/commands/rig_argument.h"
#include "replay/dataset/dataset_folder.h"

namespace risorius {
namespace {

constexpr std::size_t kContinuationQueue = 256;

/// What take.json says of a stream of face shapes.
nlohmann::json shapes_json(const PipelineStream& stream, const PipelineStream::Actor& actor, const ArkitTable& table) {
  nlohmann::json neutral = nlohmann::json::object();
  const auto names = live_link_shape_names();
  const auto& offsets = actor.shape_neutral;
  for (std::size_t i = 0; i < kFaceShapes; ++i) {
    if (offsets[i] != 0) neutral[std::string(names[i])] = offsets[i];
  }
  return {{"arkit_table", {{"version", table.version}, {"facs_edition", table.facs_edition}}},
          {"not_mapped", stream.shapes->not_mapped()},
          {"neutral", neutral}};
}

/// Throws UserError naming the source and the key, for a file does not say who asked for it.
Rig rig_of_source(const SourceConfig& source) {
  const char* key = "rig";
  try {
    Rig rig = rig_of_argument(source.rig);
    if (source.neutral.empty()) return rig;
    key = "neutral";
    return with_neutral_of_argument(rig, source.neutral).rig;
  } catch (const UserError& error) {
    throw UserError(fmt::format("[[source]] \"{}\" {}: {}", source.name, key, error.what()));
  }
}

Recorder::Options recorder_options(const Config& config, const std::deque<PipelineStream>& streams) {
  Recorder::Options options{.folder = config.record.folder};
  const nlohmann::json metadata{{"risorius", kVersion},
                                {"instruction_set", kInstructionSet},
                                {"processing", "live"},
                                {"pseudonym", config.record.pseudonym},
                                {"consent", config.record.consent},
                                {"session_clock", {{"monotonic_ns", monotonic_now_ns()}, {"utc_ns", utc_now_ns()}}}};
  options.with_neutral = [&streams, &config, metadata](std::uint32_t i,
                                                       std::uint64_t neutral) -> std::optional<Recorder::Stream> {
    const auto actor = streams[i].actor_of(neutral);
    if (!actor) return std::nullopt;
    nlohmann::json of_stream = metadata;
    if (streams[i].shapes) of_stream["shapes"] = shapes_json(streams[i], *actor, shipped_arkit_table());
    return Recorder::Stream{config.sources[i].name, actor->rig, of_stream.dump()};
  };
  std::string stages, rigs, mapped;
  for (std::size_t i = 0; i < config.sources.size(); ++i) {
    const SourceConfig& source = config.sources[i];
    options.streams.push_back(options.with_neutral(static_cast<std::uint32_t>(i), 0).value());
    stages += "# source " + source.name + "\n" + print_stage_config(source.stages);
    if (streams[i].shapes) mapped += (mapped.empty() ? "" : ", ") + source.name;
    rigs += (rigs.empty() ? "" : ", ") + options.streams.back().rig.name;
  }
  options.card_markdown = dataset_card_markdown({.title = options.folder.filename().string(),
                                                 .rig = rigs,
                                                 .mode = "live",
                                                 .pseudonym = config.record.pseudonym,
                                                 .consent = config.record.consent,
                                                 .licence = config.record.licence,
                                                 .options_toml = stages,
                                                 .mapped = mapped});
  options.follow_tracker = config.record.follow == "tracker";
  return options;
}

SessionDescription session_description(const Config& config, const std::deque<PipelineStream>& streams) {
  SessionDescription description{.config_toml = print_config(config),
                                 .facts = {{"risorius", kVersion},
                                           {"instruction_set", kInstructionSet},
                                           {"pseudonym", config.record.pseudonym},
                                           {"consent", config.record.consent},
                                           {"licence", config.record.licence}},
                                 .monotonic_ns = monotonic_now_ns(),
                                 .utc_ns = utc_now_ns()};
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const std::string& listen = config.sources[i].listen;
    description.streams.push_back(
        {config.sources[i].name, listen.substr(0, listen.find("://")), rig_to_json(streams[i].actor()->rig)});
  }
  return description;
}

}  // namespace

Service::Service(const Config& config, PipelineThread::AllocationProbe allocation_probe)
    : config_(config),
      signals_(io_, SIGINT, SIGTERM),
      status_timer_(io_),
      shown_timer_(io_),
      admitted_(static_cast<std::size_t>(config.queues.admission)),  // full: the newest frame is dropped, counted
      to_publish_(static_cast<std::size_t>(config.queues.publish)),  // full: the frame is not published, counted
      continuations_(kContinuationQueue) {                           // full: the prediction is not published, counted
  for (const auto& source : config_.sources) {
    streams_.emplace_back(source.stages.pipeline, rig_of_source(source),
                          tells_shapes(source) ? &shipped_arkit_table() : nullptr);
  }
  if (!config_.record.session.empty()) {
    session_ = std::make_unique<SessionRecorder>(streams_.size(), static_cast<std::size_t>(config_.queues.session_mib)
                                                                      << 20);  // full: not recorded, counted
  }
  // The threads serve all sources: each may keep them awake for its part of the share.
  const double awake_share = config_.latency.awake_share / static_cast<double>(config_.sources.size());
  for (std::uint32_t i = 0; i < config_.sources.size(); ++i) {
    inputs_.emplace_back(
        io_, i, config_.sources[i], awake_share, admitted_,
        [this] {
          publisher_->request_status();
          look_for_silence();
        },
        session_.get());
  }
  auto curve = load_curve_server(config_.output.curve_key, config_.output.curve_clients, "[output]");
  if (!curve.keys.secret_key.empty()) gate_.emplace(io_, zmq_, std::move(curve), refused_connections_);
  CurveGate* const gate = gate_ ? &*gate_ : nullptr;
  control_ = std::make_unique<ControlServer>(io_, zmq_, config_.output.control, gate,
                                             [this](const auto& request) { return answer(request); });

  std::vector<ShownStreams::Stream> faces;
  for (const PipelineStream& stream : streams_) {
    auto& of_stream = faces.emplace_back(ShownStreams::Stream{stream.stages.rig().au_names(), {}});
    for (const auto& au : stream.stages.rig().aus) of_stream.upper_bounds.push_back(au.upper_bound);
  }
  shown_ = std::make_unique<ShownStreams>(faces, config_.shown);

  Publisher::Options publishing{.endpoint = config_.output.publish,
                                .high_water_mark = static_cast<int>(config_.output.high_water_mark),
                                .gate = gate,
                                .session = session_.get(),
                                .shown = shown_.get()};
  for (std::size_t i = 0; i < streams_.size(); ++i)
    publishing.streams.push_back({config_.sources[i].name, streams_[i].stages.rig().au_names()});
  for (const PipelineStream& stream : streams_) slips_.emplace_back([&stream] { return stream.actor()->rig; });
  publishing.after_publishing = [this](const OutputItem& item) {
    slips_[item.stream_id].take(item);
    // The watchdog has told of the end before, when the publisher did not know of it yet.
    if (item.kind == OutputItem::Kind::kEndOfStream) boost::asio::post(io_, [this] { look_for_silence(); });
  };
  publishing.make_status = [this](bool last, std::uint64_t message) {
    auto json = status();
    json["last"] = last;
    json["message"] = message;
    const auto bytes = nlohmann::json::to_msgpack(json);
    return MessageBuffer(bytes.begin(), bytes.end());
  };
  publisher_ = std::make_unique<Publisher>(zmq_, std::move(publishing), to_publish_, continuations_);
  begin_recording();
  pipeline_ = std::make_unique<PipelineThread>(
      admitted_, streams_, PipelineThread::Outputs{to_publish_, continuations_, to_record_.get()}, allocation_probe);
}

/// Last of what can fail: files are made only for a service that starts.
void Service::begin_recording() {
  bool session_made = false;
  try {
    if (session_) session_->start(config_.record.session, session_description(config_, streams_));
    session_made = session_ != nullptr;
    if (config_.record.folder.empty()) return;
    to_record_ = std::make_unique<Channel<OutputItem>>(
        static_cast<std::size_t>(config_.queues.record));  // full: not recorded, counted
    recorder_ = std::make_unique<Recorder>(recorder_options(config_, streams_), *to_record_);
  } catch (...) {
    publisher_->stop();  // while all that its last status looks at is there
    if (session_made) {
      session_->stop();
      std::filesystem::remove(config_.record.session);
    }
    throw;
  }
}

// The threads end before what they read: the publisher's last status looks at all parts.
Service::~Service() {
  if (pipeline_) pipeline_->stop();
  if (recorder_) recorder_->stop();
  if (publisher_) publisher_->stop();
  if (session_) session_->stop();
}

void Service::run() {
  // A terminal that is closed ends the service like any other end; under nohup the signal is ignored, and stays so.
  struct sigaction of_hangup {};
  if (::sigaction(SIGHUP, nullptr, &of_hangup) == 0 && of_hangup.sa_handler != SIG_IGN) signals_.add(SIGHUP);
  signals_.async_wait([this](const boost::system::error_code& error, int) {
    if (!error) stop();
  });
  for (auto& input : inputs_) input.start();
  arm_status_timer();
  serve_events();

  // From source to sink: each part works off what the one before it left.
  for (auto& input : inputs_) input.stop();
  pipeline_->stop();
  if (recorder_) recorder_->stop();
  publisher_->stop();
  if (session_) session_->stop();
}

std::string Service::recording_problem() const {
  const std::string problem = recorder_ ? recorder_->problem() : std::string();
  if (!problem.empty()) return problem;
  if (to_record_ && to_record_->refused_frames() > 0) {
    return fmt::format(
        "{}: {} frames found the queue full and are missing; give [queues] record more, or a faster disk",
        config_.record.folder, to_record_->refused_frames());
  }
  return session_ ? session_->problem() : std::string();
}

/// Until stop(). While a frame is due within microseconds the thread looks again and again, giving way to others,
/// instead of falling asleep.
void Service::serve_events() {
  const auto awaits_frame = [this] { return std::ranges::any_of(inputs_, &StreamInput::awaits_frame); };
  while (!io_.stopped()) {
    io_.run_one();
    while (!io_.stopped() && awaits_frame()) {
      if (io_.poll() == 0) std::this_thread::yield();
    }
  }
}

void Service::stop() { io_.stop(); }

void Service::arm_status_timer() {
  status_timer_.expires_after(
      std::chrono::nanoseconds(static_cast<std::int64_t>(config_.output.status_interval_s * 1e9)));
  status_timer_.async_wait([this](const boost::system::error_code& error) {
    if (error) return;
    publisher_->request_status();
    if (notice_) {
      for (const std::string& line : notices_.update(status())) notice_(line);
    }
    arm_status_timer();
  });
}

/// While a stream is silent and something can be shown of it, time is told at the rate of `shown`.
void Service::look_for_silence() {
  bool is_needed = false;
  for (std::uint32_t i = 0; i < inputs_.size(); ++i)
    is_needed |= shown_->note_silence(i, inputs_[i].watchdog().stale());
  if (shown_armed_ || !is_needed) return;
  publisher_->request_shown();
  shown_armed_ = true;
  shown_timer_.expires_after(std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / config_.shown.rate_hz)));
  shown_timer_.async_wait([this](const boost::system::error_code& error) {
    shown_armed_ = false;
    if (!error) look_for_silence();
  });
}

nlohmann::json Service::status() const {
  nlohmann::json json{{"version", 1}, {"risorius", kVersion}, {"instruction_set", kInstructionSet}};
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    json["streams"][inputs_[i].name()] =
        status_of_stream(inputs_[i], streams_[i], *publisher_, static_cast<std::uint32_t>(i));
    json["streams"][inputs_[i].name()]["slip"] = status_of_slips(slips_[i]);
    const auto counts = shown_->counts(static_cast<std::uint32_t>(i));
    json["streams"][inputs_[i].name()]["shown"] = {
        {"messages", counts.messages}, {"predicted", counts.predicted}, {"targets", counts.targets}};
  }
  json["publish"] = status_of_channel(to_publish_);
  json["publish"]["messages"] = publisher_->published();
  json["continuations"] = status_of_channel(continuations_);
  json["admission"] = status_of_channel(admitted_);
  json["control"] = {{"refused", control_->refused()}};
  json["connections"] = {{"refused", refused_connections_.value()}};
  if (session_) json["session"] = session_->status();
  if (recorder_) json["record"] = status_of_recorder(*recorder_, *to_record_, config_.record.folder);
  return json;
}

}  // namespace risorius
