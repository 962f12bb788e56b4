#include "replay/mcap/mcap_reader.h"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::uint64_t kPieceBytes = 65536;
/// Of a chunk without compression, up to its records, with opcode and length.
constexpr std::uint64_t kChunkHeadBytes = kMcapRecordHeadBytes + 40;
/// Contents that are read to look for a place once: many chunks.
constexpr std::uint64_t kMostCheckedBytes = 256 << 20;
constexpr const char* kRemedy = "give a recording of risoriusd, or another MCAP file";

/// Of a chunk, before its records.
struct ChunkHead {
  std::int64_t start_ns = 0, end_ns = 0;
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
  std::string compression;
  std::uint64_t stored_bytes = 0;
};

/// The others may be large (attachments), and say nothing that we need.
bool is_of_interest(McapOp op) {
  return op == McapOp::kChunk || op == McapOp::kMessage || op == McapOp::kMetadata || op == McapOp::kChannel ||
         op == McapOp::kSchema;
}

bool read_head(ByteReader& in, ChunkHead& head) {
  head.start_ns = in.read<std::int64_t>();
  head.end_ns = in.read<std::int64_t>();
  head.bytes = in.read<std::uint64_t>();
  head.crc = in.read<std::uint32_t>();
  if (!read_mcap_text(in, head.compression)) return false;
  head.stored_bytes = in.read<std::uint64_t>();
  return in.ok() && head.stored_bytes == in.remaining();
}

}  // namespace

McapReader::McapReader(std::filesystem::path path) : path_(std::move(path)) {
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) {
    throw UserError(path_.string(), "cannot be opened: " + std::generic_category().message(errno), kRemedy);
  }
  struct stat status {};
  std::vector<std::byte> magic;
  const bool is_file = ::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  size_ = is_file ? static_cast<std::uint64_t>(status.st_size) : 0;
  if (size_ >= kMcapMagic.size()) read_at(0, kMcapMagic.size(), magic);
  const bool is_mcap =
      magic.size() == kMcapMagic.size() && std::ranges::equal(magic, std::as_bytes(std::span(kMcapMagic)));
  if (!is_mcap) {
    ::close(descriptor_);
    throw UserError(path_.string(), is_file ? "is no MCAP file" : "is no file", kRemedy);
  }
  offset_ = kMcapMagic.size();
  crc_ = mcap_crc(magic);
}

McapReader::~McapReader() { ::close(descriptor_); }

void McapReader::read_at(std::uint64_t offset, std::size_t bytes, std::vector<std::byte>& into) {
  into.resize(bytes);
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t got = ::pread(descriptor_, into.data() + done, bytes - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw UserError(path_.string(), "cannot be read: " + std::generic_category().message(errno), kRemedy);
    if (got == 0) throw UserError(path_.string(), "became shorter while it was read", "wait until nobody writes it");
    done += static_cast<std::size_t>(got);
  }
}

void McapReader::damage(std::string problem) { damages_.push_back({record_offset_, std::move(problem), {}, {}}); }

void McapReader::lose_place(std::string problem) {
  damage(std::move(problem));
  lost_ = true;
}

/// How long the record at offset_ is by what stands in it; nothing if it does not say, or what it says does not fit
/// together. `left`: bytes after its head.
std::optional<std::uint64_t> McapReader::own_length(McapOp op, std::uint64_t left) {
  if (op == McapOp::kDataEnd) return left >= 4 ? std::optional<std::uint64_t>(4) : std::nullopt;
  const std::uint64_t needed = op == McapOp::kChunk ? kChunkHeadBytes - kMcapRecordHeadBytes : 6;
  if ((op != McapOp::kChunk && op != McapOp::kMessageIndex) || left < needed) return std::nullopt;
  std::vector<std::byte> head;
  read_at(offset_ + kMcapRecordHeadBytes, static_cast<std::size_t>(needed), head);
  ByteReader in(head);
  if (op == McapOp::kMessageIndex) {
    in.take(2);
    const std::uint64_t length = 6 + std::uint64_t{in.read<std::uint32_t>()};
    return length <= left ? std::optional(length) : std::nullopt;
  }
  in.take(16);  // times
  const auto records_bytes = in.read<std::uint64_t>();
  in.take(4);  // CRC
  const auto compression_bytes = in.read<std::uint32_t>();
  if (compression_bytes != 0 || in.read<std::uint64_t>() != records_bytes || records_bytes > left - needed)
    return std::nullopt;
  return records_bytes + needed;
}

/// The length by which to read on: the one after which another record stands, if the two that a record tells differ.
/// Nothing if neither is to be trusted.
std::optional<std::uint64_t> McapReader::trusted_length(McapOp op, std::uint64_t length, std::uint64_t left) {
  const std::uint64_t begin = offset_ + kMcapRecordHeadBytes;
  const bool tells_its_length = op == McapOp::kChunk || op == McapOp::kMessageIndex || op == McapOp::kDataEnd;
  if (!tells_its_length) return op != McapOp{} && length <= left ? std::optional(length) : std::nullopt;
  const auto own = own_length(op, left);
  if (own == length) return length;
  if (length <= left && is_record_at(begin + length)) return length;
  if (!own || !is_record_at(begin + *own)) return std::nullopt;
  damage("a record whose length is damaged; read by what it says of its parts");
  return own;
}

/// Whether the content says no more than metadata_. A later version of the format may, but after it comes a record.
bool McapReader::is_all_of(std::span<const std::byte> content) const {
  ByteAppender again;
  append_mcap_record(metadata_, again);
  return again.size() == kMcapRecordHeadBytes + content.size();
}

/// Whether what stands there looks like the head of a record.
bool McapReader::is_record_at(std::uint64_t offset) {
  if (offset > size_ || size_ - offset < kMcapRecordHeadBytes) return false;
  std::vector<std::byte> head;
  read_at(offset, kMcapRecordHeadBytes, head);
  ByteReader in(head);
  const auto op = static_cast<McapOp>(in.read<std::uint8_t>());
  const auto length = in.read<std::uint64_t>();
  return op >= McapOp::kHeader && op <= McapOp::kDataEnd && length <= size_ - offset - kMcapRecordHeadBytes;
}

/// Goes to the next chunk, or the end of the data, after record_offset_. What is passed over may hold anything, such as
/// the bytes of another file that somebody sent us: a chunk counts if its CRC fits, the end if the footer points at it.
bool McapReader::find_place() {
  std::vector<std::byte> bytes;
  std::uint64_t may_check = kMostCheckedBytes;
  for (std::uint64_t from = record_offset_ + 1; from + kMcapRecordHeadBytes <= size_;) {
    const std::uint64_t piece = std::min(size_ - from, kPieceBytes);
    read_at(from, static_cast<std::size_t>(piece), bytes);
    // A head that the piece has a part of only is looked at in the next one.
    const bool last = from + piece == size_;
    const std::size_t heads = static_cast<std::size_t>(last ? piece : piece - kChunkHeadBytes);
    for (std::size_t i = 0; i < heads; ++i) {
      const auto op = static_cast<McapOp>(bytes[i]);
      if (op != McapOp::kChunk && op != McapOp::kDataEnd) continue;
      offset_ = from + i;
      if (op == McapOp::kChunk ? !is_whole_chunk(may_check) : !is_data_end()) continue;
      damages_.back().problem += fmt::format("; read on at byte {}", offset_);
      return true;
    }
    from += heads;
  }
  offset_ = size_;
  return false;
}

/// At offset_. `may_check`: bytes of contents that may still be read for this: heads that promise much are cheap to
/// forge.
bool McapReader::is_whole_chunk(std::uint64_t& may_check) {
  if (size_ - offset_ < kChunkHeadBytes) return false;
  const std::uint64_t left = size_ - offset_ - kMcapRecordHeadBytes;
  const auto own = own_length(McapOp::kChunk, left);
  if (!own || *own > may_check) return false;
  std::vector<std::byte> record;
  read_at(offset_ + 1, kMcapRecordHeadBytes - 1, record);
  ByteReader length(record);
  if (length.read<std::uint64_t>() != *own) return false;
  may_check -= *own;
  std::vector<std::byte> content;
  read_at(offset_ + kMcapRecordHeadBytes, static_cast<std::size_t>(*own), content);
  ByteReader in(content);
  ChunkHead head;
  return read_head(in, head) && head.crc != 0 && mcap_crc(in.take(in.remaining())) == head.crc;
}

/// At offset_.
bool McapReader::is_data_end() {
  constexpr std::uint64_t kDataEndBytes = kMcapRecordHeadBytes + 4, kFooterBytes = kMcapRecordHeadBytes + 20;
  if (size_ - offset_ < kDataEndBytes + kFooterBytes + kMcapMagic.size() || !ends_in_magic()) return false;
  const std::uint64_t footer = size_ - kMcapMagic.size() - kFooterBytes;
  std::vector<std::byte> bytes;
  read_at(offset_ + 1, 8, bytes);
  ByteReader length(bytes);
  if (length.read<std::uint64_t>() != 4) return false;
  read_at(footer, kMcapRecordHeadBytes + 8, bytes);
  ByteReader in(bytes);
  const auto op = static_cast<McapOp>(in.read<std::uint8_t>());
  in.take(8);
  const auto summary = in.read<std::uint64_t>();
  return op == McapOp::kFooter && (summary == 0 ? footer : summary) == offset_ + kDataEndBytes;
}

bool McapReader::ends_in_magic() {
  std::vector<std::byte> magic;
  read_at(size_ - kMcapMagic.size(), kMcapMagic.size(), magic);
  return std::ranges::equal(magic, std::as_bytes(std::span(kMcapMagic)));
}

bool McapReader::read_record() {
  record_offset_ = offset_;
  const std::uint64_t left = size_ - offset_;
  if (left < kMcapRecordHeadBytes) {
    if (left > 0) damage(fmt::format("ends {} bytes into a record", left));
    return false;
  }
  read_at(offset_, kMcapRecordHeadBytes, record_);
  ByteReader in(record_);
  op_ = static_cast<McapOp>(in.read<std::uint8_t>());
  const auto told = in.read<std::uint64_t>();
  const auto trusted = trusted_length(op_, told, left - kMcapRecordHeadBytes);
  if (!trusted) {
    lose_place(told > left - kMcapRecordHeadBytes
                   ? fmt::format("a record of {} bytes, of which {} are there", told, left - kMcapRecordHeadBytes)
                   : fmt::format("a record of kind {} that cannot have {} bytes", static_cast<int>(op_), told));
    // The head of a torn chunk says from when on messages are missing.
    if (op_ == McapOp::kChunk && left >= kMcapRecordHeadBytes + 16) {
      read_at(offset_ + kMcapRecordHeadBytes, 16, record_);
      ByteReader times(record_);
      damages_.back().start_ns = times.read<std::int64_t>();
      damages_.back().end_ns = times.read<std::int64_t>();
    }
    return false;
  }
  const std::uint64_t length = *trusted;
  offset_ += kMcapRecordHeadBytes;
  if (op_ == McapOp::kDataEnd) {
    read_at(offset_, static_cast<std::size_t>(length), record_);
    return true;  // its CRC is of what stands before it
  }
  crc_ = mcap_crc(record_, crc_);
  for (std::uint64_t end = offset_ + length; offset_ < end;) {
    // What is of no interest goes through in pieces, for the CRC only.
    const std::uint64_t piece = is_of_interest(op_) ? length : std::min(end - offset_, kPieceBytes);
    read_at(offset_, static_cast<std::size_t>(piece), record_);
    crc_ = mcap_crc(record_, crc_);
    offset_ += piece;
  }
  if (length == 0) record_.clear();
  return true;
}

McapReader::Item McapReader::next() {
  while (true) {
    if (in_chunk_) {
      if (const auto item = take_from_chunk()) return *item;
      continue;
    }
    if (std::exchange(lost_, false)) ended_ = !find_place();
    if (ended_) return Item::kEnd;
    if (!read_record()) {
      ended_ = !lost_;
      continue;
    }
    if (op_ == McapOp::kChunk) {
      open_chunk(record_);
    } else if (const auto item = take_record(op_, record_)) {
      return *item;
    }
  }
}

void McapReader::open_chunk(std::span<const std::byte> content) {
  ByteReader in(content);
  ChunkHead head;
  if (!read_head(in, head)) return damage("a chunk whose parts do not fit its length");
  if (!head.compression.empty()) {
    throw UserError(path_.string(), fmt::format("is compressed ({})", shown(head.compression)),
                    "write it without compression: mcap compress --compression none");
  }
  chunk_ = in.take(in.remaining());
  if (head.bytes != chunk_.size() || (head.crc != 0 && mcap_crc(chunk_) != head.crc)) {
    damage("a chunk whose CRC does not fit");
    damages_.back().start_ns = head.start_ns;
    damages_.back().end_ns = head.end_ns;
    return;
  }
  in_chunk_ = true;
}

std::optional<McapReader::Item> McapReader::take_from_chunk() {
  ByteReader in(chunk_);
  if (in.remaining() == 0) {
    in_chunk_ = false;
    return std::nullopt;
  }
  const auto op = static_cast<McapOp>(in.read<std::uint8_t>());
  const auto length = in.read<std::uint64_t>();
  const auto content = in.take(in.ok() && length <= in.remaining() ? static_cast<std::size_t>(length) : SIZE_MAX);
  if (!in.ok()) {
    damage("a record beyond the end of its chunk");
    in_chunk_ = false;
    return std::nullopt;
  }
  chunk_ = chunk_.last(in.remaining());
  return take_record(op, content);
}

std::optional<McapReader::Item> McapReader::take_record(McapOp op, std::span<const std::byte> content) {
  switch (op) {
    case McapOp::kMessage:
      if (!in_chunk_) {
        // Nothing vouches for it; and the ends of a damaged chunk look just so.
        damage("a message outside of a chunk, without a CRC");
        break;
      }
      if (read_mcap_record(content, message_) && channels_.contains(message_.channel_id)) return Item::kMessage;
      damage("a message that is too short, or of no channel");
      break;
    case McapOp::kMetadata:
      if (read_mcap_record(content, metadata_) && (in_chunk_ || is_all_of(content) || is_record_at(offset_)))
        return Item::kMetadata;
      if (in_chunk_) {
        damage("metadata that do not fit their length");
      } else {
        lose_place("metadata that do not fit their length");
      }
      break;
    case McapOp::kChannel: {
      McapChannel channel;
      if (read_mcap_record(content, channel)) {
        channels_.insert_or_assign(channel.id, std::move(channel));
      } else {
        damage("a channel that does not fit its length");
      }
      break;
    }
    case McapOp::kSchema: {
      McapSchema schema;
      if (read_mcap_record(content, schema)) {
        schemas_.insert_or_assign(schema.id, std::move(schema));
      } else {
        damage("a schema that does not fit its length");
      }
      break;
    }
    case McapOp::kDataEnd: {
      ByteReader in(content);
      if (const auto crc = in.read<std::uint32_t>(); crc != 0 && crc != crc_ && damages_.empty())
        damage("the CRC of the whole file does not fit: something outside of its chunks was changed");
      // What follows is the summary, which repeats what we know; only that it is all there is of interest.
      offset_ += content.size();
      whole_ = size_ - offset_ >= kMcapMagic.size() && ends_in_magic();
      if (!whole_) damage("the summary is torn");
      ended_ = true;
      break;
    }
    default:
      break;  // indexes, attachments, and what later versions of the format may have
  }
  return std::nullopt;
}

}  // namespace risorius
