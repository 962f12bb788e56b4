// The records of an MCAP file (mcap.dev/spec), as far as Risorius writes and reads them: without compression, because
// marker data hardly shrinks and a recording must not wait for a compressor. Little-endian; times in ns.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "capture/wire/byte_appender.h"
#include "capture/wire/byte_io.h"

namespace risorius {

enum class McapOp : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kAttachment,
  kAttachmentIndex,
  kStatistics,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd,
};

inline constexpr std::array<std::uint8_t, 8> kMcapMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
/// Opcode and length, before each record's content.
inline constexpr std::size_t kMcapRecordHeadBytes = 9;

using McapTexts = std::map<std::string, std::string>;

/// The most that is read of one record, in bytes: many times what a chunk of half a second, or any metadata, comes to.
inline constexpr std::uint64_t kMcapMostRecordBytes = 256 << 20;
/// The end of the header's `library` in files of McapWriter: all their metadata have a seal, and outside of chunks
/// there is nothing but what McapWriter writes.
inline constexpr std::string_view kMcapSealedLibrary = ", metadata with CRC";
/// The entry of metadata that is their seal.
inline constexpr const char* kMcapSealKey = "risorius_crc32";

struct McapSchema {
  std::uint16_t id = 0;  ///< from 1; a channel's schema_id 0 means none
  std::string name, encoding, data;
  auto operator<=>(const McapSchema&) const = default;
};

struct McapChannel {
  std::uint16_t id = 0, schema_id = 0;
  std::string topic, message_encoding;
  McapTexts metadata;
  auto operator<=>(const McapChannel&) const = default;
};

/// `data` is the writer's or reader's; valid until the next call.
struct McapMessage {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::int64_t log_time_ns = 0, publish_time_ns = 0;  ///< >= 0
  std::span<const std::byte> data;
};

struct McapMetadata {
  std::string name;
  McapTexts texts;
};

/// CRC-32 as in zlib, continued from `before`.
std::uint32_t mcap_crc(std::span<const std::byte> bytes, std::uint32_t before = 0) noexcept;

// MCAP guards chunks by a CRC, but no metadata: ours have one of their own, the CRC-32 of their record's content
// without it, as 8 hexadecimal digits in an entry that other readers see as any other.

enum class McapSeal : std::uint8_t { kNone, kFits, kBroken };
void seal(McapMetadata& metadata);
/// Takes the entry out and says whether it fitted.
McapSeal take_seal(McapMetadata& metadata);

// Writing: content is appended between begin and end.

/// Returns where the record's length stands.
std::size_t begin_mcap_record(McapOp op, ByteAppender& out);
void end_mcap_record(std::size_t begin, ByteAppender& out);
void append_mcap_text(std::string_view text, ByteAppender& out);
void append_mcap_texts(const McapTexts& texts, ByteAppender& out);
void append_mcap_record(const McapSchema& schema, ByteAppender& out);
void append_mcap_record(const McapChannel& channel, ByteAppender& out);
void append_mcap_record(const McapMessage& message, ByteAppender& out);
void append_mcap_record(const McapMetadata& metadata, ByteAppender& out);

// Reading: from a record's content. False if it does not hold what it says.

bool read_mcap_text(ByteReader& in, std::string& text);
bool read_mcap_record(std::span<const std::byte> content, McapSchema& schema);
bool read_mcap_record(std::span<const std::byte> content, McapChannel& channel);
bool read_mcap_record(std::span<const std::byte> content, McapMessage& message);
bool read_mcap_record(std::span<const std::byte> content, McapMetadata& metadata);

}  // namespace risorius
