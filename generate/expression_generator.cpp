#include "generate/expression_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "generate/transition_features.h"
#include "generate/weights_reader.h"

namespace risorius {
namespace {

constexpr std::int64_t kNoise = 4;
constexpr std::int64_t kDurationUnits = 16;
constexpr std::int64_t kStepWidth = kTransitionFixedWidth + kTransitionStepWidth + kNoise;
constexpr double kLeastSeconds = 41.0 / 120, kMostSeconds = 402.0 / 120;  ///< seed 003's shortest and longest

/// Standard normal numbers from a counter: SplitMix64 (Steele, Lea & Flood 2014) and Box & Muller (1958).
std::array<float, kNoise> drawn_noise(std::uint64_t repetition) noexcept {
  std::array<float, kNoise> noise{};
  if (repetition == 0) return noise;
  std::uint64_t state = repetition;
  const auto uniform = [&state] {
    std::uint64_t x = state += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<double>((x ^ (x >> 31)) >> 11) + 0.5) * 0x1p-53;
  };
  for (std::size_t i = 0; i < noise.size(); i += 2) {
    const double radius = std::sqrt(-2 * std::log(uniform())), angle = 6.283185307179586 * uniform();
    noise[i] = static_cast<float>(radius * std::cos(angle));
    noise[i + 1] = static_cast<float>(radius * std::sin(angle));
  }
  return noise;
}

/// One of the networks that write a residual.
class Member {
 public:
  Member(const WeightsReader& reader, const std::string& name) {
    const std::int64_t encoder_units = reader.rows(name + "encoder.weight_hh_l0") / 4,
                       units = reader.rows(name + "decoder.weight_hh_l0") / 4;
    if (encoder_units < 1 || units < 1) throw UserError(reader.place, "has no encoder or decoder", "train it again");
    encoder_ = reader.lstm<float>(name + "encoder", encoder_units, kTransitionPastWidth);
    state_ = reader.dense<float>(name + "state", 2 * units, encoder_units + kTransitionFixedWidth);
    decoder_ = reader.lstm<float>(name + "decoder", units, kStepWidth);
    output_ = reader.dense<float>(name + "output", 1, units);
    state_input_.resize(state_.inputs());
    state_output_.setZero(2 * units);
  }

  /// Reads the AU's past.
  void start(const TransitionFeatures& features, Eigen::Index au) noexcept {
    encoder_.reset();
    for (Eigen::Index i = 0; i < kTransitionPastSteps; ++i)
      encoder_.process({features.past.row(au).data() + i * kTransitionPastWidth, kTransitionPastWidth});
    std::copy(encoder_.hidden().begin(), encoder_.hidden().end(), state_input_.begin());
    std::copy_n(features.fixed.row(au).data(), kTransitionFixedWidth,
                state_input_.end() - static_cast<std::ptrdiff_t>(kTransitionFixedWidth));
    state_.process(state_input_, {state_output_.data(), state_.outputs()});
    apply_tanh(state_output_);
    decoder_.reset();
    decoder_.set_state({state_output_.data(), decoder_.units()},
                       {state_output_.data() + decoder_.units(), decoder_.units()});
  }
  /// The next knot's coefficient.
  float next(const Eigen::VectorXf& inputs) noexcept {
    decoder_.process({inputs.data(), static_cast<std::size_t>(kStepWidth)});
    float coefficient = 0;
    output_.process(decoder_.hidden(), {&coefficient, 1});
    return coefficient;
  }

 private:
  Lstm<float> encoder_, decoder_;
  Dense<float> state_, output_;
  std::vector<float> state_input_;
  Eigen::ArrayXf state_output_;
};

}  // namespace

struct ExpressionGenerator::Network {
  Network(const Safetensors& file, const std::string& place, const std::vector<std::string>& names) : maker(names) {
    if (file.require_metadata(place, "model") != "expression_generator")
      throw UserError(place, "is a model '" + shown(file.require_metadata(place, "model")) + "'",
                      "give weights of expression_generator");
    const WeightsReader reader{file, place};
    while (reader.rows(member_name(members.size()) + "decoder.weight_hh_l0") > 0)
      members.emplace_back(reader, member_name(members.size()));
    if (members.empty()) throw UserError(place, "has no decoder", "train it again");
    duration_hidden = reader.dense<float>("duration_hidden", kDurationUnits, kTransitionWholeWidth);
    duration = reader.dense<float>("duration", 1, kDurationUnits);
    step.setZero(kStepWidth);
    coefficients.setZero(static_cast<Eigen::Index>(names.size()), kTransitionKnots);
  }

  /// Coefficients of one AU's residual: the members' mean, or one member's where the repetition is not the expected
  /// one.
  void run(Eigen::Index au, float seconds, std::uint64_t repetition, const std::array<float, kNoise>& noise) {
    step.head(kTransitionFixedWidth) = features.fixed.row(au).transpose();
    for (std::int64_t i = 0; i < kNoise; ++i) step(kTransitionFixedWidth + i) = noise[static_cast<std::size_t>(i)];
    const std::size_t first = repetition % members.size(), count = repetition == 0 ? members.size() : 1;
    coefficients.row(au).setZero();
    for (std::size_t i = first; i < first + count; ++i) {
      members[i].start(features, au);
      for (Eigen::Index knot = 0; knot < kTransitionKnots; ++knot) {
        transition_step_inputs(knot, seconds, step.tail(kTransitionStepWidth));
        coefficients(au, knot) += members[i].next(step) / static_cast<float>(count);
      }
    }
  }

  static std::string member_name(std::size_t member) { return fmt::format("member_{}.", member); }

  TransitionFeatureMaker maker;
  std::vector<Member> members;
  Dense<float> duration_hidden, duration;
  TransitionFeatures features;
  Eigen::VectorXf step;
  AuMatrix coefficients;  ///< A x knots
};

ExpressionGenerator::ExpressionGenerator(const Safetensors& weights, const std::string& place,
                                         const std::vector<std::string>& names)
    : network_(std::make_unique<Network>(weights, place, names)) {}

ExpressionGenerator::~ExpressionGenerator() = default;

void ExpressionGenerator::generate(const TransitionRequest& request, AuMatrix& result) {
  Network& net = *network_;
  net.maker.make(request, net.features);
  const auto seconds = static_cast<float>(static_cast<double>(request.frames) / request.rate_hz);
  const std::array<float, kNoise> noise = drawn_noise(request.repetition);
  const auto aus = static_cast<Eigen::Index>(net.maker.size());
  for (Eigen::Index au = 0; au < aus; ++au) net.run(au, seconds, request.repetition, noise);
  result.resize(request.frames, aus);
  Eigen::VectorXf spline(kTransitionKnots);
  Eigen::RowVectorXf row(aus);
  for (Eigen::Index frame = 0; frame < request.frames; ++frame) {
    const float u = static_cast<float>(frame + 1) / static_cast<float>(request.frames);
    transition_base_at(net.features.base, u * seconds, seconds, row);
    transition_spline(u, spline);
    row += transition_envelope(u) * (net.coefficients * spline).cwiseProduct(net.features.scale).transpose();
    result.row(frame) = row.cwiseMax(0.0F).cwiseMin(kMostTransitionIntensity);
  }
  result.row(request.frames - 1) = request.target.transpose().cwiseMax(0.0F).cwiseMin(kMostTransitionIntensity);
}

Eigen::Index ExpressionGenerator::expected_frames(const TransitionRequest& request) {
  Network& net = *network_;
  TransitionRequest asked = request;
  asked.frames = 1;  // of the features that are read, none depends on it
  net.maker.make(asked, net.features);
  Eigen::ArrayXf hidden(kDurationUnits);
  net.duration_hidden.process({net.features.whole.data(), kTransitionWholeWidth},
                              {hidden.data(), static_cast<std::size_t>(kDurationUnits)});
  apply_tanh(hidden);
  float log_seconds = 0;
  net.duration.process({hidden.data(), static_cast<std::size_t>(kDurationUnits)}, {&log_seconds, 1});
  const double seconds = std::clamp(std::exp(static_cast<double>(log_seconds)), kLeastSeconds, kMostSeconds);
  return std::max<Eigen::Index>(1, std::llround(seconds * request.rate_hz));
}

}  // namespace risorius
