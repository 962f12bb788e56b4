// SIGKILL while recording: at most a second is lost, and everything before it is bit-exact.
#include <gtest/gtest.h>

#include "support/test_data.h"
#include "system/killed_session.h"

namespace risorius::test {
namespace {

TEST(SessionKill, CostsAtMostASecondAndNoEarlierFrame) {
  for (const double seconds : {0.9, 1.3, 1.7}) {
    TemporaryFolder folder;
    const KilledSession killed = record_and_kill(folder.path(), seconds);
    ASSERT_EQ(killed.problem, "") << seconds;
    EXPECT_LE(killed.lost_s, 1.0) << seconds;
    EXPECT_GT(killed.frames, 20u) << seconds;
    EXPECT_EQ(killed.corrupted_frames, 0u) << seconds;
    EXPECT_GT(killed.solved_equal, 20u) << seconds;
    EXPECT_EQ(killed.solved_different, 0u) << seconds;
  }
}

}  // namespace
}  // namespace risorius::test
