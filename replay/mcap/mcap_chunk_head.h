// What a chunk's record holds before its records.
#pragma once

#include <cstdint>
#include <string>

#include "capture/wire/byte_io.h"
#include "replay/mcap/mcap_records.h"

namespace risorius {

/// Of a chunk without compression, up to its records, with opcode and length.
inline constexpr std::uint64_t kMcapChunkHeadBytes = kMcapRecordHeadBytes + 40;

struct McapChunkHead {
  std::int64_t start_ns = 0, end_ns = 0;
  std::uint64_t bytes = 0;  ///< of the records, before compression
  std::uint32_t crc = 0;    ///< of them; 0: none
  std::string compression;
  std::uint64_t stored_bytes = 0;
};

/// Leaves the chunk's records in `in`. False if they are not as many bytes as it says.
inline bool read_chunk_head(ByteReader& in, McapChunkHead& head) {
  head.start_ns = in.read<std::int64_t>();
  head.end_ns = in.read<std::int64_t>();
  head.bytes = in.read<std::uint64_t>();
  head.crc = in.read<std::uint32_t>();
  if (!read_mcap_text(in, head.compression)) return false;
  head.stored_bytes = in.read<std::uint64_t>();
  return in.ok() && head.stored_bytes == in.remaining();
}

}  // namespace risorius
