#include "replay/dataset/manifest.h"

#include <cstdlib>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

/// The system's own tool is the other implementation; its exit status.
int sha256sum_check(const std::filesystem::path& folder) {
  const std::string command =
      "cd '" + folder.string() + "' && sha256sum --quiet --strict -c " + kManifestName + " >/dev/null 2>&1";
  return std::system(command.c_str());
}

TEST(Manifest, KnowsTheDigestsOfTheStandard) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "message";
  // FIPS 180-4's examples: "abc", and the empty message.
  test::write_bytes(path, "abc");
  EXPECT_EQ(sha256_of_file(path), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  test::write_bytes(path, "");
  EXPECT_EQ(sha256_of_file(path), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Manifest, IsAcceptedBySha256sumUntilAFileChanges) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "take 1" / "deep");
  test::write_bytes(folder.path() / "README.md", "# Data\n");
  test::write_bytes(folder.path() / "take 1" / "au.csv", std::string(200'000, 'x'));
  test::write_bytes(folder.path() / "take 1" / "deep" / "back\\slash\nline", "odd name");
  write_manifest(folder.path());
  EXPECT_EQ(sha256sum_check(folder.path()), 0) << test::read_bytes(folder.path() / kManifestName);
  test::write_bytes(folder.path() / "take 1" / "au.csv", std::string(200'000, 'y'));
  EXPECT_NE(sha256sum_check(folder.path()), 0);
  write_manifest(folder.path());  // over the old one, which it leaves out
  EXPECT_EQ(sha256sum_check(folder.path()), 0);
}

TEST(Manifest, IsSortedAndDoesNotListItself) {
  const test::TemporaryFolder folder;
  for (const char* name : {"b", "a", "c"}) test::write_bytes(folder.path() / name, "abc");
  write_manifest(folder.path());
  write_manifest(folder.path());
  const std::string digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
  EXPECT_EQ(test::read_bytes(folder.path() / kManifestName), digest + "  a\n" + digest + "  b\n" + digest + "  c\n");
}

TEST(Manifest, RefusesAFolderThatIsNotThere) {
  EXPECT_THROW(write_manifest("/nowhere/absent"), UserError);
  EXPECT_THROW(sha256_of_file("/nowhere/absent"), UserError);
}

}  // namespace
}  // namespace risorius
