// Of one stream, for its status: whether stabilisers keep their places and the face at rest stays the rig's neutral
// (replay/pipeline/slip_watch.h). Fed off the live path by the publisher thread, at most 60 frames per second of
// capture time; any thread reads the state.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "daemon/pipeline_items.h"
#include "replay/pipeline/slip_watch.h"
#include "solve/rigs/rig.h"

namespace risorius {

class SlipMonitor {
 public:
  struct State {
    std::uint64_t count = 0;   ///< slips since the daemon began
    std::string last;          ///< "ForeHead_L slipped by 2.1 mm at 63.0 s of its take"; empty: none
    double stabiliser_mm = 0;  ///< the largest lasting change of a stabiliser
    double band_mm = 0;        ///< of the whole face against the stabilisers
    double neutral_mm = 0;     ///< rms over markers, of the face at rest against the neutral; 0 before it was at rest
  };

  /// `current_rig` is asked when a take begins and when a live neutral was taken.
  explicit SlipMonitor(std::function<Rig()> current_rig) : current_rig_(std::move(current_rig)) {}

  /// In the order of the stream. A marker set and a new neutral begin anew, an end of stream ends the watch.
  void take(const OutputItem& item);

  State state() const;

 private:
  void look_at(const SolvedFrame& frame);

  std::function<Rig()> current_rig_;
  std::optional<MarkerSet> markers_;
  std::optional<SlipWatch> watch_;  // made with the take's first frame
  std::int64_t last_fed_ns_ = 0;
  std::size_t slips_told_ = 0;  // of this watch

  mutable std::mutex mutex_;  // for state_ alone
  State state_;
};

}  // namespace risorius
