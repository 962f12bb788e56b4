#include "generate/train/transition_data.h"

#include <algorithm>
#include <cmath>

#include "generate/transition_features.h"

namespace risorius {
namespace {

constexpr float kIdle = 0.003F;

/// Linear between frames; `at` counts frames after the start.
float course_at(const Transition& one, Eigen::Index column, double at) {
  const auto below = static_cast<Eigen::Index>(at);
  const auto value = [&](Eigen::Index frame) {
    return frame <= 0 ? one.past(one.past.rows() - 1, column)
                      : one.course(std::min(frame, one.course.rows()) - 1, column);
  };
  const auto share = static_cast<float>(at - static_cast<double>(below));
  return value(below) + share * (value(below + 1) - value(below));
}

torch::Tensor tensor_of(const std::vector<float>& values, std::vector<std::int64_t> shape) {
  return torch::tensor(values, torch::kFloat32).reshape(shape);
}

}  // namespace

TransitionTensors TransitionTensors::of(const torch::Tensor& chosen) const {
  torch::Tensor place = torch::full({transitions}, -1, torch::kInt64);
  place.index_put_({chosen}, torch::arange(chosen.size(0)));
  const torch::Tensor owners = place.index_select(0, owner);
  const torch::Tensor rows = (owners >= 0).nonzero().squeeze(1);
  const auto pick = [&](const torch::Tensor& t) { return t.index_select(0, rows); };
  return {pick(fixed),
          pick(past),
          pick(seconds),
          pick(scale),
          pick(base),
          pick(course),
          pick(weight),
          pick(owners),
          whole.index_select(0, chosen),
          log_seconds.index_select(0, chosen),
          chosen.size(0)};
}

TransitionTensors transition_tensors(const std::vector<std::string>& names,
                                     std::span<const Transition* const> transitions, double rate_hz, int idle_share) {
  const TransitionFeatureMaker maker(names);
  std::vector<float> fixed, past, seconds, scale, base, course, weight, whole, log_seconds;
  int idle = 0;
  std::vector<std::int64_t> owner;
  TransitionFeatures features;
  TransitionRequest request;
  Eigen::RowVectorXf row(static_cast<Eigen::Index>(names.size()));
  for (std::size_t i = 0; i < transitions.size(); ++i) {
    const Transition& one = *transitions[i];
    const Eigen::Index frames = one.course.rows();
    request.past = one.past;
    request.target = one.course.row(frames - 1).transpose();
    request.frames = frames;
    request.rate_hz = rate_hz;
    maker.make(request, features);
    const auto duration = static_cast<float>(static_cast<double>(frames) / rate_hz);
    AuMatrix curve(kCourseSamples, row.size());
    for (Eigen::Index j = 0; j < kCourseSamples; ++j) {
      const float t_s = duration * static_cast<float>(j + 1) / static_cast<float>(kCourseSamples);
      transition_base_at(features.base, t_s, duration, row);
      curve.row(j) = row;
    }
    for (Eigen::Index k = 0; k < row.size(); ++k) {
      const bool is_idle = one.past.col(k).cwiseAbs().maxCoeff() < kIdle && one.course(frames - 1, k) < kIdle;
      if (is_idle && ++idle % idle_share != 0) continue;
      weight.push_back(is_idle ? static_cast<float>(idle_share) : 1.0F);
      fixed.insert(fixed.end(), features.fixed.row(k).begin(), features.fixed.row(k).end());
      past.insert(past.end(), features.past.row(k).begin(), features.past.row(k).end());
      seconds.push_back(duration);
      scale.push_back(features.scale(k));
      for (Eigen::Index j = 0; j < kCourseSamples; ++j) {
        base.push_back(curve(j, k));
        course.push_back(
            course_at(one, k, static_cast<double>((j + 1) * frames) / static_cast<double>(kCourseSamples)));
      }
      owner.push_back(static_cast<std::int64_t>(i));
    }
    whole.insert(whole.end(), features.whole.begin(), features.whole.end());
    log_seconds.push_back(std::log(duration));
  }
  const auto rows = static_cast<std::int64_t>(owner.size()), count = static_cast<std::int64_t>(transitions.size());
  return {tensor_of(fixed, {rows, kTransitionFixedWidth}),
          tensor_of(past, {rows, kTransitionPastSteps, kTransitionPastWidth}),
          tensor_of(seconds, {rows}),
          tensor_of(scale, {rows}),
          tensor_of(base, {rows, kCourseSamples}),
          tensor_of(course, {rows, kCourseSamples}),
          tensor_of(weight, {rows}),
          torch::tensor(owner, torch::kInt64),
          tensor_of(whole, {count, kTransitionWholeWidth}),
          tensor_of(log_seconds, {count}),
          count};
}

torch::Tensor residual_basis() {
  torch::Tensor basis = torch::zeros({kTransitionKnots, kCourseSamples});
  Eigen::VectorXf weights(kTransitionKnots);
  for (Eigen::Index j = 0; j < kCourseSamples; ++j) {
    const float u = static_cast<float>(j + 1) / static_cast<float>(kCourseSamples);
    transition_spline(u, weights);
    for (Eigen::Index k = 0; k < kTransitionKnots; ++k) basis[k][j] = transition_envelope(u) * weights(k);
  }
  return basis;
}

torch::Tensor courses_of(const TransitionTensors& data, const torch::Tensor& coefficients, const torch::Tensor& basis) {
  return data.base + data.scale.unsqueeze(1) * coefficients.matmul(basis);
}

}  // namespace risorius
