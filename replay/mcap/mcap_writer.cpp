#include "replay/mcap/mcap_writer.h"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <system_error>
#include <unistd.h>

#include "capture/check.h"
#include "capture/errors.h"
#include "capture/version.h"

namespace risorius {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* what, int problem) {
  throw UserError(path.string(), std::string(what) + ": " + std::generic_category().message(problem),
                  problem == EEXIST   ? "give another name, or move the file away"
                  : problem == ENOSPC ? "make room on the disk"
                                      : "is its folder there, and writable?");
}

/// Of a chunk's record with so many bytes of records in it, and of a message index and one entry of it: the summary
/// says where they stand, and keeps none of that in memory.
constexpr std::uint64_t chunk_record_bytes(std::uint64_t records_bytes) { return 49 + records_bytes; }
constexpr std::uint64_t kIndexHeadBytes = 15, kIndexEntryBytes = 16;

/// MCAP numbers schemas and channels with 16 bits.
constexpr std::size_t kMostIds = 65535;

[[noreturn]] void refuse_id(const std::filesystem::path& path, const char* what) {
  throw UserError(path.string(), fmt::format("would have more than {} {}, which MCAP cannot number", kMostIds, what),
                  "is what it is made of damaged, or no session of risoriusd?");
}

}  // namespace

McapWriter::McapWriter(std::filesystem::path path) : path_(std::move(path)) {
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail(path_, "cannot be created", errno);
  buffer_.append_bytes(std::as_bytes(std::span(kMcapMagic)));
  const std::size_t begin = begin_mcap_record(McapOp::kHeader, buffer_);
  append_mcap_text("", buffer_);  // no profile: nobody else's conventions
  append_mcap_text(std::string("risorius ") + kVersion + std::string(kMcapSealedLibrary), buffer_);
  end_mcap_record(begin, buffer_);
  sync_ = std::make_unique<DiskSync>(descriptor_);
  flush(Durability::kNone);
}

McapWriter::~McapWriter() {
  sync_.reset();
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::uint16_t McapWriter::add_schema(std::string name, std::string encoding, std::string data) {
  if (schemas_.size() >= kMostIds) refuse_id(path_, "schemas");
  const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
  schemas_.push_back({id, std::move(name), std::move(encoding), std::move(data)});
  return id;
}

std::uint16_t McapWriter::add_channel(std::uint16_t schema_id, std::string topic, std::string message_encoding,
                                      McapTexts metadata) {
  RISORIUS_CHECK(schema_id <= schemas_.size());
  if (channels_.size() >= kMostIds) refuse_id(path_, "channels");
  const auto id = static_cast<std::uint16_t>(channels_.size());
  channels_.push_back({{id, schema_id, std::move(topic), std::move(message_encoding), std::move(metadata)}, 0, {}});
  return id;
}

void McapWriter::write(const McapMessage& message) {
  RISORIUS_CHECK(message.channel_id < channels_.size() && message.log_time_ns >= 0);
  const bool first = chunk_.size() == 0;
  Channel& channel = channels_[message.channel_id];
  if (channel.in_chunk.empty()) {
    chunk_ids_.push_back(message.channel_id);
    // Every chunk can be read without those before it.
    if (const std::uint16_t schema_id = channel.record.schema_id; schema_id != 0)
      append_mcap_record(schemas_[schema_id - 1U], chunk_);
    append_mcap_record(channel.record, chunk_);
  }
  chunk_start_ns_ = first ? message.log_time_ns : std::min(chunk_start_ns_, message.log_time_ns);
  chunk_end_ns_ = first ? message.log_time_ns : std::max(chunk_end_ns_, message.log_time_ns);
  channel.in_chunk.emplace_back(message.log_time_ns, chunk_.size());
  append_mcap_record(message, chunk_);
}

void McapWriter::end_chunk() {
  if (chunk_.size() == 0) return;
  Index index{.start_ns = chunk_start_ns_, .end_ns = chunk_end_ns_, .offset = offset_, .records_bytes = chunk_.size()};
  const std::size_t begin = begin_mcap_record(McapOp::kChunk, buffer_);
  buffer_.append(index.start_ns);
  buffer_.append(index.end_ns);
  buffer_.append(index.records_bytes);
  buffer_.append(mcap_crc(chunk_.bytes()));
  append_mcap_text("", buffer_);  // no compression
  buffer_.append(index.records_bytes);
  buffer_.append_bytes(chunk_.bytes());
  end_mcap_record(begin, buffer_);
  RISORIUS_CHECK(buffer_.size() == chunk_record_bytes(index.records_bytes));
  std::ranges::sort(chunk_ids_);
  for (const std::uint16_t id : chunk_ids_) {
    const Channel& channel = channels_[id];
    ++index.channels;
    const std::size_t record = begin_mcap_record(McapOp::kMessageIndex, buffer_);
    buffer_.append(channel.record.id);
    buffer_.append(static_cast<std::uint32_t>(kIndexEntryBytes * channel.in_chunk.size()));
    for (const auto& [time_ns, at] : channel.in_chunk) {
      buffer_.append(time_ns);
      buffer_.append(at);
    }
    end_mcap_record(record, buffer_);
  }
  chunk_.clear();
  try {
    flush(Durability::kSoon);
  } catch (const UserError&) {
    for (const std::uint16_t id : chunk_ids_) channels_[id].in_chunk.clear();
    chunk_ids_.clear();
    throw;
  }
  start_ns_ = indexes_.empty() ? index.start_ns : std::min(start_ns_, index.start_ns);
  end_ns_ = std::max(end_ns_, index.end_ns);
  indexes_.push_back(index);
  for (const std::uint16_t id : chunk_ids_) {
    Channel& channel = channels_[id];
    chunk_channels_.push_back({channel.record.id, static_cast<std::uint32_t>(channel.in_chunk.size())});
    channel.messages += channel.in_chunk.size();
    messages_ += channel.in_chunk.size();
    channel.in_chunk.clear();
  }
  chunk_ids_.clear();
}

void McapWriter::write_metadata(const McapMetadata& metadata) {
  end_chunk();
  NamedPlace place{metadata.name, offset_, 0};
  McapMetadata written = metadata;
  seal(written);
  append_mcap_record(written, buffer_);
  place.bytes = buffer_.size();
  flush(Durability::kNow);
  metadata_.push_back(std::move(place));
}

void McapWriter::finish() {
  end_chunk();
  const std::size_t end = begin_mcap_record(McapOp::kDataEnd, buffer_);
  buffer_.append(data_crc_);
  end_mcap_record(end, buffer_);
  flush(Durability::kNone);
  append_summary();
  buffer_.append_bytes(std::as_bytes(std::span(kMcapMagic)));
  flush(Durability::kNow);
  sync_.reset();
  if (::close(std::exchange(descriptor_, -1)) != 0) fail(path_, "cannot be closed", errno);
}

void McapWriter::append_group(McapOp op, std::size_t begin, std::uint64_t summary_start, ByteAppender& offsets) {
  if (buffer_.size() == begin) return;
  const std::size_t record = begin_mcap_record(McapOp::kSummaryOffset, offsets);
  offsets.append(static_cast<std::uint8_t>(op));
  offsets.append(summary_start + begin);
  offsets.append(std::uint64_t{buffer_.size() - begin});
  end_mcap_record(record, offsets);
}

void McapWriter::append_index(const Index& index, std::deque<ChunkChannel>::const_iterator channel) {
  const std::size_t record = begin_mcap_record(McapOp::kChunkIndex, buffer_);
  buffer_.append(index.start_ns);
  buffer_.append(index.end_ns);
  buffer_.append(index.offset);
  const std::uint64_t bytes = chunk_record_bytes(index.records_bytes);
  buffer_.append(bytes);
  buffer_.append(10 * index.channels);
  // The message indexes follow their chunk, in this order.
  std::uint64_t index_bytes = 0;
  for (std::uint32_t i = 0; i < index.channels; ++i, ++channel) {
    buffer_.append(channel->id);
    buffer_.append(index.offset + bytes + index_bytes);
    index_bytes += kIndexHeadBytes + kIndexEntryBytes * std::uint64_t{channel->messages};
  }
  buffer_.append(index_bytes);
  append_mcap_text("", buffer_);
  buffer_.append(index.records_bytes);
  buffer_.append(index.records_bytes);
  end_mcap_record(record, buffer_);
}

void McapWriter::append_summary() {
  // buffer_ is empty: what is appended now begins at offset_.
  const std::uint64_t start = offset_;
  ByteAppender offsets;
  std::size_t begin = buffer_.size();
  for (const McapSchema& schema : schemas_) append_mcap_record(schema, buffer_);
  append_group(McapOp::kSchema, begin, start, offsets);
  begin = buffer_.size();
  for (const Channel& channel : channels_) append_mcap_record(channel.record, buffer_);
  append_group(McapOp::kChannel, begin, start, offsets);

  begin = buffer_.size();
  const std::size_t statistics = begin_mcap_record(McapOp::kStatistics, buffer_);
  buffer_.append(messages_);
  buffer_.append(static_cast<std::uint16_t>(schemas_.size()));
  buffer_.append(static_cast<std::uint32_t>(channels_.size()));
  buffer_.append(std::uint32_t{0});  // attachments
  buffer_.append(static_cast<std::uint32_t>(metadata_.size()));
  buffer_.append(static_cast<std::uint32_t>(indexes_.size()));
  buffer_.append(start_ns_);
  buffer_.append(end_ns_);
  buffer_.append(static_cast<std::uint32_t>(10 * channels_.size()));
  for (const Channel& channel : channels_) {
    buffer_.append(channel.record.id);
    buffer_.append(channel.messages);
  }
  end_mcap_record(statistics, buffer_);
  append_group(McapOp::kStatistics, begin, start, offsets);

  begin = buffer_.size();
  auto channel = chunk_channels_.cbegin();
  for (const Index& index : indexes_) {
    append_index(index, channel);
    channel += index.channels;
  }
  append_group(McapOp::kChunkIndex, begin, start, offsets);
  begin = buffer_.size();
  for (const NamedPlace& place : metadata_) {
    const std::size_t record = begin_mcap_record(McapOp::kMetadataIndex, buffer_);
    buffer_.append(place.offset);
    buffer_.append(place.bytes);
    append_mcap_text(place.name, buffer_);
    end_mcap_record(record, buffer_);
  }
  append_group(McapOp::kMetadataIndex, begin, start, offsets);

  const std::uint64_t offsets_start = start + buffer_.size();
  buffer_.append_bytes(offsets.bytes());
  buffer_.append(static_cast<std::uint8_t>(McapOp::kFooter));
  buffer_.append(std::uint64_t{20});
  buffer_.append(start);
  buffer_.append(offsets_start);
  buffer_.append(mcap_crc(buffer_.bytes()));  // of the summary, up to here
}

void McapWriter::flush(Durability durability) {
  RISORIUS_CHECK(descriptor_ >= 0);
  std::span<const std::byte> rest = buffer_.bytes();
  std::uint64_t end = offset_;
  int problem = 0;
  while (!rest.empty() && problem == 0) {
    const ssize_t written = ::pwrite(descriptor_, rest.data(), rest.size(), static_cast<off_t>(end));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      problem = written == 0 ? ENOSPC : errno;
      break;
    }
    end += static_cast<std::uint64_t>(written);
    rest = rest.subspan(static_cast<std::size_t>(written));
  }
  if (problem == 0 && durability != Durability::kNone) {
    sync_->request();
    if (durability == Durability::kNow) sync_->wait();
    problem = sync_->take_problem();
  }
  if (problem != 0) {
    // Without half a record at its end the file can go on where it was, once there is room again.
    buffer_.clear();
    if (::ftruncate(descriptor_, static_cast<off_t>(offset_)) != 0) fail(path_, "cannot be cut back", errno);
    fail(path_, "cannot be written", problem);
  }
  data_crc_ = mcap_crc(buffer_.bytes(), data_crc_);
  offset_ = end;
  buffer_.clear();
}

}  // namespace risorius
