#include "generate/seed_generator.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <stdexcept>
#include <variant>

#include "capture/errors.h"
#include "generate/seed_network.h"
#include "generate/transition_features.h"

namespace risorius {
namespace {

constexpr Eigen::Index kReplacedFrames = 5;

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    parts.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

double rate_of(const Safetensors& weights, const std::string& place) {
  const std::string& text = weights.require_metadata(place, "rate_hz");
  const double rate_hz = std::strtod(text.c_str(), nullptr);
  if (!(rate_hz >= 1 && rate_hz <= 1000))
    throw UserError(place, "metadata rate_hz '" + shown(text) + "'", "a rate is 1 to 1000");
  return rate_hz;
}

/// Row of evenly spaced rows at a place between them.
Eigen::RowVectorXf row_at(const AuMatrix& rows, double place) {
  const Eigen::Index last = rows.rows() - 1;
  const double at = std::clamp(place, 0.0, static_cast<double>(last));
  const auto below = static_cast<Eigen::Index>(at);
  const Eigen::Index above = std::min(below + 1, last);
  return rows.row(below) + static_cast<float>(at - static_cast<double>(below)) * (rows.row(above) - rows.row(below));
}

/// Before anything else is read: of another model, all of it may look wrong.
std::string model_of(const Safetensors& weights, const std::string& place) {
  const std::string& name = weights.require_metadata(place, "model");
  if (!name.starts_with("seed")) throw UserError(place, "is a model '" + shown(name) + "'", "give weights of seed");
  return name;
}

}  // namespace

struct SeedGenerator::Network {
  Network(const Safetensors& weights, const std::string& place, const std::vector<std::string>& names, SeedCure which,
          bool as_bf16)
      : model_name(model_of(weights, place)),
        aus(split(weights.require_metadata(place, "channels"))),
        rate_hz(rate_of(weights, place)),
        cure(which),
        width(static_cast<Eigen::Index>(names.size())) {
    if (cure == SeedCure::kReinterpolated) model_name += "_reinterpolated";
    const WeightsReader reader{weights, place};
    const auto count = static_cast<std::int64_t>(aus.size());
    if (as_bf16) {
      step.emplace<SeedNetwork<Bf16>>(reader, count);
    } else {
      step.emplace<SeedNetwork<float>>(reader, count);
    }
    for (const std::string& au : aus) {
      const auto found = std::find(names.begin(), names.end(), au);
      columns.push_back(found == names.end() ? -1 : found - names.begin());
    }
    for (const std::string& name : names) {
      if (std::find(aus.begin(), aus.end(), name) == aus.end()) masked.push_back(name);
    }
  }

  /// Columns of the request for the model's AUs; 0 for those that the request does not have.
  Eigen::VectorXf mapped(const Eigen::RowVectorXf& row) const {
    Eigen::VectorXf values = Eigen::VectorXf::Zero(static_cast<Eigen::Index>(aus.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (columns[k] >= 0) values(static_cast<Eigen::Index>(k)) = row(columns[k]);
    }
    return values;
  }

  /// The model's own frames: row 0 is where it starts, `count` follow.
  AuMatrix run(const TransitionRequest& request, Eigen::Index count) {
    const auto own = static_cast<Eigen::Index>(aus.size());
    AuMatrix past(kSeedPastFrames, own);
    const auto last = static_cast<double>(request.past.rows() - 1);
    for (Eigen::Index row = 0; row < kSeedPastFrames; ++row) {
      const double back = static_cast<double>(kSeedPastFrames - 1 - row) * request.rate_hz / rate_hz;
      past.row(row) = mapped(row_at(request.past, last - back)).transpose();
    }
    AuMatrix frames(count + 1, own);
    frames.row(0) = past.row(kSeedPastFrames - 1);
    std::visit(
        [&](auto& network) {
          if constexpr (!std::is_same_v<std::decay_t<decltype(network)>, std::monostate>) {
            network.start(past, mapped(request.target.transpose()));
            for (Eigen::Index frame = 1; frame <= count; ++frame)
              network.next({frames.row(frame).data(), static_cast<std::size_t>(own)});
          }
        },
        step);
    if (cure == SeedCure::kReinterpolated && count > kReplacedFrames) {
      for (Eigen::Index frame = 1; frame <= kReplacedFrames; ++frame) {
        const float share = static_cast<float>(frame) / static_cast<float>(kReplacedFrames + 1);
        frames.row(frame) = frames.row(0) + share * (frames.row(kReplacedFrames + 1) - frames.row(0));
      }
    }
    return frames;
  }

  std::string model_name;
  std::vector<std::string> aus, masked;
  double rate_hz;
  SeedCure cure;
  Eigen::Index width;
  std::vector<std::ptrdiff_t> columns;  ///< of the requests, per AU of the model; -1: none
  std::variant<std::monostate, SeedNetwork<float>, SeedNetwork<Bf16>> step;
};

SeedGenerator::SeedGenerator(const Safetensors& weights, const std::string& place,
                             const std::vector<std::string>& names, SeedCure cure, bool as_bf16)
    : network_(std::make_unique<Network>(weights, place, names, cure, as_bf16)) {}

SeedGenerator::~SeedGenerator() = default;

std::string_view SeedGenerator::name() const noexcept { return network_->model_name; }
const std::vector<std::string>& SeedGenerator::masked() const noexcept { return network_->masked; }

void SeedGenerator::generate(const TransitionRequest& request, AuMatrix& result) {
  Network& net = *network_;
  if (request.past.rows() < 1 || request.past.cols() != net.width || request.target.size() != net.width ||
      request.frames < 1 || !(request.rate_hz > 0) || !std::isfinite(request.rate_hz))
    throw std::invalid_argument(fmt::format(
        "TransitionRequest: past {} x {}, target {}, {} frames at {} per second; "
        "the requests have {} AUs",
        request.past.rows(), request.past.cols(), request.target.size(), request.frames, request.rate_hz, net.width));
  if (!request.past.allFinite() || !request.target.allFinite())
    throw std::invalid_argument("TransitionRequest: an intensity is not finite");
  const double ratio = net.rate_hz / request.rate_hz;
  const AuMatrix own =
      net.run(request, static_cast<Eigen::Index>(std::ceil(static_cast<double>(request.frames) * ratio)));
  const Eigen::RowVectorXf from = request.past.row(request.past.rows() - 1), to = request.target.transpose();
  result.resize(request.frames, net.width);
  for (Eigen::Index frame = 0; frame < request.frames; ++frame) {
    const auto u = static_cast<float>(static_cast<double>(frame + 1) / static_cast<double>(request.frames));
    result.row(frame) = from + minimum_jerk(u) * (to - from);
    const Eigen::RowVectorXf generated = row_at(own, static_cast<double>(frame + 1) * ratio);
    for (std::size_t k = 0; k < net.columns.size(); ++k) {
      if (net.columns[k] >= 0) result(frame, net.columns[k]) = generated(static_cast<Eigen::Index>(k));
    }
    result.row(frame) = result.row(frame).cwiseMax(0.0F).cwiseMin(kMostTransitionIntensity).eval();
  }
}

}  // namespace risorius
