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
#include "replay/mcap/mcap_chunk_head.h"

namespace risorius {
namespace {

constexpr std::uint64_t kPieceBytes = 65536;
constexpr const char* kRemedy = "give a recording of risoriusd, or another MCAP file";

/// The others may be large (attachments), and say nothing that we need.
bool is_of_interest(McapOp op) {
  return op == McapOp::kChunk || op == McapOp::kMessage || op == McapOp::kMetadata || op == McapOp::kChannel ||
         op == McapOp::kSchema;
}

std::uint64_t with_head(std::span<const std::byte> content) { return kMcapRecordHeadBytes + content.size(); }

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
  damages_.reserve(kMostDamages);  // last_damage_ points into it
  offset_ = kMcapMagic.size();
  crc_ = mcap_crc(magic);
}

McapReader::~McapReader() { ::close(descriptor_); }

McapDamage& McapReader::damage(std::string problem, std::uint64_t bytes) {
  ++damage_count_;
  damaged_bytes_ += bytes;
  last_damage_ = damages_.size() < kMostDamages ? &damages_.emplace_back() : &unlisted_;
  *last_damage_ = {record_offset_, bytes, std::move(problem), {}, {}};
  return *last_damage_;
}

McapReader::Item McapReader::next() {
  while (true) {
    if (in_chunk_) {
      if (const auto item = take_from_chunk()) return *item;
      continue;
    }
    if (std::exchange(lost_, false)) ended_ = !find_place();
    if (ended_) return Item::kEnd;
    const Read read = read_record();
    if (read == Read::kNone) ended_ = !lost_;
    if (read != Read::kRecord) continue;
    if (op_ == McapOp::kChunk) {
      open_chunk(record_);
    } else if (const auto item = take_record(op_, record_)) {
      return *item;
    }
  }
}

/// kNone: the file ends here, or the place is lost.
McapReader::Read McapReader::read_record() {
  record_offset_ = offset_;
  const std::uint64_t left = size_ - offset_;
  if (left < kMcapRecordHeadBytes) {
    if (left > 0) damage(fmt::format("ends {} bytes into a record", left), left);
    return Read::kNone;
  }
  read_at(offset_, kMcapRecordHeadBytes, record_);
  ByteReader in(record_);
  op_ = static_cast<McapOp>(in.read<std::uint8_t>());
  const auto told = in.read<std::uint64_t>();
  const std::uint64_t room = left - kMcapRecordHeadBytes;
  op_ = true_kind(op_, told, room);
  had_chunk_ = had_chunk_ || op_ == McapOp::kChunk;
  const auto trusted = trusted_length(op_, told, room);
  if (!trusted) {
    lose_place(told > room ? fmt::format("a record of {} bytes, of which {} are there", told, room)
                           : fmt::format("a record of kind {} that cannot have {} bytes", static_cast<int>(op_), told));
    // The head of a torn chunk says from when on messages are missing.
    if (op_ == McapOp::kChunk && room >= 16) {
      read_at(offset_ + kMcapRecordHeadBytes, 16, record_);
      ByteReader times(record_);
      last_damage_->start_ns = times.read<std::int64_t>();
      last_damage_->end_ns = times.read<std::int64_t>();
    }
    return Read::kNone;
  }
  if (is_of_interest(op_) && *trusted > kMcapMostRecordBytes) return pass_over(op_, *trusted);
  read_content(*trusted);
  return Read::kRecord;
}

/// Into record_; `length` bytes after the record's head, which stands there.
void McapReader::read_content(std::uint64_t length) {
  offset_ += kMcapRecordHeadBytes;
  if (op_ == McapOp::kDataEnd) {
    read_at(offset_, static_cast<std::size_t>(length), record_);
    return;  // its CRC is of what stands before it
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
}

void McapReader::open_chunk(std::span<const std::byte> content) {
  ByteReader in(content);
  McapChunkHead head;
  if (!read_chunk_head(in, head)) {
    damage("a chunk whose parts do not fit its length", with_head(content));
    return;
  }
  if (!head.compression.empty()) {
    throw UserError(path_.string(), fmt::format("is compressed ({})", shown(head.compression)),
                    "write it without compression: mcap compress --compression none");
  }
  chunk_ = in.take(in.remaining());
  if (head.bytes != chunk_.size() || (head.crc != 0 && mcap_crc(chunk_) != head.crc)) {
    damage("a chunk whose CRC does not fit", with_head(content));  // its times may be as wrong as the rest
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
    damage("a record beyond the end of its chunk", chunk_.size());
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
        damage("a message outside of a chunk, without a CRC", with_head(content));
        break;
      }
      if (read_mcap_record(content, message_) && channels_.contains(message_.channel_id)) return Item::kMessage;
      damage("a message that is too short, or of no channel", with_head(content));
      break;
    case McapOp::kMetadata:
      if (take_metadata(content)) return Item::kMetadata;
      break;
    case McapOp::kChannel: {
      McapChannel channel;
      if (read_mcap_record(content, channel)) {
        channels_.insert_or_assign(channel.id, std::move(channel));
      } else {
        damage("a channel that does not fit its length", with_head(content));
      }
      break;
    }
    case McapOp::kSchema: {
      McapSchema schema;
      if (read_mcap_record(content, schema)) {
        schemas_.insert_or_assign(schema.id, std::move(schema));
      } else {
        damage("a schema that does not fit its length", with_head(content));
      }
      break;
    }
    case McapOp::kDataEnd:
      take_data_end(content);
      break;
    default:
      take_other(op, content);
      break;
  }
  return std::nullopt;
}

/// Into metadata_; false if they are damaged.
bool McapReader::take_metadata(std::span<const std::byte> content) {
  const bool is_read = read_mcap_record(content, metadata_);
  if (!is_read || !(in_chunk_ || is_all_of(content) || is_record_at(offset_))) {
    if (in_chunk_ || is_record_at(offset_)) {
      damage("metadata that do not fit their length", with_head(content));
    } else {
      lose_place("metadata that do not fit their length");
    }
    return false;
  }
  const McapSeal found = take_seal(metadata_);
  const bool is_sound = found == McapSeal::kFits || (found == McapSeal::kNone && !is_sealed_);
  if (!is_sound) damage("metadata whose CRC does not fit: " + shown(metadata_.name), with_head(content));
  return is_sound;
}

void McapReader::take_data_end(std::span<const std::byte> content) {
  ByteReader in(content);
  const auto crc = in.read<std::uint32_t>();
  if (crc != 0 && crc != crc_ && damage_count_ == 0)
    damage("the CRC of the whole file does not fit: something outside of its chunks was changed", 0);
  // What follows is the summary, which repeats what we know; only that it is all there is of interest.
  offset_ += content.size();
  whole_ = size_ - offset_ >= kMcapMagic.size() && ends_in_magic();
  if (!whole_) damage("the summary is torn", size_ - offset_);
  if (const std::uint64_t beyond = bytes_after_footer(); beyond > 0)
    damage(fmt::format("{} bytes after the file's end, which are not read", beyond), beyond);
  ended_ = true;
}

/// Indexes, attachments, and what later versions of the format may have: of no interest, but for the header, which says
/// who wrote the file.
void McapReader::take_other(McapOp op, std::span<const std::byte> content) {
  const bool is_header = op == McapOp::kHeader && !in_chunk_ && record_offset_ == kMcapMagic.size();
  if (is_header) {
    ByteReader in(content);
    std::string profile, library;
    is_sealed_ = read_mcap_text(in, profile) && read_mcap_text(in, library) && library.ends_with(kMcapSealedLibrary);
    return;
  }
  if (is_sealed_ && !in_chunk_ && op != McapOp::kMessageIndex)
    damage(fmt::format("a record of kind {}, of which such a file has none", static_cast<int>(op)),
           offset_ - record_offset_);
}

}  // namespace risorius
