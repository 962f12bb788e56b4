#include "replay/evaluation/nearest_sequence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

constexpr Eigen::Index kMoments = 32;

}  // namespace

AuMatrix SequenceIndex::spread(const AuMatrix& sequence) const {
  if (sequence.rows() < 1 || sequence.cols() != aus_)
    throw std::invalid_argument("SequenceIndex: a sequence without rows, or of another number of AUs");
  AuMatrix result(kMoments, aus_);
  for (Eigen::Index moment = 0; moment < kMoments; ++moment) {
    const double at = static_cast<double>(moment) / (kMoments - 1) * static_cast<double>(sequence.rows() - 1);
    const auto from = static_cast<Eigen::Index>(at);
    const Eigen::Index to = std::min(from + 1, sequence.rows() - 1);
    const auto share = static_cast<float>(at - static_cast<double>(from));
    result.row(moment) = (1 - share) * sequence.row(from) + share * sequence.row(to);
  }
  return result;
}

void SequenceIndex::add(const AuMatrix& sequence) { sequences_.push_back(spread(sequence)); }

double SequenceIndex::nearest_rms(const AuMatrix& sequence) const {
  const AuMatrix asked = spread(sequence);
  double nearest = std::numeric_limits<double>::infinity();
  for (const AuMatrix& kept : sequences_)
    nearest = std::min(nearest, std::sqrt((kept - asked).cast<double>().array().square().mean()));
  return nearest;
}

}  // namespace risorius
