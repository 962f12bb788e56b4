#include "bench/despike_bench.h"

#include <fstream>

#include "capture/repair/position_vector.h"
#include "replay/performer/marker_defects.h"
#include "replay/takes/take.h"

namespace risorius::bench {
namespace {

/// An empty record of what is false, as long as the take.
test::Defects nothing_false(std::vector<MarkerFrame> frames) {
  test::Defects defects;
  const std::size_t count = frames.empty() ? 0 : frames.front().count;
  defects.truth.assign(frames.size(), std::vector<test::Truth>(count, test::Truth::kGood));
  defects.displaced_mm.assign(frames.size(), std::vector<float>(count, 0));
  defects.frames = std::move(frames);
  return defects;
}

void note(test::Defects& defects, const test::MarkerTake& clean, std::size_t f, std::size_t i, test::Truth truth) {
  defects.truth[f][i] = truth;
  if (truth != test::Truth::kFalse) return;
  defects.displaced_mm[f][i] =
      static_cast<float>(test::distance_mm(defects.frames[f].position_mm[i], clean.frames[f].position_mm[i]));
}

}  // namespace

SpoiltTake spoil_by_test(const test::MarkerTake& clean, std::uint64_t seed) {
  return {clean.set, test::make_defects(clean, seed)};
}

SpoiltTake spoil_by_program(const test::MarkerTake& clean, std::uint64_t seed) {
  const std::size_t count = clean.set.names.size();
  Eigen::Matrix3Xd neutral_mm(3, static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    neutral_mm.col(static_cast<Eigen::Index>(i)) = to_vector(clean.frames.front().position_mm[i]);
  }
  MarkerDefects program(neutral_mm, clean.set.rate_hz, {.regions_per_minute = 2}, seed);
  SpoiltTake spoilt{clean.set, nothing_false(clean.frames)};
  for (std::size_t f = 0; f < clean.frames.size(); ++f) {
    MarkerFrame truth = clean.frames[f];
    program.apply(truth, spoilt.defects.frames[f]);
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_false = truth.state[i] == MarkerState::kRejected;
      const bool is_hidden = truth.state[i] == MarkerState::kMissing;
      note(spoilt.defects, clean, f, i,
           is_false ? test::Truth::kFalse : (is_hidden ? test::Truth::kOccluded : test::Truth::kGood));
    }
  }
  return spoilt;
}

SpoiltTake read_spoilt(const std::filesystem::path& folder, const std::string& name, const test::MarkerTake& clean) {
  const auto take = open_take(folder / (name + "_defects.c3d"));
  std::vector<MarkerFrame> frames;
  for (MarkerFrame frame; take->next(frame);) frames.push_back(frame);
  SpoiltTake spoilt{take->info().markers, nothing_false(std::move(frames))};
  // The files' own order of markers differs: by name.
  const std::vector<int> of_clean = index_map(clean.set.names, spoilt.set.names);
  std::ifstream truth(folder / (name + "_defects.truth.txt"));
  std::string line;
  for (std::size_t f = 0; f < spoilt.defects.frames.size() && std::getline(truth, line); ++f) {
    for (std::size_t i = 0; i < spoilt.set.names.size() && i < line.size(); ++i) {
      spoilt.defects.truth[f][i] =
          line[i] == 's' ? test::Truth::kFalse : (line[i] == 'o' ? test::Truth::kOccluded : test::Truth::kGood);
      if (line[i] != 's' || of_clean[i] < 0) continue;
      spoilt.defects.displaced_mm[f][i] = static_cast<float>(test::distance_mm(
          spoilt.defects.frames[f].position_mm[i], clean.frames[f].position_mm[static_cast<std::size_t>(of_clean[i])]));
    }
  }
  return spoilt;
}

double DespikeResult::found_percent() const {
  return 100.0 * static_cast<double>(score.found) / static_cast<double>(score.events);
}
double DespikeResult::samples_percent() const {
  return 100.0 * static_cast<double>(score.rejected_false) / static_cast<double>(score.false_samples);
}
double DespikeResult::false_alarm_percent() const {
  return 100.0 * static_cast<double>(score.rejected_good) / static_cast<double>(score.good_samples);
}

void add_judged(const SpoiltTake& take, DespikeMethod method, DespikeResult& result) {
  DespikerOptions options;
  options.method = method;
  Despiker despiker(options);
  despiker.use_marker_set(take.set);
  std::vector<MarkerFrame> judged = take.defects.frames;
  for (MarkerFrame& frame : judged) {
    despiker.push(frame);
    despiker.pop(frame);
  }
  result.score.add(take.defects, judged);
}

}  // namespace risorius::bench
