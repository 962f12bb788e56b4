#include "replay/mcap/mcap_records.h"

#include <fmt/format.h>
#include <zlib.h>

namespace risorius {
namespace {

void append_bytes_with_length(std::string_view bytes, ByteAppender& out) {
  out.append(static_cast<std::uint32_t>(bytes.size()));
  out.append_text(bytes);
}

}  // namespace

std::uint32_t mcap_crc(std::span<const std::byte> bytes, std::uint32_t before) noexcept {
  return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::size_t begin_mcap_record(McapOp op, ByteAppender& out) {
  out.append(static_cast<std::uint8_t>(op));
  const std::size_t begin = out.size();
  out.append(std::uint64_t{0});
  return begin;
}

void end_mcap_record(std::size_t begin, ByteAppender& out) {
  const std::uint64_t length = out.size() - begin - sizeof length;
  out.patch(begin, static_cast<std::uint32_t>(length));
  out.patch(begin + sizeof(std::uint32_t), static_cast<std::uint32_t>(length >> 32));
}

void append_mcap_text(std::string_view text, ByteAppender& out) { append_bytes_with_length(text, out); }

void append_mcap_texts(const McapTexts& texts, ByteAppender& out) {
  const std::size_t begin = out.size();
  out.append(std::uint32_t{0});
  for (const auto& [key, value] : texts) {
    append_mcap_text(key, out);
    append_mcap_text(value, out);
  }
  out.patch(begin, static_cast<std::uint32_t>(out.size() - begin - sizeof(std::uint32_t)));
}

void append_mcap_record(const McapSchema& schema, ByteAppender& out) {
  const std::size_t begin = begin_mcap_record(McapOp::kSchema, out);
  out.append(schema.id);
  append_mcap_text(schema.name, out);
  append_mcap_text(schema.encoding, out);
  append_bytes_with_length(schema.data, out);
  end_mcap_record(begin, out);
}

void append_mcap_record(const McapChannel& channel, ByteAppender& out) {
  const std::size_t begin = begin_mcap_record(McapOp::kChannel, out);
  out.append(channel.id);
  out.append(channel.schema_id);
  append_mcap_text(channel.topic, out);
  append_mcap_text(channel.message_encoding, out);
  append_mcap_texts(channel.metadata, out);
  end_mcap_record(begin, out);
}

void append_mcap_record(const McapMessage& message, ByteAppender& out) {
  const std::size_t begin = begin_mcap_record(McapOp::kMessage, out);
  out.append(message.channel_id);
  out.append(message.sequence);
  out.append(message.log_time_ns);
  out.append(message.publish_time_ns);
  out.append_bytes(message.data);
  end_mcap_record(begin, out);
}

void append_mcap_record(const McapMetadata& metadata, ByteAppender& out) {
  const std::size_t begin = begin_mcap_record(McapOp::kMetadata, out);
  append_mcap_text(metadata.name, out);
  append_mcap_texts(metadata.texts, out);
  end_mcap_record(begin, out);
}

namespace {

std::string seal_of(const McapMetadata& metadata) {
  ByteAppender record;
  append_mcap_record(metadata, record);
  return fmt::format("{:08x}", mcap_crc(record.bytes().subspan(kMcapRecordHeadBytes)));
}

}  // namespace

void seal(McapMetadata& metadata) {
  metadata.texts.erase(kMcapSealKey);
  metadata.texts[kMcapSealKey] = seal_of(metadata);
}

McapSeal take_seal(McapMetadata& metadata) {
  const auto entry = metadata.texts.extract(kMcapSealKey);
  if (entry.empty()) return McapSeal::kNone;
  return entry.mapped() == seal_of(metadata) ? McapSeal::kFits : McapSeal::kBroken;
}

bool read_mcap_text(ByteReader& in, std::string& text) {
  const auto length = in.read<std::uint32_t>();
  const auto bytes = in.take(length);
  if (!in.ok()) return false;
  text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return true;
}

namespace {

bool read_texts(ByteReader& in, McapTexts& texts) {
  texts.clear();
  const auto length = in.read<std::uint32_t>();
  ByteReader pairs(in.take(length));
  if (!in.ok()) return false;
  while (pairs.remaining() > 0) {
    std::string key, value;
    if (!read_mcap_text(pairs, key) || !read_mcap_text(pairs, value)) return false;
    texts[key] = value;
  }
  return true;
}

}  // namespace

bool read_mcap_record(std::span<const std::byte> content, McapSchema& schema) {
  ByteReader in(content);
  schema.id = in.read<std::uint16_t>();
  return read_mcap_text(in, schema.name) && read_mcap_text(in, schema.encoding) && read_mcap_text(in, schema.data) &&
         schema.id != 0;
}

bool read_mcap_record(std::span<const std::byte> content, McapChannel& channel) {
  ByteReader in(content);
  channel.id = in.read<std::uint16_t>();
  channel.schema_id = in.read<std::uint16_t>();
  return read_mcap_text(in, channel.topic) && read_mcap_text(in, channel.message_encoding) &&
         read_texts(in, channel.metadata);
}

bool read_mcap_record(std::span<const std::byte> content, McapMessage& message) {
  ByteReader in(content);
  message.channel_id = in.read<std::uint16_t>();
  message.sequence = in.read<std::uint32_t>();
  message.log_time_ns = in.read<std::int64_t>();
  message.publish_time_ns = in.read<std::int64_t>();
  if (!in.ok()) return false;
  message.data = in.take(in.remaining());
  return message.log_time_ns >= 0;
}

bool read_mcap_record(std::span<const std::byte> content, McapMetadata& metadata) {
  ByteReader in(content);
  return read_mcap_text(in, metadata.name) && read_texts(in, metadata.texts);
}

}  // namespace risorius
