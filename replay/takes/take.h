// A take is a recorded stream of marker frames in a file. It is read by an iterator, frame by frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"

namespace risorius {

struct TakeInfo {
  std::filesystem::path path;
  MarkerSet markers;  ///< names, rate, and the unit and axes of the file's numbers
  std::optional<std::uint64_t> frame_count;
  std::vector<std::string> warnings;  ///< oddities of the file that were survived, one sentence each
};

/// Beyond this many frames a leap of frame numbers is a wrong number, not a loss: a quarter of an hour at 120 Hz.
inline constexpr std::uint64_t kLongestLeap = 108'000;

/// What the file itself does not say, or says wrongly; given by the user.
struct TakeOptions {
  std::optional<double> mm_per_unit;  ///< overrides the file's unit
  std::optional<Axes> axes;           ///< the file's axes; "LUF" if not given
  std::optional<double> rate_hz;      ///< overrides the file's rate
};

class TakeReader {
 public:
  virtual ~TakeReader() = default;
  virtual const TakeInfo& info() const noexcept = 0;
  /// The next frame in mm and LUF axes; false at the end. Sequence counts from 0; capture time is sequence / rate.
  /// Throws UserError (file, frame, remedy) where the file is damaged.
  virtual bool next(MarkerFrame& frame) = 0;
  /// Back to the first frame.
  virtual void rewind() = 0;
};

/// Opens by extension: .c3d, .csv, .trc, .txt (IEMOCAP, Kinect), .bnd or a folder of them (BU-4DFE). Throws UserError.
std::unique_ptr<TakeReader> open_take(const std::filesystem::path& path, const TakeOptions& options = {});

class TakeWriter {
 public:
  virtual ~TakeWriter() = default;
  virtual void write(const MarkerFrame& frame) = 0;
  /// Completes the file; without it the file is not valid. Throws UserError (disk full and so on).
  virtual void finish() = 0;
};

/// "PATH" or "PATH:FROM-TO" (frame indices from 0, inclusive), as the command line gives takes.
struct TakeRange {
  std::filesystem::path path;
  std::optional<std::uint64_t> first, last;
};
TakeRange parse_take_range(std::string_view text);

/// Capture time of frame `index` at `rate_hz`, rounded to the nearest ns. rate_hz > 0.
std::int64_t capture_time_of(std::uint64_t index, double rate_hz) noexcept;

}  // namespace risorius
