#include "replay/study/study.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <utility>

#include "capture/errors.h"
#include "generate/seed_generator.h"
#include "generate/shipped_models.h"
#include "generate/transition_models.h"
#include "replay/corpus/transition_corpus.h"
#include "replay/performer/random.h"
#include "replay/study/study_pairs.h"
#include "replay/takes/au_column.h"
#include "replay/takes/au_series.h"

namespace risorius {
namespace {

constexpr std::uint64_t kClipStream = 5;    // study_pairs.cpp has the ones before
constexpr float kLeastIntensityF = 0.002F;  // less moves no vertex by a tenth of a millimetre

/// The generators for the AUs of one recording, in the order of the kinds from 1 on.
using Generators = std::vector<std::unique_ptr<TransitionModel>>;

struct Source {
  std::vector<std::string> aus;
  Generators generators;
};

struct Cut {
  std::size_t source = 0;
  Transition transition;
};

/// Once, although several recordings may give cause.
void add_note(std::string note, Study& study) {
  if (std::find(study.notes.begin(), study.notes.end(), note) == study.notes.end())
    study.notes.push_back(std::move(note));
}

Generators generators_for(const std::vector<std::string>& aus, const StudyOptions& options, Study& study) {
  Generators generators;
  generators.push_back(make_transition_model(kTransitionModelNames.front(), aus));
  if (options.seed_weights != nullptr) {
    auto seed = std::make_unique<SeedGenerator>(*options.seed_weights, options.seed_weights_place, aus);
    if (!seed->masked().empty()) {
      add_note(
          fmt::format("{} does not know {}: these follow minimum jerk", seed->name(), fmt::join(seed->masked(), ", ")),
          study);
    }
    generators.push_back(std::move(seed));
  }
  generators.push_back(make_transition_model("minimum_jerk", aus));
  return generators;
}

/// As a whole name: "alex_rom_3.csv" does not name "rom_3.csv".
bool names_file(std::string_view text, std::string_view file) {
  for (std::size_t at = text.find(file); at != std::string_view::npos; at = text.find(file, at + 1)) {
    if (at == 0 || text[at - 1] == ' ' || text[at - 1] == '/') return true;
  }
  return false;
}

/// What a generator has learnt from says nothing of how it does with others.
void note_trained_on(const AuRecording& recording, const StudyOptions& options, Study& study) {
  const auto note = [&](std::string_view generator, const std::string& trained_on) {
    if (!names_file(trained_on, recording.take + ".csv")) return;
    add_note(fmt::format("{}: {} was trained on it, so its clips tell nothing of people whom it has never seen",
                         recording.take, generator),
             study);
  };
  note(kTransitionModelNames.front(), shipped_expression_generator_trained_on());
  if (options.seed_weights == nullptr) return;
  const auto seeds = options.seed_weights->metadata.find("trained_on");
  if (seeds != options.seed_weights->metadata.end()) note("the model of " + options.seed_weights_place, seeds->second);
}

void note_undrawn(const AuRecording& recording, const FaceModel& face, Study& study) {
  std::set<std::size_t> drawn;
  for (const FaceAu& au : face.aus()) {
    for (const std::size_t column : columns_for(recording.series.names, au.name)) drawn.insert(column);
  }
  std::vector<std::string> missing;
  for (std::size_t k = 0; k < recording.series.names.size(); ++k) {
    if (!drawn.contains(k)) missing.push_back(recording.series.names[k]);
  }
  if (!missing.empty())
    add_note(fmt::format("{}: the face does not show {}", recording.take, fmt::join(missing, ", ")), study);
}

bool is_lid(const std::string& au) {
  const int number = parse_au_column(au).number;
  return number == 43 || number == 45;
}

AuMatrix clip_of(const Cut& cut, Source& source, std::size_t kind, const FaceModel& face, bool own_lids) {
  const Transition& t = cut.transition;
  AuMatrix course = t.course;
  if (kind != kStudyReal) {
    source.generators[kind - 1]->generate({.past = t.past,
                                           .target = t.course.row(t.course.rows() - 1).transpose(),
                                           .frames = t.course.rows(),
                                           .rate_hz = kCorpusRateHz},
                                          course);
    for (std::size_t k = 0; k < source.aus.size() && !own_lids; ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      if (is_lid(source.aus[k])) course.col(column) = t.course.col(column);
    }
  }
  AuMatrix whole(t.past.rows() + course.rows(), course.cols());
  whole << t.past, course;
  return face_intensities(source.aus, whole, face);
}

/// Where clip k goes: an order that says nothing of the kinds.
std::vector<std::size_t> random_places(std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> places(count);
  std::iota(places.begin(), places.end(), std::size_t{0});
  Random random(seed, kClipStream);
  for (std::size_t left = count; left > 1; --left) std::swap(places[left - 1], places[random.index(left)]);
  return places;
}

void make_clips(const std::vector<Cut>& cuts, std::vector<Source>& sources, const FaceModel& face, bool own_lids,
                Study& study) {
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> made;  // transition and kind
  std::vector<AuMatrix> clips;
  const auto clip = [&](std::size_t transition, std::size_t kind) {
    const auto [found, is_new] = made.try_emplace({transition, kind}, clips.size());
    const Cut& cut = cuts[transition];
    if (is_new) clips.push_back(clip_of(cut, sources[cut.source], kind, face, own_lids));
    return found->second;
  };
  for (StudyTrial& trial : study.trials) {
    trial.left_clip = clip(trial.transition, trial.left_kind);
    trial.right_clip = clip(trial.transition, trial.right_kind);
  }
  const std::vector<std::size_t> places = random_places(clips.size(), study.seed);
  study.clips.resize(clips.size());
  for (std::size_t k = 0; k < clips.size(); ++k) study.clips[places[k]] = std::move(clips[k]);
  for (StudyTrial& trial : study.trials) {
    trial.left_clip = places[trial.left_clip];
    trial.right_clip = places[trial.right_clip];
  }
}

/// Only AUs that some clip moves.
void keep_moving_aus(const FaceModel& face, Study& study) {
  std::vector<Eigen::Index> kept;
  for (std::size_t k = 0; k < face.aus().size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const bool moves = std::any_of(study.clips.begin(), study.clips.end(), [&](const AuMatrix& clip) {
      return clip.col(column).maxCoeff() >= kLeastIntensityF;
    });
    if (!moves) continue;
    kept.push_back(column);
    study.aus.push_back(face.aus()[k].name);
  }
  for (AuMatrix& clip : study.clips) clip = AuMatrix(clip(Eigen::all, kept));
}

}  // namespace

AuMatrix face_intensities(const std::vector<std::string>& names, const AuMatrix& rows, const FaceModel& face) {
  AuMatrix result = AuMatrix::Zero(rows.rows(), static_cast<Eigen::Index>(face.aus().size()));
  for (std::size_t k = 0; k < face.aus().size(); ++k) {
    const std::vector<std::size_t> columns = columns_for(names, face.aus()[k].name);
    if (columns.empty()) continue;
    auto column = result.col(static_cast<Eigen::Index>(k));
    for (const std::size_t from : columns)
      column += rows.col(static_cast<Eigen::Index>(from)) / static_cast<float>(columns.size());
    column = column.cwiseMax(0.0F).cwiseMin(static_cast<float>(face.aus()[k].upper_bound)).eval();
  }
  return result;
}

Study make_study(std::span<const AuRecording> recordings, const FaceModel& face, const StudyOptions& options) {
  Study study;
  study.seed = options.seed;
  study.rate_hz = kCorpusRateHz;
  std::vector<Source> sources;
  std::vector<Cut> cuts;
  for (const AuRecording& recording : recordings) {
    TransitionCorpus corpus = cut_transitions(motion_of(recording));
    if (corpus.transitions.empty()) {
      throw UserError(recording.take, "there is no transition from one still pose to another in it",
                      "give a series in which the face rests between its expressions, or leave this one out");
    }
    for (Transition& one : corpus.transitions) {
      study.transitions.push_back(fmt::format("{}@{:.2f}", one.take, one.begin_s));
      cuts.push_back({sources.size(), std::move(one)});
    }
    sources.push_back({recording.series.names, generators_for(recording.series.names, options, study)});
    note_undrawn(recording, face, study);
    note_trained_on(recording, options, study);
  }
  if (sources.empty()) throw UserError("study", "no AU series", "give at least one");
  study.kinds = {"real"};
  for (const auto& generator : sources.front().generators) study.kinds.emplace_back(generator->name());
  const std::size_t most = cuts.size() * study_comparisons(study.kinds.size()).size();
  if (options.pairs < 1 || options.pairs > most) {
    throw UserError("--pairs", fmt::format("{} pairs of {} transitions", options.pairs, cuts.size()),
                    fmt::format("1 to {}, or give more series", most));
  }
  for (const StudyPair& pair : draw_study_pairs(cuts.size(), study.kinds.size(), options.pairs, options.seed))
    study.trials.push_back({pair.transition, pair.left, pair.right});
  make_clips(cuts, sources, face, options.own_lids, study);
  keep_moving_aus(face, study);
  return study;
}

}  // namespace risorius
