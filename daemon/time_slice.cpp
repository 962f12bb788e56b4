#include "daemon/time_slice.h"

#include <cstdint>
#include <sys/syscall.h>
#include <unistd.h>

namespace risorius {
namespace {

/// struct sched_attr of sched_setattr(2), which the C library does not declare.
struct SchedulingAttributes {
  std::uint32_t size = sizeof(SchedulingAttributes);
  std::uint32_t policy = 0;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime_ns = 0, deadline_ns = 0, period_ns = 0;
};
static_assert(sizeof(SchedulingAttributes) == 48);

/// All but the slice stays as it is; 0: the system's own. That it is refused is no error: then nothing changes.
void set_slice(std::uint64_t slice_ns) noexcept {
  SchedulingAttributes attributes;
  if (syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0) != 0) return;
  // Somebody gave the service a real-time policy: that is better than this.
  if (attributes.policy != 0) return;
  attributes.runtime_ns = slice_ns;
  attributes.deadline_ns = attributes.period_ns = 0;
  syscall(SYS_sched_setattr, 0, &attributes, 0);
}

}  // namespace

void ask_for_short_slices() noexcept { set_slice(100'000); }
void ask_for_usual_slices() noexcept { set_slice(0); }

}  // namespace risorius
