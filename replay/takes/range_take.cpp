#include "replay/takes/range_take.h"

#include <fmt/format.h>

#include "capture/check.h"
#include "capture/errors.h"

namespace risorius {
namespace {

[[noreturn]] void fail_beyond_end(const TakeInfo& info, std::uint64_t first, std::uint64_t last, std::uint64_t frames) {
  throw UserError(fmt::format("{}:{}-{}", info.path.string(), first, last),
                  fmt::format("the take ends after {} frames", frames), "choose a range inside the take");
}

}  // namespace

RangeTake::RangeTake(std::unique_ptr<TakeReader> take, std::uint64_t first, std::uint64_t last)
    : take_(std::move(take)), info_(take_->info()), first_(first), last_(last) {
  RISORIUS_CHECK(first <= last);
  if (info_.frame_count && last >= *info_.frame_count) fail_beyond_end(info_, first, last, *info_.frame_count);
  info_.frame_count = last - first + 1;
}

bool RangeTake::next(MarkerFrame& frame) {
  while (next_index_ <= last_) {
    if (!take_->next(frame)) fail_beyond_end(info_, first_, last_, next_index_);
    if (next_index_++ >= first_) return true;
  }
  return false;
}

void RangeTake::rewind() {
  take_->rewind();
  next_index_ = 0;
}

}  // namespace risorius
