// Face shapes -> AUs: what stands in the place of repair and solve where a source tells shapes instead of markers.
// The versioned ARKit table reads them (takes/arkit_aus.h); the columns are the rig's, found by name (columns_for), and
// the jaw is one column or two as the rig has it. A mapped AU is a proxy, not a measurement: the frames say kMapped,
// and have neither head pose, residuals nor standard deviations.
//   no face, or a shape not told: an AU that was seen before is held, else not observed
//   columns that no shape tells of: not observed, never 0
// One thread. process allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "capture/shape_frame.h"
#include "replay/takes/arkit_aus.h"
#include "solve/rigs/rig.h"

namespace risorius {

class ShapeMapper {
 public:
  /// Shapes in the order of live_link_shape_names().
  ShapeMapper(const ArkitTable& table, const Rig& rig);

  void process(const ShapeFrame& frame, AuFrame& out) noexcept;
  /// Forgets what could be held: another take is perhaps another face. A neutral capture is cancelled; the neutral
  /// stays.
  void reset() noexcept;

  /// Columns of the rig that no shape tells of.
  const std::vector<std::string>& not_mapped() const noexcept { return not_mapped_; }

  /// From the next frame with a face on, averages the shapes for `duration_ns` of capture time; the mean is then taken
  /// off every shape (which stays 0 or above) before it is mapped.
  void begin_neutral_capture(std::int64_t duration_ns) noexcept;
  std::uint64_t neutrals_completed() const noexcept { return neutrals_completed_; }
  std::uint64_t neutrals_cancelled() const noexcept { return neutrals_cancelled_; }
  /// What is taken off, by shape; all 0 at first.
  const std::array<double, kFaceShapes>& neutral() const noexcept { return neutral_; }

 private:
  struct Column {
    std::array<std::size_t, 2> reading{};  ///< whose mean it is
    std::size_t count = 0;                 ///< 0: not mapped
    double upper_bound = 0;
  };
  void read_shapes(const ShapeFrame& frame) noexcept;
  void add_to_neutral(const ShapeFrame& frame) noexcept;
  void restart_neutral() noexcept;

  ArkitReader reader_;
  std::uint32_t au_set_id_;
  std::vector<Column> columns_;
  std::vector<std::string> not_mapped_;
  std::array<double, kFaceShapes> shapes_{};
  std::vector<double> readings_;
  std::vector<double> last_;  ///< by column; NaN: never seen

  std::array<double, kFaceShapes> neutral_{}, neutral_sum_{};
  std::array<std::uint32_t, kFaceShapes> neutral_count_{};
  bool neutral_running_ = false;
  std::int64_t neutral_duration_ns_ = 0;
  std::optional<std::int64_t> neutral_begin_ns_;
  std::uint64_t neutrals_completed_ = 0, neutrals_cancelled_ = 0;
};

}  // namespace risorius
