#include "capture/wire/curve_keys.h"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "capture/errors.h"
#include "support/test_data.h"

namespace risorius {
namespace {

class CurveKeys : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

  /// The text of the UserError that `load` throws.
  template <class Load>
  static std::string problem_of(Load load) {
    try {
      load();
    } catch (const UserError& error) {
      return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return {};
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(CurveKeys, AreReadBackAsTheyWereWritten) {
  const CurveKeyPair keys = make_curve_key_pair();
  write_curve_certificate(path("anna"), keys);
  EXPECT_EQ(load_curve_secret(path("anna.key_secret")).secret_key, keys.secret_key);
  EXPECT_EQ(load_curve_secret(path("anna.key_secret")).public_key, keys.public_key);
  EXPECT_EQ(load_curve_public(path("anna.key")), keys.public_key);
  EXPECT_EQ(load_curve_public(path("anna.key_secret")), keys.public_key);
  std::ifstream shared(path("anna.key"));
  const std::string text(std::istreambuf_iterator<char>(shared), {});
  EXPECT_EQ(text.find(keys.secret_key), std::string::npos) << "the secret is in the file to give away";
}

TEST_F(CurveKeys, AreOfTheirOwnersEyesOnlyAndNeverOverwritten) {
  write_curve_certificate(path("anna"), make_curve_key_pair());
  struct stat status {};
  ASSERT_EQ(::stat(path("anna.key_secret").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  const std::string before = load_curve_public(path("anna.key"));
  EXPECT_THROW(write_curve_certificate(path("anna"), make_curve_key_pair()), UserError);
  std::filesystem::remove(path("anna.key"));
  EXPECT_THROW(write_curve_certificate(path("anna"), make_curve_key_pair()), UserError);
  EXPECT_EQ(load_curve_public(path("anna.key_secret")), before);
}

TEST_F(CurveKeys, ReadsCertificatesAsOtherProgramsWriteThem) {
  write("theirs.key_secret",
        "#   ****  Generated on 2026-01-01 by pyzmq  ****\n#   ZeroMQ CURVE **Secret** Certificate\n\nmetadata\n"
        "    name = \"a = b\"\n\ncurve\n    public-key = \"Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID\"\n"
        "    secret-key = \"D:)Q[IlAW!ahhC2ac:9*A}h:p?([4%wOTJ%JR%cs\"\n");
  // The pair of libzmq's own documentation.
  EXPECT_EQ(load_curve_secret(path("theirs.key_secret")).public_key, "Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID");
}

TEST_F(CurveKeys, BadFilesAreNamedAndSecretsAreNotShown) {
  const CurveKeyPair keys = make_curve_key_pair();
  const std::string good_public = "curve\n public-key = \"" + keys.public_key + "\"\n";
  write("public.key_secret", good_public);
  write("short.key_secret", "curve\n secret-key = \"" + keys.secret_key.substr(1) + "\"\n");
  write("unquoted.key_secret", "curve\n secret-key = " + keys.secret_key + "\n");
  write("other.key_secret", good_public + " secret-key = \"" + make_curve_key_pair().secret_key + "\"\n");
  write("empty.key_secret", "");
  write("long.key_secret", std::string(100'000, 'a'));
  for (const char* name : {"public", "short", "unquoted", "other", "empty", "long", "missing"}) {
    const auto file = path(std::string(name) + ".key_secret");
    const auto problem = problem_of([&] { load_curve_secret(file); });
    EXPECT_NE(problem.find(file), std::string::npos) << problem;
    EXPECT_EQ(problem.find(keys.secret_key.substr(1)), std::string::npos) << problem;
  }
  problem_of([&] { load_curve_secret(path("")); });
  problem_of([&] { load_curve_public(path("empty.key_secret")); });
}

TEST_F(CurveKeys, AFolderOfClientsHoldsAtLeastOne) {
  EXPECT_NE(problem_of([&] { load_curve_clients(path("")); }).find("nobody could connect"), std::string::npos);
  write_curve_certificate(path("anna"), make_curve_key_pair());
  write_curve_certificate(path("ben"), make_curve_key_pair());
  auto expected = std::vector{load_curve_public(path("anna.key")), load_curve_public(path("ben.key"))};
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(load_curve_clients(path("")), expected);
  EXPECT_EQ(load_curve_clients(path("ben.key")), std::vector{load_curve_public(path("ben.key"))});
}

TEST_F(CurveKeys, AListOfClientsNeedsAKey) {
  EXPECT_TRUE(load_curve_server("", "", "[output]").keys.secret_key.empty());
  EXPECT_NE(problem_of([&] { load_curve_server("", path("clients"), "[output]"); }).find("[output] curve_clients"),
            std::string::npos);
}

}  // namespace
}  // namespace risorius
