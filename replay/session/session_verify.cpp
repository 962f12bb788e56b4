#include "replay/session/session_verify.h"

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>

#include "capture/errors.h"
#include "capture/version.h"
#include "replay/live/messages.h"
#include "replay/pipeline/stage_config.h"
#include "replay/session/known_set.h"
#include "replay/session/session_format.h"
#include "replay/session/session_reader.h"
#include "replay/session/session_solver.h"
#include "replay/takes/arkit_aus.h"

namespace risorius {
namespace {

constexpr std::uint64_t kProgressStride = 256;

/// One frame's message, recorded or solved again, with what says which frame it is.
struct Message {
  std::uint64_t sequence = 0;
  std::int64_t capture_time_ns = 0, receive_time_ns = 0;
  MessageBuffer bytes;  ///< recorded: as they are; solved: with message and publish_time_ns of 0
  std::uint64_t number = 0;
  std::int64_t publish_time_ns = 0;

  bool is_of_the_frame_of(const Message& other) const noexcept {
    return sequence == other.sequence && capture_time_ns == other.capture_time_ns &&
           receive_time_ns == other.receive_time_ns;
  }
};

std::optional<Message> recorded_message(std::span<const std::byte> bytes) {
  const auto* begin = reinterpret_cast<const std::uint8_t*>(bytes.data());
  const auto json = nlohmann::json::from_msgpack(begin, begin + bytes.size(), true, false);
  Message message;
  try {
    message.sequence = json.at("sequence").get<std::uint64_t>();
    message.capture_time_ns = json.at("capture_time_ns").get<std::int64_t>();
    message.receive_time_ns = json.at("receive_time_ns").get<std::int64_t>();
    message.number = json.at("message").get<std::uint64_t>();
    message.publish_time_ns = json.at("publish_time_ns").get<std::int64_t>();
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
  message.bytes.assign(reinterpret_cast<const char*>(begin), reinterpret_cast<const char*>(begin) + bytes.size());
  return message;
}

/// Two queues, recorded and solved, joined frame by frame. `Value`: what encodes to a message.
template <class Value>
class Comparison {
 public:
  using Encode = void (*)(const Value&, const MessageContext&, MessageBuffer&);

  Comparison(std::string topic, std::string stream, std::vector<std::string> names, Encode encode)
      : stream_(std::move(stream)), names_(std::move(names)), encode_(encode) {
    verdict_.topic = std::move(topic);
  }

  void add_recorded(std::span<const std::byte> bytes) {
    auto message = recorded_message(bytes);
    if (!message) {
      ++verdict_.different;
      return;
    }
    recorded_.push_back(std::move(*message));
    join();
  }
  void add_solved(const Value& value, const FrameHeader& header) {
    solved_.push_back({value, Message{.sequence = header.sequence,
                                      .capture_time_ns = header.capture_time_ns,
                                      .receive_time_ns = header.receive_time_ns}});
    join();
  }
  VerifiedTopic finish() {
    verdict_.not_recorded += solved_.size();
    verdict_.not_solved += recorded_.size();
    return verdict_;
  }

 private:
  struct Solved {
    Value value;
    Message frame;
  };

  void join() {
    while (!recorded_.empty() && !solved_.empty()) {
      const auto is_recorded = [this](const Solved& solved) {
        return solved.frame.is_of_the_frame_of(recorded_.front());
      };
      const auto found = std::find_if(solved_.begin(), solved_.end(), is_recorded);
      if (found == solved_.end()) {
        // Its Tick may still come, the results' thread being the faster one; but not if a later one has come.
        const auto next = std::find_if(recorded_.begin(), recorded_.end(), [this](const Message& recorded) {
          return solved_.front().frame.is_of_the_frame_of(recorded);
        });
        if (next == recorded_.end() && solved_.size() < kMostWaiting) return;
        const auto unsolved = next == recorded_.end() ? recorded_.begin() + 1 : next;
        verdict_.not_solved += static_cast<std::uint64_t>(unsolved - recorded_.begin());
        recorded_.erase(recorded_.begin(), unsolved);
        continue;
      }
      verdict_.not_recorded += static_cast<std::uint64_t>(found - solved_.begin());
      solved_.erase(solved_.begin(), found);
      compare(recorded_.front(), solved_.front().value);
      recorded_.pop_front();
      solved_.pop_front();
    }
    while (solved_.size() > kMostWaiting) {
      solved_.pop_front();
      ++verdict_.not_recorded;
    }
  }

  void compare(const Message& recorded, const Value& solved) {
    encode_(
        solved,
        {.stream = stream_, .message = recorded.number, .publish_time_ns = recorded.publish_time_ns, .names = names_},
        buffer_);
    if (buffer_ == recorded.bytes) {
      ++verdict_.equal;
      return;
    }
    ++verdict_.different;
    if (!verdict_.first_different_sequence) verdict_.first_different_sequence = recorded.sequence;
  }

  static constexpr std::size_t kMostWaiting = 4096;
  std::string stream_;
  std::vector<std::string> names_;
  Encode encode_;
  std::deque<Message> recorded_;
  std::deque<Solved> solved_;
  MessageBuffer buffer_;
  VerifiedTopic verdict_;
};

struct VerifiedStream {
  VerifiedStream(const StreamFacts& facts, const std::string& config_toml, const std::string& place)
      : rig(parse_rig(facts.rig_json, place + ": rig of " + facts.name)),
        aus(session_topic(SessionTopic::kAus, facts.name), facts.name, rig.au_names(), &encode_aus),
        continuations(session_topic(SessionTopic::kContinuations, facts.name), facts.name, rig.au_names(),
                      &encode_continuation),
        solver(parse_stage_config(config_toml, place + ": config", facts.name).pipeline, rig,
               facts.protocol == "livelink" ? &shipped_arkit_table() : nullptr,
               {.solved = [this](const SolvedFrame& frame) { aus.add_solved(frame.aus, frame.aus.header); },
                .continued = [this](const Continuation& c) { continuations.add_solved(c, c.header); }}) {}

  Rig rig;
  KnownSet set;
  Comparison<AuFrame> aus;
  Comparison<Continuation> continuations;
  SessionSolver solver;
};

std::string value_of(const McapTexts& texts, const char* key) {
  const auto found = texts.find(key);
  return found == texts.end() ? "" : found->second;
}

}  // namespace

std::uint64_t SessionVerdict::different() const noexcept {
  std::uint64_t sum = 0;
  for (const VerifiedTopic& topic : topics) sum += topic.different;
  return sum;
}

std::uint64_t SessionVerdict::equal() const noexcept {
  std::uint64_t sum = 0;
  for (const VerifiedTopic& topic : topics) sum += topic.equal;
  return sum;
}

std::uint64_t SessionVerdict::not_solved() const noexcept {
  std::uint64_t sum = 0;
  for (const VerifiedTopic& topic : topics) sum += topic.not_solved;
  return sum;
}

SessionVerdict verify_session(const std::filesystem::path& path, const SessionProgress& progress) {
  SessionReader reader(path);
  SessionVerdict verdict;
  std::map<std::string, std::unique_ptr<VerifiedStream>> streams;
  SessionTick tick;
  for (std::uint64_t done = 0; reader.next(); ++done) {
    if (done == 0) reader.require_session();
    if (done % kProgressStride == 0) progress(reader.bytes_read(), reader.bytes());
    const SessionTopic topic = reader.topic();
    const bool is_tick = topic == SessionTopic::kTicks || topic == SessionTopic::kSets;
    if (!is_tick && topic != SessionTopic::kAus && topic != SessionTopic::kContinuations) continue;
    auto& stream = streams[reader.stream()];
    if (!stream) {
      const StreamFacts* facts = reader.find_stream(reader.stream());
      if (facts == nullptr)
        throw UserError(path.string(), "says nothing of stream " + shown(reader.stream()),
                        "is its begin damaged? risorius info says so");
      stream = std::make_unique<VerifiedStream>(*facts, reader.config_toml(), path.string());
    }
    if (topic == SessionTopic::kAus) stream->aus.add_recorded(reader.message().data);
    if (topic == SessionTopic::kContinuations) stream->continuations.add_recorded(reader.message().data);
    if (!is_tick || !stream->set.is_news(topic, reader.message().data)) continue;
    if (!decode_tick(reader.message().data, tick))
      throw UserError(path.string(), "has a Tick of " + reader.stream() + " that cannot be read", "");
    stream->solver.take(tick);
    verdict.ticks += topic == SessionTopic::kTicks ? 1 : 0;
  }
  reader.require_session();
  for (const auto& [name, stream] : streams) {
    verdict.topics.push_back(stream->aus.finish());
    verdict.topics.push_back(stream->continuations.finish());
    const auto& topics = reader.topics();
    if (const auto ticks = topics.find(session_topic(SessionTopic::kTicks, name)); ticks != topics.end())
      verdict.missing_ticks += ticks->second.missing;
  }
  verdict.recovered_of = value_of(reader.recovery(), "of");
  for (const auto& [key, text] : reader.recovery()) {
    if (key.starts_with(kMissingKey)) verdict.missing_in_recovered.push_back(text);
  }
  verdict.whole = reader.file().whole() && reader.file().damage_count() == 0;
  if (const std::string version = value_of(reader.session(), "risorius"); version != kVersion)
    verdict.notes.push_back("recorded by risorius " + shown(version) + ", this is " + kVersion);
  if (const std::string set = value_of(reader.session(), "instruction_set"); set != kInstructionSet)
    verdict.notes.push_back("recorded by a program for " + shown(set) + ", this one is for " + kInstructionSet);
  return verdict;
}

}  // namespace risorius
