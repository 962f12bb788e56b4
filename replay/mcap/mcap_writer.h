// Writes an MCAP file (mcap.dev/spec) so that a crash costs at most what was not yet in a chunk: each chunk has a CRC,
// names the channels that it uses, and is on the disk when end_chunk returns. A file without its end is what
// McapReader calls torn, and `risorius recover` makes whole.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "replay/mcap/disk_sync.h"
#include "replay/mcap/mcap_records.h"

namespace risorius {

class McapWriter {
 public:
  /// Makes the file. Throws UserError if it exists or cannot be made.
  explicit McapWriter(std::filesystem::path path);
  /// Leaves the file as it is on the disk; finish() makes it whole.
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  // Of schemas and of channels there are 65535 at most; the next one throws UserError.

  /// Returns the id.
  std::uint16_t add_schema(std::string name, std::string encoding, std::string data);
  /// `schema_id` 0: none. Returns the id.
  std::uint16_t add_channel(std::uint16_t schema_id, std::string topic, std::string message_encoding,
                            McapTexts metadata = {});

  /// Into the chunk in the making, in memory. The channel must have been added.
  void write(const McapMessage& message);
  /// Of the chunk in the making; 0: it has no message.
  std::size_t chunk_bytes() const noexcept { return chunk_.size(); }
  std::int64_t chunk_start_ns() const noexcept { return chunk_start_ns_; }

  // These throw UserError when the disk refuses. What they were to write is lost; the file is as it was before, and
  // one may go on.

  /// Hands the chunk and its index to the system: a process that is killed does not lose them any more. On the disk
  /// they are soon (disk_sync.h); that the disk refused an earlier one may be told here.
  void end_chunk();
  /// Written at once, after the chunk in the making, with a seal (mcap_records.h).
  void write_metadata(const McapMetadata& metadata);
  /// Ends the chunk, writes the summary, and closes the file.
  void finish();

  const std::filesystem::path& path() const noexcept { return path_; }
  std::uint64_t bytes_written() const noexcept { return offset_; }
  /// In chunks on the disk.
  std::uint64_t messages() const noexcept { return messages_; }

 private:
  /// What the summary will say of a chunk. Small, as a recording of days has one for each of its seconds.
  struct Index {
    std::int64_t start_ns = 0, end_ns = 0;
    std::uint64_t offset = 0, records_bytes = 0;
    std::uint32_t channels = 0;  ///< its rows of chunk_channels_
  };
  struct ChunkChannel {
    std::uint16_t id = 0;
    std::uint32_t messages = 0;
  };
  struct Channel {
    McapChannel record;
    std::uint64_t messages = 0;
    std::vector<std::pair<std::int64_t, std::uint64_t>> in_chunk;  ///< time and offset of its messages there
  };
  struct NamedPlace {
    std::string name;
    std::uint64_t offset = 0, bytes = 0;
  };

  enum class Durability { kNone, kSoon, kNow };
  void flush(Durability durability);
  void append_summary();
  void append_group(McapOp op, std::size_t begin, std::uint64_t summary_start, ByteAppender& offsets);
  /// `channel`: the first of its rows.
  void append_index(const Index& index, std::deque<ChunkChannel>::const_iterator channel);

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::unique_ptr<DiskSync> sync_;  ///< of descriptor_, while that is open
  ByteAppender buffer_;             ///< to be written at offset_
  std::uint64_t offset_ = 0;        ///< of what is in the file
  std::uint32_t data_crc_ = 0;
  ByteAppender chunk_;
  std::int64_t chunk_start_ns_ = 0, chunk_end_ns_ = 0;
  std::vector<McapSchema> schemas_;       ///< id - 1
  std::vector<Channel> channels_;         ///< id
  std::vector<std::uint16_t> chunk_ids_;  ///< of the channels that have messages in the chunk in the making
  std::deque<Index> indexes_;
  std::deque<ChunkChannel> chunk_channels_;  ///< of all chunks, in their order
  std::vector<NamedPlace> metadata_;
  std::uint64_t messages_ = 0;
  std::int64_t start_ns_ = 0, end_ns_ = 0;
};

}  // namespace risorius
