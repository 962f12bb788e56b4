#include "replay/unfinished_paths.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <unistd.h>

namespace risorius {
namespace {

// A signal handler may neither allocate nor lock: paths lie in fixed slots, each with one flag.
constexpr std::size_t kSlots = 256, kLongestPath = 4096;
enum : int { kFree, kBeingWritten, kEntered };
struct Slot {
  std::atomic<int> state{kFree};
  std::array<char, kLongestPath> path;
};
std::array<Slot, kSlots> slots;
static_assert(std::atomic<int>::is_always_lock_free);

void remove_and_end(int signal) {
  for (Slot& slot : slots) {
    if (slot.state.load(std::memory_order_acquire) == kEntered) ::unlink(slot.path.data());
  }
  // The inner folders were entered last.
  for (auto slot = slots.rbegin(); slot != slots.rend(); ++slot) {
    if (slot->state.load(std::memory_order_acquire) == kEntered) ::rmdir(slot->path.data());
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

UnfinishedPath::UnfinishedPath(const std::filesystem::path& path) noexcept {
  const std::string& text = path.native();
  if (text.size() >= kLongestPath) return;
  for (std::size_t i = 0; i < kSlots; ++i) {
    int expected = kFree;
    if (!slots[i].state.compare_exchange_strong(expected, kBeingWritten)) continue;
    std::memcpy(slots[i].path.data(), text.c_str(), text.size() + 1);
    slots[i].state.store(kEntered, std::memory_order_release);
    slot_ = static_cast<int>(i);
    return;
  }
}

UnfinishedPath::~UnfinishedPath() {
  if (slot_ >= 0) slots[static_cast<std::size_t>(slot_)].state.store(kFree, std::memory_order_release);
}

void remove_unfinished_paths_on_signals() noexcept {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, remove_and_end);
}

}  // namespace risorius
