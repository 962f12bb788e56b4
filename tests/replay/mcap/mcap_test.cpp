// Writer and reader against each other; what others make of our files is tested in tests/system.
#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <sys/resource.h>

#include "capture/errors.h"
#include "replay/mcap/mcap_reader.h"
#include "replay/mcap/mcap_writer.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using Item = McapReader::Item;

struct Seen {
  std::vector<std::pair<std::int64_t, std::string>> messages;  ///< time, topic and content
  std::vector<std::string> metadata;
  std::vector<McapTexts> texts;  ///< of the metadata
  std::vector<McapDamage> damages;
  std::uint64_t damage_count = 0, damaged_bytes = 0;
  bool whole = false;
};

Seen read_all(const std::filesystem::path& path) {
  McapReader reader(path);
  Seen seen;
  for (Item item = reader.next(); item != Item::kEnd; item = reader.next()) {
    if (item == Item::kMetadata) {
      seen.metadata.push_back(reader.metadata().name);
      seen.texts.push_back(reader.metadata().texts);
      continue;
    }
    const McapMessage& message = reader.message();
    seen.messages.emplace_back(
        message.log_time_ns, reader.channels().at(message.channel_id).topic + ":" +
                                 std::string(reinterpret_cast<const char*>(message.data.data()), message.data.size()));
  }
  seen.damages = reader.damages();
  seen.damage_count = reader.damage_count();
  seen.damaged_bytes = reader.damaged_bytes();
  seen.whole = reader.whole();
  EXPECT_EQ(reader.next(), Item::kEnd) << "the end stays the end";
  return seen;
}

class Mcap : public testing::Test {
 protected:
  std::filesystem::path path(const std::string& name = "session.mcap") const { return folder_.path() / name; }

  static void write(McapWriter& writer, std::uint16_t channel, std::int64_t time_ns, const std::string& text) {
    writer.write({.channel_id = channel,
                  .sequence = 7,
                  .log_time_ns = time_ns,
                  .publish_time_ns = time_ns,
                  .data = std::as_bytes(std::span(text.data(), text.size()))});
  }

  /// Three chunks of two messages each, metadata after the first chunk.
  void write_three_chunks(McapWriter& writer) const {
    const auto schema = writer.add_schema("Frame", "jsonschema", "{}");
    const auto a = writer.add_channel(schema, "/a", "json", {{"rig", "builtin"}});
    const auto b = writer.add_channel(0, "/b", "msgpack");
    for (std::int64_t chunk = 0; chunk < 3; ++chunk) {
      write(writer, a, 100 * chunk + 10, "first");
      write(writer, chunk == 1 ? a : b, 100 * chunk + 20, "second");
      writer.end_chunk();
      if (chunk == 0) writer.write_metadata({"config", {{"toml", "[record]"}}});
    }
  }
  const std::vector<std::pair<std::int64_t, std::string>> three_chunks_{{10, "/a:first"},  {20, "/b:second"},
                                                                        {110, "/a:first"}, {120, "/a:second"},
                                                                        {210, "/a:first"}, {220, "/b:second"}};

  std::string bytes() const {
    std::ifstream file(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  Seen read_bytes(const std::string& bytes) const {
    std::ofstream(path("other.mcap"), std::ios::binary) << bytes;
    return read_all(path("other.mcap"));
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(Mcap, WhatIsWrittenIsReadBack) {
  McapWriter writer(path());
  write_three_chunks(writer);
  writer.finish();
  EXPECT_EQ(writer.messages(), 6u);
  const Seen seen = read_all(path());
  EXPECT_EQ(seen.messages, three_chunks_);
  EXPECT_EQ(seen.metadata, std::vector<std::string>{"config"});
  EXPECT_TRUE(seen.whole);
  EXPECT_TRUE(seen.damages.empty());
  McapReader reader(path());
  reader.next();
  EXPECT_EQ(reader.channels().at(0).metadata.at("rig"), "builtin");
  EXPECT_EQ(reader.schemas().at(1).encoding, "jsonschema");
}

TEST_F(Mcap, WhatStandsBehindTheEndIsTold) {
  {
    McapWriter writer(path());
    write_three_chunks(writer);
    writer.finish();
  }
  const std::string file = bytes();
  const Seen seen = read_bytes(file + file);
  EXPECT_EQ(seen.messages, three_chunks_);
  EXPECT_TRUE(seen.whole);
  ASSERT_EQ(seen.damages.size(), 1u);
  EXPECT_NE(seen.damages[0].problem.find("after the file's end"), std::string::npos) << seen.damages[0].problem;
  EXPECT_EQ(seen.damaged_bytes, file.size());
}

TEST_F(Mcap, WithoutItsEndEveryChunkOnTheDiskIsReadable) {
  {
    McapWriter writer(path());
    write_three_chunks(writer);
    write(writer, 0, 310, "never in a chunk on the disk");
  }
  const Seen seen = read_all(path());
  EXPECT_EQ(seen.messages, three_chunks_);
  EXPECT_FALSE(seen.whole);
}

TEST_F(Mcap, CutAnywhereItGivesWhatCameBeforeAndSaysWhatIsMissing) {
  {
    McapWriter writer(path());
    write_three_chunks(writer);
    writer.finish();
  }
  const std::string whole = bytes();
  std::size_t most = 0;
  for (std::size_t length = 8; length < whole.size(); ++length) {
    const Seen seen = read_bytes(whole.substr(0, length));
    ASSERT_FALSE(seen.whole) << length;
    ASSERT_GE(seen.messages.size(), most) << length << ": more bytes, fewer messages";
    most = seen.messages.size();
    ASSERT_TRUE(std::equal(seen.messages.begin(), seen.messages.end(), three_chunks_.begin())) << length;
    for (const McapDamage& damage : seen.damages) {
      if (damage.start_ns) {
        ASSERT_EQ(*damage.start_ns, three_chunks_.at(most).first) << length;
      }
    }
  }
  EXPECT_EQ(most, three_chunks_.size());
  for (std::size_t length = 0; length < 8; ++length) EXPECT_THROW(read_bytes(whole.substr(0, length)), UserError);
}

TEST_F(Mcap, AFlippedBitCostsAtMostItsOwnChunk) {
  {
    McapWriter writer(path());
    write_three_chunks(writer);
    writer.finish();
  }
  const std::string whole = bytes();
  std::mt19937 random(1);
  std::size_t damaged = 0;
  const std::size_t chunk = whole.find("second");  // inside the first chunk's records
  for (const std::size_t at : {chunk, chunk + 1, chunk + 5}) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ 0x10);
    const Seen seen = read_bytes(broken);
    ASSERT_EQ(seen.damages.size(), 1u);
    EXPECT_EQ(seen.damages[0].start_ns, std::nullopt) << "nothing vouches for its head";
    EXPECT_EQ(seen.messages, std::vector(three_chunks_.begin() + 2, three_chunks_.end()));
    EXPECT_TRUE(seen.whole);
  }
  // Anywhere, and many: whatever is given on was written so.
  for (int i = 0; i < 2000; ++i) {
    std::string broken = whole;
    for (int flips = 0; flips < 1 + i % 3; ++flips) {
      const std::size_t at = 8 + random() % (whole.size() - 8);
      broken[at] = static_cast<char>(broken[at] ^ (1U << random() % 8));
    }
    try {
      const Seen seen = read_bytes(broken);
      damaged += seen.damages.empty() ? 0 : 1;
      ASSERT_TRUE(seen.messages == three_chunks_ || !seen.damages.empty()) << i << ": a silent loss";
      for (const auto& message : seen.messages) {
        ASSERT_NE(std::find(three_chunks_.begin(), three_chunks_.end(), message), three_chunks_.end()) << i;
      }
    } catch (const UserError&) {
      ++damaged;  // a flip made it a compressed chunk
    }
  }
  EXPECT_GT(damaged, 500u);
}

/// Where the records outside of chunks begin, by walking over their lengths.
std::vector<std::pair<McapOp, std::size_t>> records_of(const std::string& bytes) {
  std::vector<std::pair<McapOp, std::size_t>> records;
  for (std::size_t at = kMcapMagic.size(); at + kMcapRecordHeadBytes < bytes.size();) {
    records.emplace_back(static_cast<McapOp>(bytes[at]), at);
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data() + at + 1, sizeof length);
    at += kMcapRecordHeadBytes + length;
  }
  return records;
}

TEST_F(Mcap, ADamagedLengthCostsNothingWhereTheRecordTellsItTwice) {
  {
    McapWriter writer(path());
    write_three_chunks(writer);
    writer.finish();
  }
  const std::string whole = bytes();
  std::size_t chunk = 0;
  for (const auto& [op, at] : records_of(whole)) {
    if (op == McapOp::kDataEnd) break;
    chunk += op == McapOp::kChunk ? 1 : 0;
    if (op != McapOp::kChunk && op != McapOp::kMessageIndex && op != McapOp::kMetadata) continue;
    // A little shorter, a little longer, over the next chunk, beyond the end of the file, and absurd.
    for (const std::uint64_t length : {3ULL, 70ULL, 300ULL, 1ULL << 20, ~0ULL}) {
      SCOPED_TRACE(testing::Message() << "record " << static_cast<int>(op) << " at " << at << ", " << length);
      std::string broken = whole;
      std::memcpy(broken.data() + at + 1, &length, sizeof length);
      const Seen seen = read_bytes(broken);
      EXPECT_EQ(seen.messages, three_chunks_);
      EXPECT_TRUE(seen.whole);
      EXPECT_EQ(seen.metadata.size(), 1u);
      ASSERT_EQ(seen.damages.size(), 1u);
      EXPECT_EQ(seen.damages[0].offset, at);
      EXPECT_EQ(seen.damaged_bytes, 0u);
      EXPECT_NE(seen.damages[0].problem.find("by what it says of its parts"), std::string::npos)
          << seen.damages[0].problem;
    }
  }
  EXPECT_EQ(chunk, 3u);
}

TEST_F(Mcap, AnyDamagedBitOfMetadataIsKnownAlsoInATornFile) {
  {
    McapWriter writer(path());
    writer.write_metadata({"session", {{"consent", "form 12"}}});
    write_three_chunks(writer);
  }
  const std::string whole = bytes();
  std::size_t metadata = 0;
  for (const auto& [op, at] : records_of(whole)) {
    if (op != McapOp::kMetadata) continue;
    const McapTexts own = metadata++ == 0 ? McapTexts{{"consent", "form 12"}} : McapTexts{{"toml", "[record]"}};
    std::uint64_t length = 0;
    std::memcpy(&length, whole.data() + at + 1, sizeof length);
    for (std::size_t bit = 0; bit < 8 * (kMcapRecordHeadBytes + length); ++bit) {
      SCOPED_TRACE(testing::Message() << "metadata " << metadata << ", bit " << bit);
      std::string broken = whole;
      broken[at + bit / 8] = static_cast<char>(broken[at + bit / 8] ^ (1U << bit % 8));
      const Seen seen = read_bytes(broken);
      ASSERT_EQ(seen.messages, three_chunks_);
      ASSERT_GE(seen.damage_count, 1u);
      ASSERT_GE(seen.metadata.size(), 1u) << "the others are read";
      if (seen.metadata.size() == 2u) {
        ASSERT_EQ(seen.texts[metadata - 1], own);
      }
    }
  }
  EXPECT_EQ(metadata, 2u);
}

TEST_F(Mcap, ADamagedKindIsToldAndCostsNothingWhereTheRecordTellsItTwice) {
  {
    McapWriter writer(path());
    write_three_chunks(writer);
    writer.finish();
  }
  const std::string whole = bytes();
  std::size_t chunks = 0;
  for (const auto& [op, at] : records_of(whole)) {
    if (op == McapOp::kHeader) continue;  // by which it is known whose file it is
    if (op == McapOp::kSchema) break;     // the summary
    chunks += op == McapOp::kChunk ? 1 : 0;
    for (std::size_t bit = 0; bit < 8; ++bit) {
      SCOPED_TRACE(testing::Message() << "record " << static_cast<int>(op) << " at " << at << ", bit " << bit);
      std::string broken = whole;
      broken[at] = static_cast<char>(broken[at] ^ (1U << bit));
      const Seen seen = read_bytes(broken);
      EXPECT_EQ(seen.messages, three_chunks_);
      EXPECT_EQ(seen.metadata.size(), 1u);
      EXPECT_TRUE(seen.whole);
      ASSERT_EQ(seen.damage_count, 1u);
      EXPECT_EQ(seen.damages[0].offset, at);
    }
  }
  EXPECT_EQ(chunks, 3u);
}

TEST_F(Mcap, OfManyDamagesTheFirstHundredAreListedAndAllAreCounted) {
  constexpr std::size_t kChunks = 150;
  {
    McapWriter writer(path());
    const auto channel = writer.add_channel(0, "/a", "raw");
    for (std::size_t chunk = 0; chunk < kChunks; ++chunk) {
      write(writer, channel, static_cast<std::int64_t>(chunk), "content");
      writer.end_chunk();
    }
    writer.finish();
  }
  std::string broken = bytes();
  std::uint64_t chunk_bytes = 0;
  for (const auto& [op, at] : records_of(broken)) {
    if (op != McapOp::kChunk) continue;
    std::uint64_t length = 0;
    std::memcpy(&length, broken.data() + at + 1, sizeof length);
    chunk_bytes += kMcapRecordHeadBytes + length;
    broken[at + kMcapRecordHeadBytes + length - 1] = 'X';
  }
  const Seen seen = read_bytes(broken);
  EXPECT_TRUE(seen.messages.empty());
  EXPECT_EQ(seen.damages.size(), McapReader::kMostDamages);
  EXPECT_EQ(seen.damage_count, kChunks);
  EXPECT_EQ(seen.damaged_bytes, chunk_bytes);
}

TEST_F(Mcap, AChunkOfHundredsOfGigabytesIsToldAndPassedOver) {
  {
    McapWriter writer(path());
    write_three_chunks(writer);
  }
  const std::string whole = bytes();
  std::vector<std::size_t> chunks;
  for (const auto& [op, at] : records_of(whole)) {
    if (op == McapOp::kChunk) chunks.push_back(at);
  }
  ASSERT_EQ(chunks.size(), 3u);
  constexpr std::uint64_t kRecordsBytes = 200'000'000'000, kLength = kRecordsBytes + 40;
  std::string head = whole.substr(0, chunks[2]);
  std::memcpy(head.data() + chunks[1] + 1, &kLength, 8);
  for (const std::size_t at : {25, 41}) std::memcpy(head.data() + chunks[1] + at, &kRecordsBytes, 8);
  head.resize(chunks[1] + 49);
  // A hole in the file, with and without another chunk behind it.
  const std::uint64_t end = chunks[1] + kMcapRecordHeadBytes + kLength;
  std::ofstream(path("sparse.mcap"), std::ios::binary) << head;
  std::error_code error;
  std::filesystem::resize_file(path("sparse.mcap"), end, error);
  if (error) GTEST_SKIP() << "this file system has no such files: " << error.message();
  const Seen torn = read_all(path("sparse.mcap"));
  EXPECT_EQ(torn.messages, std::vector(three_chunks_.begin(), three_chunks_.begin() + 2));
  ASSERT_EQ(torn.damages.size(), 1u);
  EXPECT_EQ(torn.damages[0].offset, chunks[1]);
  EXPECT_EQ(torn.damaged_bytes, end - chunks[1]);
  EXPECT_NE(torn.damages[0].problem.find("200000000040 bytes"), std::string::npos) << torn.damages[0].problem;

  std::ofstream(path("sparse.mcap"), std::ios::binary | std::ios::app) << whole.substr(chunks[2]);
  const Seen seen = read_all(path("sparse.mcap"));
  auto expected = three_chunks_;
  expected.erase(expected.begin() + 2, expected.begin() + 4);
  EXPECT_EQ(seen.messages, expected);
  ASSERT_EQ(seen.damages.size(), 1u);
  EXPECT_EQ(seen.damaged_bytes, end - chunks[1]);
}

/// A recording holds what others send: bytes that look like the file's own must not be taken for it.
TEST_F(Mcap, WhatSomebodySentIsNotTakenForTheFile) {
  std::string forged;
  {
    McapWriter writer(path("forged.mcap"));
    const auto channel = writer.add_channel(0, "/forged", "json");
    write(writer, channel, 5, "never recorded");
    writer.finish();
    std::ifstream file(path("forged.mcap"), std::ios::binary);
    forged.assign(std::istreambuf_iterator<char>(file), {});
  }
  // Its chunk's CRC does not fit; its end is an end.
  const std::size_t at = forged.find("never");
  forged[at] = 'N';
  {
    McapWriter writer(path());
    const auto channel = writer.add_channel(0, "/a", "raw");
    for (std::int64_t chunk = 0; chunk < 3; ++chunk) {
      write(writer, channel, 100 * chunk, forged);
      writer.end_chunk();
    }
    writer.finish();
  }
  std::string broken = bytes();
  const auto records = records_of(broken);
  const auto first = std::ranges::find(records, McapOp::kChunk, [](const auto& record) { return record.first; });
  // Neither the record's length nor what it says of its parts.
  for (const std::size_t byte : {first->second + 1, first->second + 25, first->second + 41})
    broken[byte] = static_cast<char>(broken[byte] ^ 1);
  const Seen seen = read_bytes(broken);
  ASSERT_EQ(seen.messages.size(), 2u) << "the other two chunks";
  EXPECT_EQ(seen.messages[0], (std::pair<std::int64_t, std::string>(100, "/a:" + forged)));
  EXPECT_TRUE(seen.whole);
  EXPECT_FALSE(seen.damages.empty());
}

TEST_F(Mcap, WhatCannotBeNumberedIsRefused) {
  McapWriter writer(path());
  for (int i = 0; i < 65535; ++i) writer.add_channel(0, "/a", "raw");
  EXPECT_THROW(writer.add_channel(0, "/a", "raw"), UserError);
}

TEST_F(Mcap, NeverWritesOverAFile) {
  std::ofstream(path()) << "something";
  EXPECT_THROW(McapWriter writer(path()), UserError);
  EXPECT_THROW(McapWriter writer(path("no/such/folder.mcap")), UserError);
}

TEST_F(Mcap, AFullDiskCostsTheChunkAndNotTheFile) {
  McapWriter writer(path());
  const auto channel = writer.add_channel(0, "/a", "json");
  write(writer, channel, 1, "before");
  writer.end_chunk();
  // A limit to the size of files stands for the disk's.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{writer.bytes_written() + 100, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  write(writer, channel, 2, std::string(10'000, 'x'));
  EXPECT_THROW(writer.end_chunk(), UserError);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  write(writer, channel, 3, "after");
  writer.finish();
  const Seen seen = read_all(path());
  EXPECT_TRUE(seen.whole);
  EXPECT_TRUE(seen.damages.empty());
  EXPECT_EQ(seen.messages, (std::vector<std::pair<std::int64_t, std::string>>{{1, "/a:before"}, {3, "/a:after"}}));
  EXPECT_EQ(writer.messages(), 2u);
}

}  // namespace
}  // namespace risorius
