#include "replay/takes/c3d_writer.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "capture/errors.h"
#include "replay/takes/c3d_preamble.h"

namespace risorius {
namespace {

// The fourth word: high byte camera mask, low byte residual. A residual of 0 without a camera is what the format calls
// interpolated; a measured point therefore names one camera (the first), although its residual is not known.
constexpr float kMeasuredWord = 256.0f;
constexpr float kFilledWord = 0.0f;
constexpr float kMissingWord = -1.0f;

const MarkerSet& validated(const MarkerSet& markers, const std::string& place) {
  const auto problems = problems_of(markers);
  if (!problems.empty()) throw UserError(place, problems.front(), "correct the marker set");
  if (!(markers.rate_hz > 0))
    throw UserError(place, "the rate of the take is not stated", "a C3D file needs one; give it");
  return markers;
}

bool is_finite(Position p) noexcept { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

}  // namespace

C3dWriter::C3dWriter(const std::filesystem::path& path, MarkerSet markers, std::string software_version)
    : markers_(validated(markers, path.string())), software_version_(std::move(software_version)), file_(path) {
  constexpr std::size_t kMaxVersionBytes = 127;
  if (software_version_.size() > kMaxVersionBytes) software_version_.resize(kMaxVersionBytes);
  file_.write(encode_c3d_preamble(markers_, software_version_, 0));
}

void C3dWriter::write(const MarkerFrame& frame) {
  if (frame.count != markers_.names.size())
    throw std::invalid_argument("C3dWriter: a frame of " + std::to_string(frame.count) + " markers for a set of " +
                                std::to_string(markers_.names.size()));
  if (frame_count_ == std::numeric_limits<std::uint32_t>::max())
    throw UserError(file_.path().string(), "more than 2^32 - 1 frames", "write the take in parts");
  frame_bytes_.clear();
  for (std::size_t i = 0; i < frame.count; ++i) {
    const MarkerState state = frame.state[i];
    const bool present =
        (state == MarkerState::kMeasured || state == MarkerState::kFilled) && is_finite(frame.position_mm[i]);
    const Position p = present ? frame.position_mm[i] : Position();
    for (const float value : {p.x, p.y, p.z}) append_c3d_float(frame_bytes_, value);
    append_c3d_float(frame_bytes_, !present                        ? kMissingWord
                                   : state == MarkerState::kFilled ? kFilledWord
                                                                   : kMeasuredWord);
  }
  file_.write(frame_bytes_);
  ++frame_count_;
}

void C3dWriter::finish() {
  if (frame_count_ == 0)
    throw UserError(file_.path().string(), "no frame was written", "a take has at least one frame");
  file_.overwrite(0, encode_c3d_preamble(markers_, software_version_, frame_count_));
  file_.commit();
}

}  // namespace risorius
