// A session's MCAP file as it grows: channels of each stream, views for viewers, and an account of what came in, what
// is on the disk and what the disk did not take. What all else hangs on is there more than once: the description and
// the report twice, the Tick of a stream's marker set again in each chunk that has Ticks of the stream. A chunk is
// closed, with its CRC and in the system's hands, every half second, and on the disk soon after: so a crash costs less
// than one. One thread (the recorder's); what others read are Counters.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "capture/counters.h"
#include "capture/wire/raw_tap.h"
#include "replay/mcap/mcap_writer.h"
#include "replay/session/session_format.h"
#include "replay/session/session_views.h"

namespace risorius {

struct SessionStream {
  std::string name;
  std::string protocol;  ///< "udp", "zmq+tcp", "natnet", ...
  std::string rig_json;  ///< as of the session's begin
};

struct SessionDescription {
  std::vector<SessionStream> streams;
  std::string config_toml;                    ///< effective
  McapTexts facts;                            ///< version, instruction set, consent, ...; the clock pair is added
  std::int64_t monotonic_ns = 0, utc_ns = 0;  ///< at one moment
};

class SessionWriter {
 public:
  /// So much time goes into a chunk.
  static constexpr std::int64_t kChunkNs = 500'000'000;
  /// A chunk that reaches this is closed before its time.
  static constexpr std::size_t kChunkBytes = 4 << 20;

  /// Makes the file and writes the description to the disk. Throws UserError.
  SessionWriter(std::filesystem::path path, SessionDescription description);

  // Times are CLOCK_MONOTONIC; the file has UTC. `sequence` counts what was offered to the topic of the stream, so
  // that what was lost on the way here shows as a gap. None of these throws: problems are noted and counted.

  void write_raw(std::uint32_t stream, std::uint32_t sequence, std::int64_t time_ns, const RawOrigin& origin,
                 std::span<const std::byte> bytes) noexcept;
  /// `topic`: not kRaw. AUs are written, and shown if it is time; kMarkerView takes a published message; kSets takes
  /// the Tick of a set whose own place in kTicks was lost.
  void write(SessionTopic topic, std::uint32_t stream, std::uint32_t sequence, std::int64_t time_ns,
             std::span<const std::byte> bytes) noexcept;
  /// Closes the chunk in the making if it is old enough.
  void keep_time(std::int64_t now_ns) noexcept;
  /// Closes the chunk, writes the report, to which `texts` are added, and ends the file.
  void finish(const McapTexts& texts) noexcept;

  const std::filesystem::path& path() const noexcept { return path_; }
  const Counter& messages() const noexcept { return messages_; }        ///< on the disk
  const Counter& not_written() const noexcept { return not_written_; }  ///< messages that the disk refused
  const Counter& bytes() const noexcept { return bytes_; }              ///< of the file
  /// The first error; empty if there was none. From any thread.
  std::string problem() const;

 private:
  struct Account {
    std::uint64_t written = 0, not_written = 0;
  };
  struct Stream {
    std::array<std::uint16_t, kSessionTopicCount> channels{};  ///< but of kRaw
    std::vector<std::pair<RawOrigin, std::uint16_t>> raw_channels;
    ViewDecimator au_view;
    std::uint32_t au_views = 0, marker_views = 0;
    std::vector<std::byte> set_tick;      ///< of the set that is in force; empty: none yet
    std::uint64_t chunk_of_set_tick = 0;  ///< the last chunk that holds it
  };

  void add_stream(const SessionStream& stream);
  void describe();
  void write_tick(Stream& stream, std::uint32_t sequence, std::int64_t time_ns, std::span<const std::byte> bytes);
  void write_set(Stream& stream, std::int64_t time_ns);
  std::uint16_t raw_channel(std::uint32_t stream, const RawOrigin& origin);
  void append(std::uint16_t channel, std::uint32_t sequence, std::int64_t time_ns, std::span<const std::byte> bytes);
  void append_text(SessionTopic topic, Stream& stream, std::uint32_t& sequence, std::int64_t time_ns,
                   const std::string& text);
  void end_chunk() noexcept;
  void note_problem(const std::string& what) noexcept;

  std::filesystem::path path_;
  SessionDescription description_;
  McapWriter file_;
  std::int64_t utc_minus_monotonic_ns_;
  std::deque<Stream> streams_;
  std::uint16_t status_channel_ = 0, marker_view_schema_ = 0;
  std::vector<std::string> topics_;                  ///< by channel
  std::map<std::uint16_t, std::uint64_t> in_chunk_;  ///< messages by channel
  std::map<std::string, Account> accounts_;          ///< by topic
  std::int64_t chunk_begin_ns_ = 0;
  std::uint64_t chunks_ = 1;  ///< with the one in the making
  bool finished_ = false;
  Counter messages_, not_written_, bytes_;
  mutable std::mutex problem_mutex_;
  std::string problem_;
};

}  // namespace risorius
