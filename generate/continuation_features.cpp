#include "generate/continuation_features.h"

#include <algorithm>
#include <cmath>

namespace risorius {
namespace {

constexpr double kTauS = 0.08, kVelocityWindowS = 0.05;
constexpr float kLeastScale = 0.01F, kMostInput = 4;
constexpr std::size_t kRecentLags = 6;                     ///< up to 100 ms, counted four times
constexpr std::array<std::size_t, 3> kOtherLags{1, 3, 7};  ///< 33, 67 and 167 ms
constexpr std::size_t kRoughFrames = 6;

float limited(float value) noexcept { return std::clamp(value, -kMostInput, kMostInput); }

}  // namespace

double damped_way(double ahead_s) noexcept { return -kTauS * std::expm1(-ahead_s / kTauS); }

ContinuationFeatureMaker::ContinuationFeatureMaker(const std::vector<std::string>& names)
    : other_(other_sides(names)),
      rows_(AuMatrix::Zero(kMoments, static_cast<Eigen::Index>(names.size()))),
      times_ns_(kMoments) {
  for (const std::string& name : names) kinds_.push_back(kind_of_au(name));
}

ContinuationFeatures ContinuationFeatureMaker::allocate() const {
  const auto aus = static_cast<Eigen::Index>(size());
  return {AuMatrix::Zero(aus, kContinuationWidth), Eigen::VectorXf::Zero(aus), Eigen::VectorXf::Zero(aus),
          Eigen::VectorXf::Zero(aus)};
}

void ContinuationFeatureMaker::observe(std::int64_t time_ns, std::span<const float> intensities) noexcept {
  times_ns_[next_] = time_ns;
  std::copy(intensities.begin(), intensities.end(), rows_.row(static_cast<Eigen::Index>(next_)).data());
  next_ = (next_ + 1) % kMoments;
  count_ = std::min(count_ + 1, kMoments);
}

double ContinuationFeatureMaker::age_s(std::size_t back) const noexcept {
  return static_cast<double>(times_ns_[place(0)] - times_ns_[place(back)]) * 1e-9;
}

/// Before the first frame, the face is taken to have been as it is in it.
void ContinuationFeatureMaker::find_lags() noexcept {
  std::size_t back = 0;
  for (std::size_t lag = 0; lag < kContinuationLagsMs.size(); ++lag) {
    const double wanted_s = kContinuationLagsMs[lag] * 1e-3;
    while (back + 1 < count_ && age_s(back) < wanted_s) ++back;
    older_[lag] = newer_[lag] = back;
    share_[lag] = 0;
    if (back == 0 || age_s(back) < wanted_s) continue;
    newer_[lag] = back - 1;
    const double from_s = age_s(back - 1);
    share_[lag] = static_cast<float>((wanted_s - from_s) / (age_s(back) - from_s));
  }
}

float ContinuationFeatureMaker::at_lag(std::size_t lag, Eigen::Index au) const noexcept {
  const float newer = rows_(static_cast<Eigen::Index>(place(newer_[lag])), au),
              older = rows_(static_cast<Eigen::Index>(place(older_[lag])), au);
  return newer + share_[lag] * (older - newer);
}

float ContinuationFeatureMaker::velocity_of(Eigen::Index au) const noexcept {
  double n = 0, t = 0, x = 0, tt = 0, tx = 0;
  for (std::size_t back = 0; back < count_ && (back < 2 || age_s(back) <= kVelocityWindowS); ++back) {
    const double time = -age_s(back), value = rows_(static_cast<Eigen::Index>(place(back)), au);
    n += 1;
    t += time;
    x += value;
    tt += time * time;
    tx += time * value;
  }
  const double spread = n * tt - t * t;
  return spread > 0 ? static_cast<float>((n * tx - t * x) / spread) : 0;
}

/// Root mean square of second differences of the last frames: the noise, where there is any.
float ContinuationFeatureMaker::roughness_of(Eigen::Index au) const noexcept {
  float sum = 0;
  std::size_t terms = 0;
  for (std::size_t back = 1; back + 1 < std::min(count_, kRoughFrames); ++back, ++terms) {
    const float bend = rows_(static_cast<Eigen::Index>(place(back - 1)), au) -
                       2 * rows_(static_cast<Eigen::Index>(place(back)), au) +
                       rows_(static_cast<Eigen::Index>(place(back + 1)), au);
    sum += bend * bend;
  }
  return terms > 0 ? std::sqrt(sum / static_cast<float>(terms)) : 0;
}

void ContinuationFeatureMaker::make(ContinuationFeatures& features) noexcept {
  if (count_ == 0) return;
  find_lags();
  const auto aus = static_cast<Eigen::Index>(size());
  constexpr std::size_t kLags = kContinuationLagsMs.size();
  std::array<float, kAuKinds + 1> of_kind{}, in_kind{};
  float all = 0;
  for (Eigen::Index au = 0; au < aus; ++au) {
    const float x = features.value(au) = rows_(static_cast<Eigen::Index>(place(0)), au);
    auto row = features.inputs.row(au);
    float sum = 0, weight = 0;
    for (std::size_t lag = 0; lag < kLags; ++lag) {
      const float change = row(static_cast<Eigen::Index>(lag)) = at_lag(lag, au) - x;
      const float w = lag < kRecentLags ? 4 : 1;
      sum += w * change * change;
      weight += w;
    }
    const float scale = features.scale(au) = std::sqrt(sum / weight + kLeastScale * kLeastScale);
    features.velocity_per_s(au) = velocity_of(au);
    const auto kind = static_cast<std::size_t>(kinds_[static_cast<std::size_t>(au)]);
    of_kind[kind] += scale;
    in_kind[kind] += 1;
    all += scale;
  }
  const double interval_s = count_ > 1 ? age_s(1) : 1.0 / 60;
  for (Eigen::Index au = 0; au < aus; ++au) {
    auto row = features.inputs.row(au);
    const float scale = features.scale(au), x = features.value(au);
    for (Eigen::Index lag = 0; lag < static_cast<Eigen::Index>(kLags); ++lag) row(lag) = limited(row(lag) / scale);
    const auto other = static_cast<Eigen::Index>(other_[static_cast<std::size_t>(au)]);
    const float other_value = rows_(static_cast<Eigen::Index>(place(0)), other);
    Eigen::Index column = static_cast<Eigen::Index>(kLags);
    for (const std::size_t lag : kOtherLags) row(column++) = limited((at_lag(lag, other) - other_value) / scale);
    const auto kind = static_cast<std::size_t>(kinds_[static_cast<std::size_t>(au)]);
    row(column++) = limited(features.velocity_per_s(au) * 0.05F / scale);
    row(column++) = std::log(scale / 0.05F);
    row(column++) = x;
    row(column++) = limited(static_cast<float>(std::log(std::max(interval_s, 1e-4) * 60)));
    row(column++) = limited(roughness_of(au) / scale);
    row(column++) = std::log(all / static_cast<float>(aus) / 0.05F);
    row(column++) = std::log(of_kind[kind] / in_kind[kind] / 0.05F);
    for (std::size_t i = 0; i < kAuKinds; ++i) row(column++) = i == kind ? 1 : 0;
  }
}

}  // namespace risorius
