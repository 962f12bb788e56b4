// Each fuzz target over its seeds, over what long runs and past findings left (corpus/NAME), and over seeded mutations of
// both: a moment of ./run fuzz in every run of the suite, under whatever sanitizer it has.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <ostream>
#include <vector>

#include "fuzz/fuzz_target.h"
#include "replay/performer/random.h"

namespace risorius::fuzz {
/// Names of tests show the target, not its bytes.
void PrintTo(const Target& target, std::ostream* out) { *out << target.name; }

namespace {

constexpr int kMutations = 3000;  // of each target
constexpr std::size_t kMostBytes = 20'000;

std::vector<Bytes> corpus_of(const Target& target) {
  std::vector<Bytes> corpus = target.seeds();
  const auto folder = std::filesystem::path(RISORIUS_SOURCE_DIR) / "tests/fuzz/corpus" / target.name;
  std::vector<std::filesystem::path> paths;
  if (std::filesystem::exists(folder)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) paths.push_back(entry.path());
  }
  std::ranges::sort(paths);
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    corpus.push_back(bytes_of(std::string(std::istreambuf_iterator<char>(file), {})));
  }
  return corpus;
}

/// One to eight changes: bytes, bits, numbers at their limits, pieces left out, doubled or taken from another input.
Bytes mutated(Bytes input, const std::vector<Bytes>& corpus, Random& random) {
  for (std::size_t changes = 1 + random.index(8); changes > 0; --changes) {
    if (input.empty()) input.push_back(std::byte{0});
    const std::size_t at = random.index(input.size());
    const auto here = input.begin() + static_cast<std::ptrdiff_t>(at);
    const auto length = static_cast<std::ptrdiff_t>(1 + random.index(std::min<std::size_t>(64, input.size() - at)));
    switch (random.index(7)) {
      case 0:
        *here = static_cast<std::byte>(random.index(256));
        break;
      case 1:
        *here ^= static_cast<std::byte>(1u << random.index(8));
        break;
      case 2:
        std::fill_n(here, std::min<std::ptrdiff_t>(length, 4), random.chance(0.5) ? std::byte{0xff} : std::byte{0});
        break;
      case 3:
        input.erase(here, here + length);
        break;
      case 4: {
        const Bytes piece(here, here + length);
        input.insert(here, piece.begin(), piece.end());
        break;
      }
      case 5:
        input.resize(at);
        break;
      case 6: {
        const Bytes& other = corpus[random.index(corpus.size())];
        if (other.empty()) break;
        const std::size_t from = random.index(other.size());
        const Bytes piece(other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
        input.insert(here, piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(random.index(piece.size() + 1)));
        break;
      }
    }
  }
  if (input.size() > kMostBytes) input.resize(kMostBytes);
  return input;
}

class Fuzz : public testing::TestWithParam<Target> {};

TEST_P(Fuzz, TargetTakesItsSeedsPastFindingsAndMutationsOfThem) {
  const Target& target = GetParam();
  const auto corpus = corpus_of(target);
  ASSERT_FALSE(target.seeds().empty());
  ASSERT_GT(corpus.size(), target.seeds().size()) << "no tests/fuzz/corpus/" << target.name << ": tests/fuzz/distil";
  target.run({});
  for (const Bytes& input : corpus) target.run(input);
  Random random(20, 0);
  for (int i = 0; i < kMutations; ++i) target.run(mutated(corpus[random.index(corpus.size())], corpus, random));
}

INSTANTIATE_TEST_SUITE_P(All, Fuzz, testing::ValuesIn(targets().begin(), targets().end()),
                         [](const auto& target) { return std::string(target.param.name); });

TEST(FuzzInput, RecordsAreReadAsTheyWereWritten) {
  Bytes input;
  append_record(0x41, bytes_of("one"), input);
  append_record(2, Bytes(300, std::byte{7}), input);
  input.push_back(std::byte{1});  // a beginning that is not whole
  std::span<const std::byte> rest = input;
  Record record;
  ASSERT_TRUE(take_record(rest, record));
  EXPECT_EQ(record.control, 0x41u);
  EXPECT_EQ(record.bytes, bytes_of("one"));
  ASSERT_TRUE(take_record(rest, record));
  EXPECT_EQ(record.bytes, Bytes(300, std::byte{7}));
  EXPECT_FALSE(take_record(rest, record));
}

}  // namespace
}  // namespace risorius::fuzz
