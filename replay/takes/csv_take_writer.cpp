#include <cmath>
#include <stdexcept>

#include "capture/errors.h"
#include "replay/takes/csv_take.h"

namespace risorius {

CsvTakeWriter::CsvTakeWriter(const std::filesystem::path& path, MarkerSet markers)
    : marker_count_(markers.names.size()), file_(path) {
  const auto problems = problems_of(markers);
  if (!problems.empty()) throw UserError(path.string(), problems.front(), "correct the marker set");
  line_ = "frame,time_s";
  for (const std::string& name : markers.names)
    for (const char* axis : {"_x", "_y", "_z"}) {
      line_ += ',';
      append_text(line_, name + axis);
    }
  line_ += '\n';
  file_.write(line_);
}

void CsvTakeWriter::write(const MarkerFrame& frame) {
  if (frame.count != marker_count_)
    throw std::invalid_argument("CsvTakeWriter: a frame of " + std::to_string(frame.count) + " markers for a set of " +
                                std::to_string(marker_count_));
  line_.clear();
  append_number(line_, frame.header.sequence);
  line_ += ',';
  append_seconds(line_, frame.header.capture_time_ns);
  for (std::size_t i = 0; i < marker_count_; ++i) {
    const Position p = frame.position_mm[i];
    const bool present = (frame.state[i] == MarkerState::kMeasured || frame.state[i] == MarkerState::kFilled) &&
                         std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    for (const float value : {p.x, p.y, p.z}) {
      line_ += ',';
      if (present) append_number(line_, value);
    }
  }
  line_ += '\n';
  file_.write(line_);
}

void CsvTakeWriter::finish() { file_.commit(); }

}  // namespace risorius
