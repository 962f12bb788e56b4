#include "replay/evaluation/npss.h"

#include <cmath>
#include <complex>
#include <stdexcept>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace risorius {
namespace {

std::vector<double> power_of(const AuMatrix& series, Eigen::Index channel, Eigen::FFT<double>& fft) {
  std::vector<std::complex<double>> values(static_cast<std::size_t>(series.rows())), spectrum;
  for (Eigen::Index row = 0; row < series.rows(); ++row) values[static_cast<std::size_t>(row)] = series(row, channel);
  if (values.size() == 1) {
    spectrum = values;
  } else {
    fft.fwd(spectrum, values);
  }
  std::vector<double> power;
  for (const auto& x : spectrum) power.push_back(std::norm(x));
  return power;
}

double sum_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}

}  // namespace

void PowerSpectrumSimilarity::add(const AuMatrix& truth, const AuMatrix& made) {
  if (truth.rows() < 1 || truth.rows() != made.rows() || truth.cols() != made.cols())
    throw std::invalid_argument("PowerSpectrumSimilarity: truth and made differ in size, or are empty");
  Eigen::FFT<double> fft;
  for (Eigen::Index channel = 0; channel < truth.cols(); ++channel) {
    const std::vector<double> of_truth = power_of(truth, channel, fft), of_made = power_of(made, channel, fft);
    const double weight = sum_of(of_truth), made_power = sum_of(of_made);
    if (!(weight > 0)) continue;
    double gap = 0, distance = 0;
    for (std::size_t f = 0; f < of_truth.size(); ++f) {
      gap += of_truth[f] / weight - (made_power > 0 ? of_made[f] / made_power : 0);
      distance += std::abs(gap);
    }
    weighted_sum_ += weight * distance;
    weight_ += weight;
  }
}

double PowerSpectrumSimilarity::value() const noexcept { return weighted_sum_ / weight_; }

}  // namespace risorius
