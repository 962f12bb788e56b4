#include "generate/baselines/kalman_velocity.h"

#include <fmt/format.h>
#include <stdexcept>

namespace risorius {
namespace {

constexpr double kFirstVelocityVariance = 4;  // per s^2: nothing is known of a face that has just come

void require(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(fmt::format("KalmanVelocityOptions.{} {} is not in [{}, {}]", name, value, least, most));
}

}  // namespace

KalmanVelocity::KalmanVelocity(std::vector<double> upper_bound, const KalmanVelocityOptions& options)
    : ContinuationBaseline(std::move(upper_bound)), options_(options), states_(au_count()) {
  require("noise", options.noise, 1e-5, 1);
  require("acceleration_noise", options.acceleration_noise, 1e-4, 1e6);
}

void KalmanVelocity::follow(std::size_t au, double value, double since_s) noexcept {
  State& s = states_[au];
  const double r = options_.noise * options_.noise, dt = since_s;
  if (dt <= 0) {
    s = {value, 0, r, 0, kFirstVelocityVariance};
    return;
  }
  const double q = options_.acceleration_noise;
  s.x += dt * s.v;
  s.xx += dt * (2 * s.xv + dt * s.vv) + q * dt * dt * dt / 3;
  s.xv += dt * s.vv + q * dt * dt / 2;
  s.vv += q * dt;
  const double gain_x = s.xx / (s.xx + r), gain_v = s.xv / (s.xx + r), surprise = value - s.x;
  s.x += gain_x * surprise;
  s.v += gain_v * surprise;
  s.vv -= gain_v * s.xv;
  s.xv *= 1 - gain_x;
  s.xx *= 1 - gain_x;
}

double KalmanVelocity::predicted(std::size_t au, double ahead_s) const noexcept {
  return states_[au].x + ahead_s * states_[au].v;
}

}  // namespace risorius
