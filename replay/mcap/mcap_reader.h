// Reads an MCAP file from its begin to its end, and as far as it goes if the end is missing. Chunks whose CRC does not
// fit are left out and reported, never guessed at; where the length of a record is damaged it reads on at the next
// chunk. Trusts no declared size beyond the bytes that are there, and reads no record of more than
// kMcapMostRecordBytes: that one is told as damage, and passed over. Reads what McapWriter writes, and other files with
// chunks and without compression. What stands outside of chunks is guarded by seals (mcap_records.h) where McapWriter
// wrote the file: there, a record whose kind, length or content is damaged is known for what it was, or told as damage.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "replay/mcap/mcap_records.h"

namespace risorius {

/// A part of the file that could not be read.
struct McapDamage {
  std::uint64_t offset = 0;  ///< of the record
  std::uint64_t bytes = 0;   ///< that were not read for it; 0: what it held was read all the same, or held nothing
  std::string problem;
  std::optional<std::int64_t> start_ns, end_ns;  ///< of the messages in it, as far as that is known
};

class McapReader {
 public:
  /// Throws UserError if the file cannot be opened or is no MCAP file.
  explicit McapReader(std::filesystem::path path);
  ~McapReader();
  McapReader(const McapReader&) = delete;
  McapReader& operator=(const McapReader&) = delete;

  enum class Item : std::uint8_t { kMessage, kMetadata, kEnd };
  /// The next one. Throws UserError if the file needs something that we cannot do (compression), or the disk fails.
  Item next();

  const McapMessage& message() const noexcept { return message_; }
  const McapMetadata& metadata() const noexcept { return metadata_; }
  /// Those met so far, by id.
  const std::map<std::uint16_t, McapChannel>& channels() const noexcept { return channels_; }
  const std::map<std::uint16_t, McapSchema>& schemas() const noexcept { return schemas_; }
  static constexpr std::size_t kMostDamages = 100;
  /// Met so far, the first kMostDamages of them; complete after kEnd.
  const std::vector<McapDamage>& damages() const noexcept { return damages_; }
  /// Of all of them.
  std::uint64_t damage_count() const noexcept { return damage_count_; }
  std::uint64_t damaged_bytes() const noexcept { return damaged_bytes_; }
  /// After kEnd: whether the file has its end. A whole file may have damages all the same.
  bool whole() const noexcept { return whole_; }
  const std::filesystem::path& path() const noexcept { return path_; }
  /// How far it has read, and how long the file is, in bytes.
  std::uint64_t offset() const noexcept { return offset_; }
  std::uint64_t size() const noexcept { return size_; }

 private:
  enum class Read : std::uint8_t { kRecord, kPassedOver, kNone };

  // mcap_reader.cpp: what the records say.
  Read read_record();
  void read_content(std::uint64_t length);
  void open_chunk(std::span<const std::byte> content);
  std::optional<Item> take_from_chunk();
  std::optional<Item> take_record(McapOp op, std::span<const std::byte> content);
  bool take_metadata(std::span<const std::byte> content);
  void take_data_end(std::span<const std::byte> content);
  void take_other(McapOp op, std::span<const std::byte> content);
  McapDamage& damage(std::string problem, std::uint64_t bytes);

  // mcap_reader_places.cpp: where the records are.
  void read_at(std::uint64_t offset, std::size_t bytes, std::vector<std::byte>& into);
  McapOp true_kind(McapOp op, std::uint64_t length, std::uint64_t left);
  std::optional<std::uint64_t> own_length(McapOp op, std::uint64_t left);
  std::optional<std::uint64_t> own_metadata_length(std::uint64_t left);
  std::optional<std::uint64_t> trusted_length(McapOp op, std::uint64_t length, std::uint64_t left);
  Read pass_over(McapOp op, std::uint64_t length);
  std::uint64_t bytes_after_footer();
  bool is_record_at(std::uint64_t offset);
  bool is_all_of(std::span<const std::byte> content) const;
  void lose_place(std::string problem);
  bool find_place();
  bool is_place(McapOp op, std::uint64_t& may_check);
  bool is_whole_chunk(std::uint64_t& may_check);
  bool is_sealed_metadata(std::uint64_t& may_check);
  bool is_data_end();
  bool ends_in_magic();
  std::uint64_t next_data(std::uint64_t from) const noexcept;

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0, offset_ = 0, record_offset_ = 0;
  std::uint32_t crc_ = 0;          ///< of what was read
  std::vector<std::byte> record_;  ///< the record at record_offset_
  McapOp op_{};
  std::span<const std::byte> chunk_;  ///< what is left of the chunk in record_
  bool in_chunk_ = false, ended_ = false, whole_ = false;
  bool lost_ = false;       ///< where the next record begins
  bool is_sealed_ = false;  ///< McapWriter's file
  bool had_chunk_ = false;  ///< one was met
  McapMessage message_;
  McapMetadata metadata_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::vector<McapDamage> damages_;
  McapDamage unlisted_;  ///< the last one beyond kMostDamages
  McapDamage* last_damage_ = nullptr;
  std::uint64_t damage_count_ = 0, damaged_bytes_ = 0;
};

}  // namespace risorius
