// What a process holds, as /proc tells it.
#pragma once

#include <cstddef>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sys/types.h>
#include <unistd.h>

namespace risorius::test {

struct ProcessUsage {
  double resident_bytes = 0;
  std::size_t descriptors = 0;
};

inline ProcessUsage usage_of(pid_t id) {
  const std::filesystem::path folder = "/proc/" + std::to_string(id);
  ProcessUsage usage;
  double pages_in_all = 0, resident_pages = 0;
  std::ifstream(folder / "statm") >> pages_in_all >> resident_pages;
  usage.resident_bytes = resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE));
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder / "fd")) ++usage.descriptors;
  return usage;
}

/// That all its threads have worked so far.
inline double processor_seconds(pid_t id) {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(id, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace risorius::test
