// A blind comparison of transitions, ready to be shown: real transitions cut out of recordings, made again by each
// generator from the same past and target, all as intensities of a face's AUs.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "generate/safetensors.h"
#include "generate/transition.h"
#include "replay/corpus/au_recording.h"
#include "solve/faces/face_model.h"

namespace risorius {

struct StudyOptions {
  std::size_t pairs = 40;
  std::uint64_t seed = 1;
  /// False: in every clip the lids (AU43, AU45) move as they were recorded. No generator can know of a blink, and one
  /// blink would tell the real clip.
  bool own_lids = false;
  const Safetensors* seed_weights = nullptr;  ///< of seed 003's generator; null: it takes no part
  std::string seed_weights_place;             ///< for messages
};

/// What one pair shows: two clips of one transition.
struct StudyTrial {
  std::size_t transition = 0, left_kind = 0, right_kind = 0, left_clip = 0, right_clip = 0;
};

struct Study {
  std::uint64_t seed = 0;
  double rate_hz = 0;
  std::vector<std::string> kinds;        ///< "real", then the generators by their names, the default first
  std::vector<std::string> transitions;  ///< "TAKE@SECONDS": where it was cut from
  std::vector<std::string> aus;          ///< of the face, those that move in some clip
  std::vector<StudyTrial> trials;        ///< in the order in which they are shown
  /// In a random order. frames x aus: kTransitionPastFrames of the past, then the course; both of a trial are equally
  /// long.
  std::vector<AuMatrix> clips;
  std::vector<std::string> notes;  ///< for the one who makes the study: what the face does not show, what is masked
};

/// Throws UserError: no transition in a recording's series, too few for so many pairs, weights of another model.
Study make_study(std::span<const AuRecording> recordings, const FaceModel& face, const StudyOptions& options);

/// Rows of the AUs `names` as intensities of the face's AUs, all of them: by name, a side served by the AU without a
/// side and the other way round (columns_for), within [0, the AU's upper bound].
AuMatrix face_intensities(const std::vector<std::string>& names, const AuMatrix& rows, const FaceModel& face);

}  // namespace risorius
