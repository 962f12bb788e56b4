// Seed 003's Expression-Generator (its sections 5.2.1 to 5.2.5, equations 5.3 to 5.6) as a recurrent step:
//
//   x_t -> LSTM 256 (encoder) -> [x_E, target] -> LSTM 512 (recurrent generator) -> linear -> x_{t+1}, fed back
//
// The encoder reads the 20 frames of the past from a zero state, and then every generated frame once: the states go on
// over the whole sequence, as seed 003 has them. With its 15 AUs: 1,894,927 weights.
//
// Of the cures that it proposes, two change the network: an initialiser of the hidden states (tensors "initialiser_1",
// "initialiser_2": from the first frame and the target) and a deeper decoder ("decode_1", "decode_2" before "output",
// leaky rectifiers between).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>

#include "generate/transition.h"
#include "generate/weights_reader.h"

namespace risorius {

inline constexpr Eigen::Index kSeedPastFrames = 20;
inline constexpr std::int64_t kSeedEncoderUnits = 256, kSeedGeneratorUnits = 512;
inline constexpr std::int64_t kSeedInitialiserUnits = 128, kSeedDecodeUnits = 256;
inline constexpr float kSeedLeak = 0.01F;  ///< slope of the leaky rectifiers below 0

template <typename Weight>
class SeedNetwork {
 public:
  /// Throws UserError where tensors are missing or have other shapes.
  SeedNetwork(const WeightsReader& reader, std::int64_t aus)
      : encoder_(reader.lstm<Weight>("encoder", kSeedEncoderUnits, aus)),
        generator_(reader.lstm<Weight>("generator", kSeedGeneratorUnits, kSeedEncoderUnits + aus)) {
    std::int64_t width = kSeedGeneratorUnits;
    if (reader.rows("decode_1.weight") > 0) {
      decode_1_ = reader.dense<Weight>("decode_1", kSeedDecodeUnits, width);
      decode_2_ = reader.dense<Weight>("decode_2", kSeedDecodeUnits, kSeedDecodeUnits);
      width = kSeedDecodeUnits;
    }
    output_ = reader.dense<Weight>("output", aus, width);
    constexpr std::int64_t kStates = 2 * (kSeedEncoderUnits + kSeedGeneratorUnits);
    if (reader.rows("initialiser_1.weight") > 0) {
      initialiser_1_ = reader.dense<Weight>("initialiser_1", kSeedInitialiserUnits, 2 * aus);
      initialiser_2_ = reader.dense<Weight>("initialiser_2", kStates, kSeedInitialiserUnits);
    }
    joined_.setZero(kSeedEncoderUnits + aus);
    wide_.setZero(std::max(kSeedDecodeUnits, kSeedInitialiserUnits));
    wider_.setZero(kSeedDecodeUnits);
    states_.setZero(kStates);
    ends_.setZero(2 * aus);
  }

  /// Reads the past, oldest first, its rows as many values as AUs; `target` likewise.
  void start(const AuMatrix& past, const Eigen::VectorXf& target) noexcept {
    encoder_.reset();
    generator_.reset();
    joined_.tail(target.size()) = target;
    if (initialiser_1_) {
      ends_ << past.row(0).transpose(), target;
      const auto wide = span(wide_).first(static_cast<std::size_t>(kSeedInitialiserUnits));
      initialiser_1_->process(span(ends_), wide);
      leak(wide);
      initialiser_2_->process(wide, span(states_));
      const auto states = span(states_);
      constexpr std::size_t e = kSeedEncoderUnits, g = kSeedGeneratorUnits;
      encoder_.set_state(states.first(e), states.subspan(e, e));
      generator_.set_state(states.subspan(2 * e, g), states.subspan(2 * e + g, g));
    }
    for (Eigen::Index row = 0; row < past.rows(); ++row)
      encoder_.process({past.row(row).data(), static_cast<std::size_t>(past.cols())});
  }

  /// The next frame. Allocates nothing.
  void next(std::span<float> frame) noexcept {
    std::copy(encoder_.hidden().begin(), encoder_.hidden().end(), joined_.data());
    generator_.process(span(joined_));
    if (decode_1_) {
      const auto wide = span(wide_).first(static_cast<std::size_t>(kSeedDecodeUnits));
      decode_1_->process(generator_.hidden(), wide);
      leak(wide);
      decode_2_->process(wide, span(wider_));
      leak(span(wider_));
      output_.process(span(wider_), frame);
    } else {
      output_.process(generator_.hidden(), frame);
    }
    encoder_.process(frame);
  }

 private:
  static std::span<float> span(Eigen::VectorXf& x) noexcept { return {x.data(), static_cast<std::size_t>(x.size())}; }
  static void leak(std::span<float> x) noexcept {
    for (float& value : x) value = value > 0 ? value : kSeedLeak * value;
  }

  Lstm<Weight> encoder_, generator_;
  std::optional<Dense<Weight>> decode_1_, decode_2_, initialiser_1_, initialiser_2_;
  Dense<Weight> output_;
  Eigen::VectorXf joined_, wide_, wider_, states_, ends_;
};

}  // namespace risorius
