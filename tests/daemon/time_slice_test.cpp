#include "daemon/time_slice.h"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/utsname.h>
#include <thread>
#include <unistd.h>

namespace risorius {
namespace {

/// Of the calling thread, ns, by sched_getattr(2): its slice stands where a deadline policy has its runtime.
std::uint64_t slice_ns() {
  std::array<std::byte, 48> attributes{};
  EXPECT_EQ(syscall(SYS_sched_getattr, 0, attributes.data(), attributes.size(), 0), 0);
  std::uint64_t runtime_ns = 0;
  std::memcpy(&runtime_ns, attributes.data() + 24, sizeof runtime_ns);
  return runtime_ns;
}

bool system_takes_wishes() {
  utsname name{};
  uname(&name);
  int major = 0, minor = 0;
  std::sscanf(name.release, "%d.%d", &major, &minor);
  return major > 6 || (major == 6 && minor >= 12);
}

TEST(TimeSlice, IsShortForTheThreadAndThoseThatItMakesUntilTheyAskOtherwise) {
  if (!system_takes_wishes()) GTEST_SKIP() << "Linux before 6.12";
  std::thread([] {
    const std::uint64_t usual_ns = slice_ns();
    ask_for_short_slices();
    EXPECT_EQ(slice_ns(), 100'000u);
    std::thread([usual_ns] {
      EXPECT_EQ(slice_ns(), 100'000u) << "inherited";
      ask_for_usual_slices();
      EXPECT_EQ(slice_ns(), usual_ns);
    }).join();
    EXPECT_EQ(slice_ns(), 100'000u) << "another thread's wish is its own";
  }).join();
}

TEST(TimeSlice, LeavesNicenessAlone) {
  std::thread([] {
    // Of this thread alone, as Linux has it.
    errno = 0;
    ASSERT_NE(nice(1), -1) << errno;
    const int before = nice(0);
    ask_for_short_slices();
    EXPECT_EQ(nice(0), before);
  }).join();
}

}  // namespace
}  // namespace risorius
