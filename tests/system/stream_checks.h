// What the tests of whole streams check: files equal bit for bit, ledgers that balance, nothing lost.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <utility>

#include "system/running_daemon.h"

namespace risorius::test {

inline std::string bytes_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

inline void expect_equal_takes(const std::filesystem::path& live, const std::filesystem::path& offline) {
  for (const char* file :
       {"cleaned.c3d", "au.csv", "au_sd.csv", "pose.csv", "quality.csv", "episodes.csv", "rig.json"}) {
    const std::string expected = bytes_of_file(offline / file);
    ASSERT_FALSE(expected.empty()) << offline / file;
    EXPECT_TRUE(bytes_of_file(live / file) == expected) << file << " differs between " << live << " and " << offline;
  }
}

inline void expect_balanced(const nlohmann::json& ledger, const std::string& what) {
  const auto of = [&](const char* key) { return ledger.at(key).get<std::uint64_t>(); };
  EXPECT_EQ(of("received"), of("emitted") + of("dropped") + of("refused") + of("held"))
      << what << ": " << ledger.dump();
  EXPECT_EQ(of("held"), 0u) << what;
}

inline void expect_nothing_lost(const nlohmann::json& stream, std::uint64_t frames) {
  for (const char* ledger : {"datagrams", "reorder", "admission", "despike", "fill", "solve"})
    expect_balanced(stream.at(ledger), ledger);
  expect_balanced(stream.at("frames").at("assembled"), "assembled");
  EXPECT_EQ(stream.at("processed"), frames);
  EXPECT_EQ(stream.at("frames").at("lost"), 0);
  EXPECT_EQ(stream.at("frames").at("incomplete"), 0);
  EXPECT_EQ(stream.at("datagrams").at("kernel_drops"), 0);
  EXPECT_EQ(stream.at("admission").at("dropped"), 0);
}

/// Waits until each stream has processed so many frames; false if for a minute nothing moves. How long it takes in all
/// is the machine's affair.
inline bool all_solved(const RunningDaemon& daemon, const std::map<std::string, std::uint64_t>& frames) {
  std::uint64_t processed_before = 0;
  auto moved = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - moved < std::chrono::seconds(60)) {
    const auto streams = daemon.status().at("streams");
    bool done = true;
    std::uint64_t processed = 0;
    for (const auto& [name, count] : frames) {
      const auto of_stream = streams.at(name).at("processed").get<std::uint64_t>();
      done = done && of_stream >= count;
      processed += of_stream;
    }
    if (done) return true;
    if (std::exchange(processed_before, processed) != processed) moved = std::chrono::steady_clock::now();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

}  // namespace risorius::test
