// The LiveView on a terminal, redrawn in place five times a second; where stdout is no terminal, printed once a second.
#pragma once

#include <cstdint>

#include "replay/live/live_view.h"

namespace risorius {

class LiveTable {
 public:
  LiveTable();
  LiveView& view() noexcept { return view_; }
  /// If it is time.
  void redraw();

 private:
  LiveView view_;
  bool terminal_;
  std::int64_t drawn_ns_ = 0;
  std::size_t drawn_lines_ = 0;
};

}  // namespace risorius
