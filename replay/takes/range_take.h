// A stretch of a take, as a take. Its frames keep the sequence numbers and capture times that they have in the whole.
#pragma once

#include <memory>

#include "replay/takes/take.h"

namespace risorius {

class RangeTake final : public TakeReader {
 public:
  /// Frames `first` to `last` of the take, as its reader counts them from 0, inclusive. Throws UserError if the take
  /// says that it ends before.
  RangeTake(std::unique_ptr<TakeReader> take, std::uint64_t first, std::uint64_t last);

  const TakeInfo& info() const noexcept override { return info_; }
  /// Throws UserError also where the take ends before the range does.
  bool next(MarkerFrame& frame) override;
  void rewind() override;

 private:
  std::unique_ptr<TakeReader> take_;
  TakeInfo info_;
  std::uint64_t first_, last_;
  std::uint64_t next_index_ = 0;  ///< in the whole take
};

}  // namespace risorius
