// How many false tracks a despiker finds, and how many good samples it condemns.
#pragma once

#include "capture/repair/despiker.h"
#include "support/marker_csv.h"
#include "support/marker_defects.h"

namespace risorius::bench {

struct SpoiltTake {
  MarkerSet set;
  test::Defects defects;
};

/// The test defects of tests/support, by seed.
SpoiltTake spoil_by_test(const test::MarkerTake& clean, std::uint64_t seed);
/// What `risorius defects` makes, with 0.1 mm noise, 3 % occluded, 0.5 % false, two hands before the face a minute.
SpoiltTake spoil_by_program(const test::MarkerTake& clean, std::uint64_t seed);
/// NAME_defects.c3d and NAME_defects.truth.txt beside the clean NAME.csv.
SpoiltTake read_spoilt(const std::filesystem::path& folder, const std::string& name, const test::MarkerTake& clean);

struct DespikeResult {
  test::DespikeScore score;
  double found_percent() const;        ///< of the events displaced by 5 mm or more
  double samples_percent() const;      ///< of their samples
  double false_alarm_percent() const;  ///< of the good samples
};

void add_judged(const SpoiltTake& take, DespikeMethod method, DespikeResult& result);

}  // namespace risorius::bench
