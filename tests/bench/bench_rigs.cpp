// How good rigs get: bench_rigs [FOLDER of animface]. Real takes: a generic face (the built-in one, and ICT-FaceKit's)
// fitted to the neutral, refined on one half of the time and scored on the other, by the motion of markers that the
// solve is not shown; beside it the ceiling of as many principal components, learned and scored on the same frames.
// Performed takes of people who are not the rig: whether refinement brings the basis nearer to the truth, and the AUs.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "bench/bench_report.h"
#include "bench/component_ceiling.h"
#include "bench/ict_archive.h"
#include "replay/performer/performer.h"
#include "replay/pipeline/neutral.h"
#include "replay/pipeline/take_frames.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/face_identity.h"
#include "solve/faces/ict_face.h"
#include "solve/faces/landmark_map.h"
#include "solve/faces/rig_fit.h"
#include "solve/rigs/left_out_markers.h"
#include "solve/rigs/rig_refine.h"
#include "support/test_data.h"

namespace risorius {
namespace {

const RigRefineOptions kRefine;
/// All solves of real takes that are scored, of fitted and refined rigs alike; performed ones are solved as users do.
const AuSolverOptions kScore = kRefine.solve;

TakeFrames part_of(const TakeFrames& take, double from, double to) {
  const auto at = [&](double share) {
    return take.frames.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(take.frames.size()));
  };
  return {take.place, take.markers, {at(from), at(to)}};
}

/// The largest 98th percentile of intensity among the AUs with one of these numbers.
std::pair<double, std::string> ghost_of(const Rig& rig, const TakeFrames& take,
                                        const std::vector<std::string>& absent) {
  std::vector<std::vector<double>> x(rig.au_count());
  explain_take(rig, take, kScore, [&](const ExplainedFrame& frame) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i].push_back(frame.x[static_cast<Eigen::Index>(i)]);
  });
  std::pair<double, std::string> worst{0, "none"};
  for (std::size_t i = 0; i < x.size(); ++i) {
    std::string name = rig.aus[i].name;
    if (name.back() == 'L' || name.back() == 'R') name.pop_back();
    if (std::ranges::find(absent, name) == absent.end()) continue;
    std::ranges::sort(x[i]);
    const double p98 = x[i][static_cast<std::size_t>(0.98 * static_cast<double>(x[i].size() - 1))];
    if (p98 > worst.first) worst = {p98, rig.aus[i].name};
  }
  return worst;
}

struct RealTake {
  std::string name;
  std::uint64_t last_neutral_frame;
  std::vector<std::string> absent;
};

const RealTake kRealTakes[] = {{"jaw", 90, {"AU1", "AU2", "AU4", "AU5", "AU7", "AU9", "AU45"}},
                               {"eyebrows",
                                120,
                                {"AU10", "AU12", "AU13", "AU14", "AU15", "AU16", "AU17", "AU18", "AU20", "AU22", "AU24",
                                 "AU25", "AU27", "AU28", "AU29", "AU30"}}};

void real_take(const FaceModel& face, const RealTake& real, const std::filesystem::path& folder,
               const std::string& face_words, bench::BenchReport& report) {
  const std::string name = real.name + face_words;
  const auto reader = open_take(folder / (real.name + ".c3d"));
  const Neutral neutral = neutral_of(*reader, 20, real.last_neutral_frame);
  reader->rewind();
  const TakeFrames take = take_frames_of(*reader, name);
  const Rig start = fit_rig(face, neutral.marker_names, neutral.position_mm, find_landmark_map("animface41")).rig;
  const auto draws = bench::hidden_draws(start);
  LeftOutEnergy before, after, ceiling;
  const auto add = [](LeftOutEnergy& sum, const LeftOutEnergy& part) {
    sum.moved_mm2 += part.moved_mm2, sum.left_mm2 += part.left_mm2, sum.samples += part.samples;
  };
  for (const bool is_swapped : {false, true}) {
    const TakeFrames learned = is_swapped ? part_of(take, 0.5, 1) : part_of(take, 0, 0.5);
    const TakeFrames scored = is_swapped ? part_of(take, 0, 0.5) : part_of(take, 0.5, 1);
    const RigRefinement refined = refine_rig(start, {learned}, kRefine);
    const LeftOutEnergy b = left_out_energy(start, scored, draws, kScore),
                        a = left_out_energy(refined.rig, scored, draws, kScore);
    const LeftOutEnergy c = bench::component_ceiling(refined.rig, learned, scored, draws, start.au_count());
    const auto [ghost, ghost_name] = ghost_of(refined.rig, scored, real.absent);
    fmt::print(
        "{} {}: left out {:.3f} -> {:.3f}, ceiling {:.3f}; residual {:.2f} -> {:.2f} mm in {} rounds; ghost {} "
        "{:.2f}\n",
        name, is_swapped ? "2>1" : "1>2", b.explained(), a.explained(), c.explained(), refined.residual_before_mm,
        refined.residual_after_mm, refined.rounds, ghost_name, ghost);
    add(before, b), add(after, a), add(ceiling, c);
  }
  report.add(name + ": left-out energy, fitted", 100 * before.explained());
  report.add(name + ": left-out energy, refined on the other half", 100 * after.explained());
  report.add(name + ": left-out energy, principal components", 100 * ceiling.explained());
  report.add(name + ": refined / principal components", after.explained() / ceiling.explained());
}

/// The truth's column for each of the rig's AUs.
std::vector<std::size_t> columns_in(const Rig& truth, const Rig& rig) {
  std::vector<std::size_t> columns;
  for (const RigAu& au : rig.aus) {
    columns.push_back(
        static_cast<std::size_t>(std::ranges::find(truth.aus, au.name, &RigAu::name) - truth.aus.begin()));
  }
  return columns;
}

/// Share of the truth's energy that a rig's basis is off.
double wrong_share(const Rig& rig, const Rig& truth) {
  const std::vector<std::size_t> columns = columns_in(truth, rig);
  double wrong = 0, all = 0;
  for (std::size_t i = 0; i < rig.au_count(); ++i) {
    const Eigen::Matrix3Xd& field = truth.aus[columns[i]].displacement_mm;
    wrong += (rig.aus[i].displacement_mm - field).squaredNorm();
    all += field.squaredNorm();
  }
  return wrong / all;
}

struct Performed {
  TakeFrames frames;
  std::vector<Eigen::VectorXd> truth;
  Rig actor;
};

Performed perform(std::uint64_t actor_seed, ScriptKind script, double seconds) {
  const PerformerOptions options{.seed = actor_seed,
                                 .rate_hz = 30,
                                 .seconds = seconds,
                                 .noise_mm = 0.2,
                                 .false_track_share = 0,
                                 .script = script,
                                 .perturb = PerturbOptions::like_people()};
  PerformerTake take(builtin_rig(), options);
  Performed performed{{"performed", take.info().markers, {}}, {}, take.performance().true_rig()};
  MarkerFrame frame;
  while (take.next(frame)) {
    performed.frames.frames.push_back(frame);
    const auto& x = take.truth().intensity;
    performed.truth.emplace_back(Eigen::Map<const Eigen::VectorXd>(x.data(), take.truth().count));
  }
  return performed;
}

double au_rmse(const Rig& rig, const Performed& performed) {
  const std::vector<std::size_t> columns = columns_in(performed.actor, rig);
  double squares = 0, count = 0;
  explain_take(rig, performed.frames, {}, [&](const ExplainedFrame& frame) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double off =
          frame.x[static_cast<Eigen::Index>(i)] - performed.truth[frame.index][static_cast<Eigen::Index>(columns[i])];
      squares += off * off;
    }
    count += static_cast<double>(frame.x.size());
  });
  return std::sqrt(squares / count);
}

void performed_people(bench::BenchReport& report) {
  double basis_before = 0, basis_after = 0, rmse_before = 0, rmse_after = 0, rmse_truth = 0;
  const std::vector<std::uint64_t> people{11, 12, 13};
  for (const std::uint64_t person : people) {
    const Performed rom = perform(person, ScriptKind::kRom, 90), test = perform(person, ScriptKind::kExpressions, 45);
    // As a newcomer has it: the neutral is known (the actor was recorded at rest), the face is fitted to it.
    Rig start =
        fit_rig(builtin_face(), rom.actor.marker_names, rom.actor.neutral_mm, find_landmark_map(kBuiltinLayout)).rig;
    std::erase_if(start.aus, [&](const RigAu& au) {
      return std::ranges::find(rom.actor.aus, au.name, &RigAu::name) == rom.actor.aus.end();
    });
    const RigRefinement refined = refine_rig(start, {rom.frames}, kRefine);
    const double b0 = wrong_share(start, rom.actor), b1 = wrong_share(refined.rig, rom.actor);
    const double e0 = au_rmse(start, test), e1 = au_rmse(refined.rig, test), e2 = au_rmse(rom.actor, test);
    fmt::print(
        "person {}: basis off by {:.1f} % -> {:.1f} % of its energy; AU rmse {:.4f} -> {:.4f} (true rig {:.4f}); "
        "residual {:.2f} -> {:.2f} in {} rounds\n",
        person, 100 * b0, 100 * b1, e0, e1, e2, refined.residual_before_mm, refined.residual_after_mm, refined.rounds);
    for (const std::string& warning : refined.warnings) fmt::print("  {}\n", warning);
    basis_before += b0, basis_after += b1;
    rmse_before += e0, rmse_after += e1, rmse_truth += e2;
  }
  const auto count = static_cast<double>(people.size());
  report.add("performed: basis off, generic", 100 * basis_before / count);
  report.add("performed: basis off, refined", 100 * basis_after / count);
  report.add("performed: basis off, refined / generic", basis_after / basis_before);
  report.add("performed: AU rmse, generic", rmse_before / count);
  report.add("performed: AU rmse, refined", rmse_after / count);
  report.add("performed: AU rmse, true rig", rmse_truth / count);
  report.add("performed: AU rmse, refined / generic", rmse_after / rmse_before);
}

/// Rigs fitted to other identities of the built-in face, whose markers sit where they belong: what bending gives.
void other_identities(bench::BenchReport& report) {
  constexpr std::uint64_t kIdentities = 12;
  const FaceModel face = builtin_face();
  double generic = 0, bent = 0;
  for (std::uint64_t identity = 1; identity <= kIdentities; ++identity) {
    const Rig truth = builtin_rig_of(builtin_face(face_identity_of_seed(identity)));
    for (const bool is_bent : {false, true}) {
      RigFitOptions options;
      options.with_identity = is_bent;
      const Rig rig =
          fit_rig(face, truth.marker_names, truth.neutral_mm, find_landmark_map(kBuiltinLayout), options).rig;
      (is_bent ? bent : generic) += wrong_share(rig, truth) / kIdentities;
    }
  }
  report.add("other identities: basis off, unbent", 100 * generic);
  report.add("other identities: basis off, bent / unbent", bent / generic);
}

}  // namespace
}  // namespace risorius

int main(int argc, char** argv) {
  using namespace risorius;
  const std::filesystem::path folder = argc > 1 ? std::filesystem::path(argv[1]) : test::data_folder() / "animface";
  bench::BenchReport report("rigs");
  if (std::filesystem::exists(folder)) {
    for (const RealTake& take : kRealTakes) real_take(builtin_face(), take, folder, "", report);
    const test::TemporaryFolder scratch;
    if (const auto ict = bench::unpack_ict(scratch.path())) {
      const FaceModel face = load_ict_face(*ict);
      for (const RealTake& take : kRealTakes) real_take(face, take, folder, ", ICT face", report);
    }
  }
  performed_people(report);
  other_identities(report);
  return report.finish();
}
