#include "replay/evaluation/npss.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <stdexcept>

namespace risorius {
namespace {

/// Eight frames of a cosine of `cycles` cycles.
AuMatrix cosine(double cycles, double amplitude = 1, double phase = 0) {
  AuMatrix series(8, 1);
  for (int row = 0; row < 8; ++row)
    series(row, 0) = static_cast<float>(amplitude * std::cos(2 * std::numbers::pi * cycles * row / 8 + phase));
  return series;
}

double npss(const AuMatrix& truth, const AuMatrix& made) {
  PowerSpectrumSimilarity similarity;
  similarity.add(truth, made);
  return similarity.value();
}

AuMatrix beside(const AuMatrix& a, const AuMatrix& b) {
  AuMatrix both(a.rows(), 2);
  both << a, b;
  return both;
}

TEST(PowerSpectrumSimilarity, IsNoneForTheSameRhythmWhateverItsPhaseAndStrength) {
  EXPECT_NEAR(npss(cosine(1), cosine(1)), 0, 1e-6);
  EXPECT_NEAR(npss(cosine(1), cosine(1, 0.3, 1.1)), 0, 1e-6);
}

TEST(PowerSpectrumSimilarity, IsTheEarthMoversDistanceOfTheSpectra) {
  // Half of the power lies in bins 1 and 7, and in 3 and 5: 0.5 differs in each of the bins 1, 2, 5 and 6.
  EXPECT_NEAR(npss(cosine(1), cosine(3)), 2.0, 1e-6);
  EXPECT_NEAR(npss(cosine(3), cosine(1)), 2.0, 1e-6);
}

TEST(PowerSpectrumSimilarity, WeighsChannelsAndSequencesByTheTruthsPower) {
  // Distance 2 with power 1, and distance 0 with power 4: 2 / 5.
  EXPECT_NEAR(npss(beside(cosine(1), cosine(1, 2)), beside(cosine(3), cosine(1, 2))), 0.4, 1e-6);
  PowerSpectrumSimilarity similarity;
  similarity.add(cosine(1), cosine(3));
  similarity.add(cosine(1, 2), cosine(1, 2));
  EXPECT_NEAR(similarity.value(), 0.4, 1e-6);
}

TEST(PowerSpectrumSimilarity, AChannelWithoutPowerHasNoWeightAndNothingMadeIsFarAway) {
  EXPECT_NEAR(npss(beside(cosine(1), AuMatrix::Zero(8, 1)), beside(cosine(1), cosine(2))), 0, 1e-6);
  // cumsum of the truth is 0.5 in bins 1 to 6 and 1 in bin 7; of nothing it is 0.
  EXPECT_NEAR(npss(cosine(1), AuMatrix::Zero(8, 1)), 4.0, 1e-6);
  EXPECT_TRUE(std::isnan(npss(AuMatrix::Zero(8, 1), cosine(1))));
}

TEST(PowerSpectrumSimilarity, TakesLengthsThatAreNoPowersOfTwo) {
  for (const int rows : {1, 2, 41, 97, 402}) {
    AuMatrix series(rows, 1);
    for (int row = 0; row < rows; ++row) series(row, 0) = 0.1F + static_cast<float>(row % 5);
    EXPECT_NEAR(npss(series, series), 0, 1e-9) << rows;
  }
}

TEST(PowerSpectrumSimilarity, RefusesSizesThatDiffer) {
  PowerSpectrumSimilarity similarity;
  EXPECT_THROW(similarity.add(AuMatrix::Zero(8, 1), AuMatrix::Zero(7, 1)), std::invalid_argument);
  EXPECT_THROW(similarity.add(AuMatrix::Zero(8, 1), AuMatrix::Zero(8, 2)), std::invalid_argument);
  EXPECT_THROW(similarity.add(AuMatrix(0, 1), AuMatrix(0, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
