// Where the records of a file stand, also of a damaged one: of McapReader.
#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <system_error>
#include <unistd.h>

#include "capture/errors.h"
#include "replay/mcap/mcap_chunk_head.h"
#include "replay/mcap/mcap_reader.h"

namespace risorius {
namespace {

constexpr std::uint64_t kPieceBytes = 65536;

}  // namespace

void McapReader::read_at(std::uint64_t offset, std::size_t bytes, std::vector<std::byte>& into) {
  into.resize(bytes);
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t got = ::pread(descriptor_, into.data() + done, bytes - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      throw UserError(path_.string(), "cannot be read: " + std::generic_category().message(errno),
                      "is the disk sound?");
    if (got == 0) throw UserError(path_.string(), "became shorter while it was read", "wait until nobody writes it");
    done += static_cast<std::size_t>(got);
  }
}

/// Of the record at offset_. Where its kind is damaged, what stands in it may say it all the same.
McapOp McapReader::true_kind(McapOp op, std::uint64_t length, std::uint64_t left) {
  if (length > left || own_length(op, left) == length) return op;
  std::uint64_t may_check = kMcapMostRecordBytes;
  const auto found = [&](const char* what, McapOp kind) {
    damage(fmt::format("{} whose kind is damaged ({}); read by what it says of its parts", what, static_cast<int>(op)),
           0);
    return kind;
  };
  if (op != McapOp::kChunk && own_length(McapOp::kChunk, left) == length) return found("a chunk", McapOp::kChunk);
  if (op != McapOp::kMetadata && is_sealed_metadata(may_check)) return found("metadata", McapOp::kMetadata);
  if (op != McapOp::kDataEnd && is_data_end()) return found("the end of the data", McapOp::kDataEnd);
  return op;
}

/// How long the record at offset_ is by what stands in it; nothing if it does not say, or what it says does not fit
/// together. `left`: bytes after its head.
std::optional<std::uint64_t> McapReader::own_length(McapOp op, std::uint64_t left) {
  if (op == McapOp::kDataEnd) return left >= 4 ? std::optional<std::uint64_t>(4) : std::nullopt;
  if (op == McapOp::kMetadata) return own_metadata_length(left);
  const std::uint64_t needed = op == McapOp::kChunk ? kMcapChunkHeadBytes - kMcapRecordHeadBytes : 6;
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

/// A name and a map, each with its length before it.
std::optional<std::uint64_t> McapReader::own_metadata_length(std::uint64_t left) {
  std::uint64_t length = 0;
  for (int part = 0; part < 2; ++part) {
    if (left < length + 4) return std::nullopt;
    std::vector<std::byte> bytes;
    read_at(offset_ + kMcapRecordHeadBytes + length, 4, bytes);
    length += 4 + std::uint64_t{ByteReader(bytes).read<std::uint32_t>()};
  }
  return length <= left ? std::optional(length) : std::nullopt;
}

/// The length by which to read on: the one after which another record stands, if the two that a record tells differ.
/// Nothing if neither is to be trusted.
std::optional<std::uint64_t> McapReader::trusted_length(McapOp op, std::uint64_t length, std::uint64_t left) {
  const std::uint64_t begin = offset_ + kMcapRecordHeadBytes;
  const bool tells_its_length =
      op == McapOp::kChunk || op == McapOp::kMessageIndex || op == McapOp::kDataEnd || op == McapOp::kMetadata;
  if (!tells_its_length) return op != McapOp{} && length <= left ? std::optional(length) : std::nullopt;
  const auto own = own_length(op, left);
  if (own == length) return length;
  const bool fits = length <= left && is_record_at(begin + length);
  if (op == McapOp::kDataEnd) {
    if (!is_data_end()) {
      if (fits) op_ = McapOp{};  // the kind is what is damaged
      return fits ? std::optional(length) : std::nullopt;
    }
  } else {
    // A later version of the format may add to a record; then what it says of the parts that we know leads to none.
    if (!own || !is_record_at(begin + *own)) return fits ? std::optional(length) : std::nullopt;
  }
  damage("a record whose length is damaged; read by what it says of its parts", 0);
  return own;
}

/// A record that is longer than any that is read.
McapReader::Read McapReader::pass_over(McapOp op, std::uint64_t length) {
  const std::uint64_t end = offset_ + kMcapRecordHeadBytes + length;
  std::string problem = fmt::format("{} of {} bytes, more than the {} that are read of one",
                                    op == McapOp::kChunk ? "a chunk" : "a record", length, kMcapMostRecordBytes);
  if (!is_record_at(end)) {
    lose_place(std::move(problem));
    return Read::kNone;
  }
  damage(std::move(problem), end - offset_);
  offset_ = end;
  return Read::kPassedOver;
}

/// Whether the content says no more than metadata_. A later version of the format may, but after it comes a record.
bool McapReader::is_all_of(std::span<const std::byte> content) const {
  ByteAppender again;
  append_mcap_record(metadata_, again);
  return again.size() == kMcapRecordHeadBytes + content.size();
}

/// What stands beyond the summary's footer and the magic bytes: another file, or anything else. 0 where the summary
/// cannot be followed so far.
std::uint64_t McapReader::bytes_after_footer() {
  std::uint64_t at = offset_;
  std::vector<std::byte> head;
  while (size_ - at >= kMcapRecordHeadBytes) {
    read_at(at, kMcapRecordHeadBytes, head);
    ByteReader in(head);
    const auto op = static_cast<McapOp>(in.read<std::uint8_t>());
    const auto length = in.read<std::uint64_t>();
    at += kMcapRecordHeadBytes;
    if (length > size_ - at) return 0;
    at += length;
    if (op != McapOp::kFooter) continue;
    const std::uint64_t rest = size_ - at;
    return rest > kMcapMagic.size() ? rest - kMcapMagic.size() : 0;
  }
  return 0;
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

/// How many bytes could not be read for it is known when a place is found.
void McapReader::lose_place(std::string problem) {
  damage(std::move(problem), 0);
  lost_ = true;
}

/// Goes to the next chunk, or the end of the data, after record_offset_; before the first chunk also to metadata with a
/// seal. What is passed over may hold anything, such as the bytes of another file that somebody sent us: a chunk counts
/// if its CRC fits, the end if the footer points at it.
bool McapReader::find_place() {
  std::vector<std::byte> bytes;
  std::uint64_t may_check = kMcapMostRecordBytes;
  bool found = false;
  for (std::uint64_t from = next_data(record_offset_ + 1); !found && from + kMcapRecordHeadBytes <= size_;) {
    const std::uint64_t piece = std::min(size_ - from, kPieceBytes);
    read_at(from, static_cast<std::size_t>(piece), bytes);
    // A head that the piece has a part of only is looked at in the next one.
    const bool last = from + piece == size_;
    const std::size_t heads = static_cast<std::size_t>(last ? piece : piece - kMcapChunkHeadBytes);
    for (std::size_t i = 0; i < heads && !found; ++i) {
      offset_ = from + i;
      found = is_place(static_cast<McapOp>(bytes[i]), may_check);
    }
    from = next_data(from + heads);
  }
  if (!found) offset_ = size_;
  last_damage_->bytes = offset_ - record_offset_;
  damaged_bytes_ += last_damage_->bytes;
  if (found) last_damage_->problem += fmt::format("; read on at byte {}", offset_);
  return found;
}

/// At offset_, where this opcode stands. `may_check`: bytes of contents that may still be read for this: heads that
/// promise much are cheap to forge.
bool McapReader::is_place(McapOp op, std::uint64_t& may_check) {
  if (op == McapOp::kChunk) return is_whole_chunk(may_check);
  if (op == McapOp::kMetadata) return !had_chunk_ && is_sealed_metadata(may_check);
  return op == McapOp::kDataEnd && is_data_end();
}

bool McapReader::is_whole_chunk(std::uint64_t& may_check) {
  if (size_ - offset_ < kMcapChunkHeadBytes) return false;
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
  McapChunkHead head;
  return read_chunk_head(in, head) && head.crc != 0 && mcap_crc(in.take(in.remaining())) == head.crc;
}

bool McapReader::is_sealed_metadata(std::uint64_t& may_check) {
  if (size_ - offset_ < kMcapRecordHeadBytes + 8) return false;
  const auto own = own_metadata_length(size_ - offset_ - kMcapRecordHeadBytes);
  if (!own || *own > may_check) return false;
  std::vector<std::byte> record;
  read_at(offset_ + 1, kMcapRecordHeadBytes - 1, record);
  ByteReader length(record);
  if (length.read<std::uint64_t>() != *own) return false;
  may_check -= *own;
  read_at(offset_ + kMcapRecordHeadBytes, static_cast<std::size_t>(*own), record);
  McapMetadata metadata;
  return read_mcap_record(record, metadata) && take_seal(metadata) == McapSeal::kFits;
}

bool McapReader::is_data_end() {
  constexpr std::uint64_t kDataEndBytes = kMcapRecordHeadBytes + 4, kFooterBytes = kMcapRecordHeadBytes + 20;
  if (size_ - offset_ < kDataEndBytes + kFooterBytes + kMcapMagic.size() || !ends_in_magic()) return false;
  const std::uint64_t footer = size_ - kMcapMagic.size() - kFooterBytes;
  std::vector<std::byte> bytes;
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

/// The first byte from there on that is in no hole of the file: where a file claims to be long, nothing need be read.
std::uint64_t McapReader::next_data(std::uint64_t from) const noexcept {
  const off_t data = ::lseek(descriptor_, static_cast<off_t>(from), SEEK_DATA);
  if (data < 0) return errno == ENXIO ? size_ : from;  // none; or this file system does not know
  return static_cast<std::uint64_t>(data);
}

}  // namespace risorius
