// A session through the real daemon: recorded, replayed, solved again; a full disk; and read by another implementation
// of MCAP.
#include <cstdlib>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include "replay/mcap/mcap_reader.h"
#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"
#include "system/stream_checks.h"

namespace risorius::test {
namespace {

const char* const kFace = "[[source]]\nname = \"face\"\nlisten = \"udp://127.0.0.1:0\"\n";

std::string session_key(const std::filesystem::path& file) {
  return "session = \"" + file.string() + "\"\nconsent = \"form 12\"\n";
}

Finished tool(std::vector<std::string> words) {
  words.insert(words.begin(), program("risorius").string());
  return run(words);
}

/// Streams `take` into the daemon and waits until every frame is solved.
void stream(const RunningDaemon& daemon, const std::string& take, std::uint64_t frames, const std::string& speed) {
  const auto sent = tool({"replay", take, "--to", daemon.input("face"), "--speed", speed});
  ASSERT_EQ(sent.exit_code, 0) << sent.output;
  ASSERT_TRUE(all_solved(daemon, {{"face", frames}}));
}

TEST(Session, RecordedReplayedAndSolvedAgainIsEqualBitForBit) {
  TemporaryFolder first, second;
  const auto file = first.path() / "one.mcap", again = second.path() / "two.mcap";
  RunningDaemon recording(first.path(), kFace, session_key(file));
  ASSERT_TRUE(recording.up()) << recording.process().output();
  stream(recording, "builtin:3", 360, "2");
  const auto ended = recording.end();
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("session: "), std::string::npos) << ended.output;

  const auto verified = tool({"verify", file.string()});
  EXPECT_EQ(verified.exit_code, 0) << verified.output;
  EXPECT_NE(verified.output.find("equal bit for bit"), std::string::npos) << verified.output;
  const auto info = tool({"info", file.string()});
  EXPECT_EQ(info.exit_code, 0) << info.output;
  for (const char* words : {"whole", "/face/raw", "/face/ticks", "x-risorius-tick", "form 12", "dropped ticks 0"})
    EXPECT_NE(info.output.find(words), std::string::npos) << words << " in\n" << info.output;

  // The datagrams once more: the dataset of the replay equals that of the session, file by file.
  RunningDaemon repeated(second.path(), kFace, session_key(again));
  ASSERT_TRUE(repeated.up()) << repeated.process().output();
  stream(repeated, file.string(), 360, "1");
  expect_nothing_lost(repeated.status().at("streams").at("face"), 360);
  ASSERT_EQ(repeated.end().exit_code, 0);
  expect_equal_takes(repeated.dataset() / "face-001", recording.dataset() / "face-001");
  const auto verified_again = tool({"verify", again.string()});
  EXPECT_EQ(verified_again.exit_code, 0) << verified_again.output;
}

TEST(Session, ALiveNeutralIsSolvedAgainToo) {
  TemporaryFolder folder;
  const auto file = folder.path() / "neutral.mcap";
  RunningDaemon daemon(folder.path(), kFace, session_key(file), Recording::kOff);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  Process sender({program("risorius").string(), "replay", "builtin:3", "--to", daemon.input("face"), "--quiet"});
  ASSERT_TRUE(all_solved(daemon, {{"face", 30}}));
  const auto captured =
      tool({"control", "neutral", "--connect", daemon.control(), "--stream", "face", "--seconds", "0.3"});
  EXPECT_EQ(captured.exit_code, 0) << captured.output;
  EXPECT_EQ(sender.finish().exit_code, 0);
  ASSERT_TRUE(all_solved(daemon, {{"face", 360}}));
  EXPECT_EQ(daemon.status().at("streams").at("face").at("neutral_captures"), 1);
  ASSERT_EQ(daemon.end().exit_code, 0);
  const auto verified = tool({"verify", file.string()});
  EXPECT_EQ(verified.exit_code, 0) << verified.output;
}

/// A session into `file`, with a disk that is full in the middle of it.
void record_with_a_full_disk(const std::filesystem::path& file, const std::function<void(RunningDaemon&)>& fill,
                             const std::function<void(RunningDaemon&)>& make_room) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace, session_key(file), Recording::kOff);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  stream(daemon, "builtin:2", 240, "1");
  fill(daemon);
  stream(daemon, "builtin:2", 480, "1");
  const auto full = daemon.status();
  expect_nothing_lost(full.at("streams").at("face"), 480);
  EXPECT_GT(full.at("session").at("not_written").get<std::uint64_t>(), 100u) << full.at("session").dump();
  EXPECT_NE(full.at("session").at("problem").get<std::string>(), "");
  EXPECT_TRUE(daemon.process().wait_for_output("recording: ", 5)) << "a notice at the terminal";
  // A copy as the disk had it then can be made whole.
  std::filesystem::copy_file(file, folder.path() / "torn.mcap");
  const auto recovered = tool({"recover", (folder.path() / "torn.mcap").string()});
  EXPECT_EQ(recovered.exit_code, 0) << recovered.output;
  EXPECT_NE(recovered.output.find("missing: everything after"), std::string::npos) << recovered.output;
  const auto verified = tool({"verify", (folder.path() / "torn.recovered.mcap").string()});
  EXPECT_EQ(verified.exit_code, 0) << verified.output;

  // Room again: the file goes on, and its own report says what is missing.
  make_room(daemon);
  stream(daemon, "builtin:1", 600, "1");
  const auto ended = daemon.end();
  EXPECT_EQ(ended.exit_code, 1) << "a recording with a problem is no success";
  EXPECT_NE(ended.output.find("refused by the disk"), std::string::npos) << ended.output;
  const auto info = tool({"info", file.string()});
  EXPECT_EQ(info.exit_code, 0) << info.output;
  EXPECT_NE(info.output.find("first_error"), std::string::npos) << info.output;
  EXPECT_EQ(info.output.find("not_written /face/ticks 0"), std::string::npos) << info.output;
  EXPECT_NE(info.output.find("messages of /face/ticks between"), std::string::npos) << info.output;
}

TEST(Session, AFullDiskCostsTheRecordingAndNotTheStream) {
  // A limit to the size of its files stands for the disk's.
  TemporaryFolder folder;
  const auto file = folder.path() / "full.mcap";
  rlimit before{};
  const auto fill = [&](RunningDaemon& daemon) {
    ASSERT_EQ(prlimit(daemon.process().id(), RLIMIT_FSIZE, nullptr, &before), 0);
    const rlimit tight{static_cast<rlim_t>(std::filesystem::file_size(file)) + 1000, before.rlim_max};
    ASSERT_EQ(prlimit(daemon.process().id(), RLIMIT_FSIZE, &tight, nullptr), 0);
  };
  record_with_a_full_disk(file, fill, [&](RunningDaemon& daemon) {
    ASSERT_EQ(prlimit(daemon.process().id(), RLIMIT_FSIZE, &before, nullptr), 0);
  });
}

/// A file system in memory, which only this process and its children see.
class SmallDisk {
 public:
  explicit SmallDisk(const char* size) {
    if (unshare(CLONE_NEWNS) != 0) return;
    mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
    mounted_ = mount("none", folder_.path().c_str(), "tmpfs", 0, (std::string("size=") + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(folder_.path().c_str(), MNT_DETACH);
  }
  bool is_mounted() const { return mounted_; }
  std::filesystem::path path() const { return folder_.path(); }
  /// Nothing is left of it.
  void fill() const {
    std::ofstream filler(path() / "filler", std::ios::binary);
    const std::string page(4096, 'x');
    while (filler.write(page.data(), static_cast<std::streamsize>(page.size())).flush()) {
    }
  }
  void make_room() const { std::filesystem::remove(path() / "filler"); }

 private:
  TemporaryFolder folder_;
  bool mounted_ = false;
};

TEST(Session, AFullFileSystemDoesTheSame) {
  const SmallDisk disk("32m");
  if (!disk.is_mounted()) GTEST_SKIP() << "must be allowed to mount";
  record_with_a_full_disk(
      disk.path() / "full.mcap", [&](RunningDaemon&) { disk.fill(); }, [&](RunningDaemon&) { disk.make_room(); });
}

TEST(Session, AFileThatIsThereIsNotWrittenOver) {
  TemporaryFolder folder;
  std::ofstream(folder.path() / "there.mcap") << "kept";
  RunningDaemon daemon(folder.path(), kFace, session_key(folder.path() / "there.mcap"));
  EXPECT_FALSE(daemon.up());
  EXPECT_NE(daemon.process().output().find("there.mcap"), std::string::npos) << daemon.process().output();
  EXPECT_EQ(bytes_of_file(folder.path() / "there.mcap"), "kept");
  EXPECT_FALSE(std::filesystem::exists(daemon.dataset())) << "no dataset of a service that did not start";
}

/// npm's implementation of MCAP, by the people who made the format. Installed into the build folder, once.
bool has_mcap_core(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "node_modules/@mcap/core/package.json")) return true;
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "package.json") << "{\"private\": true, \"type\": \"module\"}\n";
  const auto installed =
      run({"sh", "-c", "cd '" + folder.string() + "' && npm install --no-audit --no-fund @mcap/core@2 2>&1"}, 120);
  return installed.exit_code == 0;
}

TEST(Session, IsReadByTheFormatsOwnLibrary) {
  const std::filesystem::path node = std::filesystem::path(RISORIUS_BINARY_DIR) / "node";
  if (!has_mcap_core(node)) GTEST_SKIP() << "npm cannot install @mcap/core here";
  TemporaryFolder folder;
  const auto file = folder.path() / "session.mcap";
  RunningDaemon daemon(folder.path(), kFace, session_key(file), Recording::kOff);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  stream(daemon, "builtin:2", 240, "1");
  ASSERT_EQ(daemon.end().exit_code, 0);
  std::filesystem::copy_file(std::filesystem::path(RISORIUS_SOURCE_DIR) / "tests/system/read_mcap.mjs",
                             node / "read_mcap.mjs", std::filesystem::copy_options::overwrite_existing);
  const auto read = run({"node", (node / "read_mcap.mjs").string(), file.string()});
  ASSERT_EQ(read.exit_code, 0) << read.output;
  const auto seen = nlohmann::json::parse(read.output);
  EXPECT_EQ(seen.at("counts").at("/face/au"), 240) << read.output;
  EXPECT_EQ(seen.at("counts").at("/face/ticks"), 242) << "the set and the end of the stream, too";
  EXPECT_GE(seen.at("counts").at("/face/raw").get<int>(), 240);
  EXPECT_GE(seen.at("au_views").get<int>(), 1);
  EXPECT_EQ(seen.at("counts").at("/face/view/au"), seen.at("views_due")) << "each that was due when its frame came";
  EXPECT_LE(seen.at("views_per_second").get<int>(), 62) << "of 120, 60 a second, however long the machine took";
  EXPECT_EQ(seen.at("points"), 55) << "markers of the built-in face";
  EXPECT_EQ(seen.at("metadata").dump(), R"(["config","report","session","stream"])");
}

}  // namespace
}  // namespace risorius::test
