// The text of the Grammatical Facial Expressions data (UCI; Freitas et al. 2014): 100 points of a face as a Kinect's
// face tracker gave them, one line per frame: `time 0x 0y 0z 1x ...`, blank-separated, x and y in pixels of the 640 x
// 480 colour picture, z the depth in mm, 0 where the sensor had none. Points are carried into mm by the pinhole model
// with the camera's nominal focal length; markers are called P0 ... P99.
// Times are seconds and milliseconds with a point between, the milliseconds without leading zeros: 12.62 is 12.062 s.
// Read as decimal fractions they run backwards up to twice a second; read so they grow without exception.
#pragma once

#include <vector>

#include "replay/takes/csv_text.h"
#include "replay/takes/take.h"

namespace risorius {

class KinectTextReader final : public TakeReader {
 public:
  /// Whether the file begins as such a text does.
  static bool knows(const std::filesystem::path& path);

  /// Reads all times. Throws UserError (file, line, column, value, remedy).
  KinectTextReader(const std::filesystem::path& path, const TakeOptions& options);

  const TakeInfo& info() const noexcept override { return info_; }
  /// Sequence counts from 0; capture time is the file's, from the first frame.
  bool next(MarkerFrame& frame) override;
  void rewind() override;

 private:
  void name_points();
  std::int64_t read_time_ns() const;
  double read_number(std::size_t column) const;

  TakeInfo info_;
  CsvFile file_;
  std::int64_t begin_ns_ = 0;
  bool is_retimed_ = false;  ///< a rate was given: the file's times do not count
  std::uint64_t next_index_ = 0;
};

}  // namespace risorius
