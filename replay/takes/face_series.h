// A recorded face as AUs, whichever of the two ways it was written in: an AU series (au_csv.h), or face shapes, of Live
// Link Face (live_link_csv.h) or as columns of ARKit's names behind `Frame`, which become AUs by a table.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "replay/takes/arkit_aus.h"
#include "replay/takes/au_series.h"

namespace risorius {

struct FaceSeries {
  AuSeries aus;
  std::optional<double> rate_hz;  ///< as it was given, or as timecodes say
  std::vector<std::string> warnings;
};

struct FaceSeriesOptions {
  std::optional<double> rate_hz;  ///< replaces the timecodes'
  JawColumns jaw = JawColumns::kWhole;
  const ArkitTable* table = nullptr;  ///< the shipped one
};

/// Of shapes: actions only, no consequences of others. A series with an AU among its columns is one of AUs. Throws
/// UserError (file, line, column, value, remedy), also for shapes of which no AU can be read, or one that stands twice.
FaceSeries load_face_series(const std::filesystem::path& path, const FaceSeriesOptions& options = {});

}  // namespace risorius
