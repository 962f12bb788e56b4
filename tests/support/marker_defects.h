// Seeded defects of a clean take, with their truth: 0.1 mm noise, occlusions (3 %), and false tracks (0.5 % of the
// samples: jumps of 5 to 60 mm, ghosts on one of the six nearest markers, swaps with the next name), 1 to 5 frames
// long.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "support/marker_csv.h"

namespace risorius::test {

enum class Truth : std::uint8_t { kGood, kOccluded, kFalse };

struct Defects {
  std::vector<MarkerFrame> frames;
  std::vector<std::vector<Truth>> truth;  ///< by frame, by marker
  std::vector<std::vector<float>> displaced_mm;
};

class DefectMaker {
 public:
  DefectMaker(const MarkerTake& take, std::uint64_t seed) : clean_(take.frames), random_(seed) {
    defects_.frames = take.frames;
    const std::size_t count = take.set.names.size();
    defects_.truth.assign(clean_.size(), std::vector<Truth>(count, Truth::kGood));
    defects_.displaced_mm.assign(clean_.size(), std::vector<float>(count, 0));
  }
  Defects make() {
    const double samples = static_cast<double>(clean_.size() * clean_.front().count);
    add_noise(0.1F);
    while (share(Truth::kOccluded) < 0.03 * samples) occlude();
    while (share(Truth::kFalse) < 0.005 * samples) add_false_track();
    return defects_;
  }

 private:
  std::size_t below(std::size_t n) { return random_() % n; }
  double share(Truth what) const {
    double n = 0;
    for (const auto& row : defects_.truth) n += static_cast<double>(std::count(row.begin(), row.end(), what));
    return n;
  }
  void add_noise(float sigma_mm) {
    std::normal_distribution<float> noise(0, sigma_mm);
    for (MarkerFrame& frame : defects_.frames) {
      for (std::size_t i = 0; i < frame.count; ++i) {
        Position& p = frame.position_mm[i];
        p = {p.x + noise(random_), p.y + noise(random_), p.z + noise(random_)};
      }
    }
  }
  bool free(std::size_t first, std::size_t length, std::size_t i) const {
    for (std::size_t f = first; f < first + length; ++f) {
      if (defects_.truth[f][i] != Truth::kGood) return false;
    }
    return true;
  }
  void occlude() {
    const auto length = static_cast<std::size_t>(std::exp(std::uniform_real_distribution<>(0, std::log(90))(random_)));
    const std::size_t first = 30 + below(clean_.size() - length - 30), i = below(clean_.front().count);
    if (!free(first, length, i)) return;
    for (std::size_t f = first; f < first + length; ++f) {
      defects_.truth[f][i] = Truth::kOccluded;
      defects_.frames[f].state[i] = MarkerState::kMissing;
    }
  }
  void mark(std::size_t f, std::size_t i, Position p) {
    defects_.truth[f][i] = Truth::kFalse;
    defects_.frames[f].position_mm[i] = p;
    defects_.displaced_mm[f][i] = static_cast<float>(distance_mm(p, clean_[f].position_mm[i]));
  }
  std::size_t near(std::size_t i) {
    std::vector<std::pair<double, std::size_t>> by_distance;
    for (std::size_t j = 0; j < clean_.front().count; ++j) {
      if (j != i) by_distance.emplace_back(distance_mm(clean_[0].position_mm[i], clean_[0].position_mm[j]), j);
    }
    std::sort(by_distance.begin(), by_distance.end());
    return by_distance[below(std::min<std::size_t>(6, by_distance.size()))].second;
  }
  void add_false_track() {
    const std::size_t length = 1 + below(5), first = 30 + below(clean_.size() - length - 30);
    const std::size_t i = below(clean_.front().count), j = near(i), kind = below(3);
    if (!free(first - 1, length + 2 > clean_.size() - first ? length + 1 : length + 2, i) || !free(first, length, j))
      return;
    std::normal_distribution<float> normal(0, 1), ghost(0, 0.3F);
    float x = normal(random_), y = normal(random_), z = normal(random_);
    const float size = std::uniform_real_distribution<float>(5, 60)(random_) / std::hypot(x, y, z);
    for (std::size_t f = first; f < first + length; ++f) {
      const Position own = defects_.frames[f].position_mm[i], other = defects_.frames[f].position_mm[j];
      if (kind == 0) mark(f, i, {own.x + size * x, own.y + size * y, own.z + size * z});
      if (kind == 1) mark(f, i, {other.x + ghost(random_), other.y + ghost(random_), other.z + ghost(random_)});
      if (kind == 2) mark(f, i, other), mark(f, j, own);
    }
  }

  const std::vector<MarkerFrame>& clean_;
  std::mt19937_64 random_;
  Defects defects_;
};

inline Defects make_defects(const MarkerTake& take, std::uint64_t seed) { return DefectMaker(take, seed).make(); }

/// By event: a run of false samples of one marker, displaced by 5 mm or more; found if any of its samples is rejected.
struct DespikeScore {
  std::size_t events = 0, found = 0, false_samples = 0, rejected_false = 0, good_samples = 0, rejected_good = 0;

  void add(const Defects& defects, const std::vector<MarkerFrame>& judged) {
    for (std::size_t i = 0; i < judged.front().count; ++i) {
      bool in_event = false, event_found = false;
      for (std::size_t f = 0; f <= judged.size(); ++f) {
        const bool is_false = f < judged.size() && defects.truth[f][i] == Truth::kFalse;
        const bool rejected = f < judged.size() && judged[f].state[i] == MarkerState::kRejected;
        const bool counts = is_false && defects.displaced_mm[f][i] >= 5;
        if (in_event && !counts) {
          events += 1;
          found += event_found;
          event_found = false;
        }
        in_event = counts;
        event_found = counts && (event_found || rejected);
        false_samples += counts;
        rejected_false += counts && rejected;
        if (f == judged.size() || defects.truth[f][i] != Truth::kGood) continue;
        good_samples += 1;
        rejected_good += rejected;
      }
    }
  }
};

}  // namespace risorius::test
