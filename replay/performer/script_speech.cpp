// Speech-like motion of the mouth: phrases of syllables, each a consonant and a vowel with a target of the lips and the
// jaw. Moves from target to target last longer than a sound does, so that neighbours run into each other
// (coarticulation; Lofqvist 1990). Brows beat with stressed syllables. Syllables 3 to 6 a second. And blinks.
#include <algorithm>
#include <array>
#include <cmath>

#include "replay/performer/script_writer.h"

namespace risorius {
namespace {

struct Sound {
  const char* what;
  AuTargets targets;
};

const std::vector<Sound> kVowels{
    {"a", {{"AU27", 0.55}, {"AU16", 0.15}}},
    {"e", {{"AU27", 0.3}, {"AU20", 0.25}, {"AU12", 0.12}}},
    {"i", {{"AU27", 0.12}, {"AU20", 0.4}, {"AU12", 0.15}}},
    {"o", {{"AU27", 0.35}, {"AU18", 0.4}, {"AU22", 0.25}}},
    {"u", {{"AU27", 0.15}, {"AU18", 0.65}}},
    {"schwa", {{"AU27", 0.22}}},
};
const std::vector<Sound> kConsonants{
    {"m b p", {{"AU24", 0.6}, {"AU17", 0.1}}},
    {"f v", {{"AU10", 0.15}, {"AU28", 0.25}, {"AU27", 0.05}}},
    {"s z", {{"AU20", 0.2}, {"AU16", 0.2}, {"AU27", 0.06}}},
    {"sh", {{"AU22", 0.6}, {"AU27", 0.1}}},
    {"t d n l", {{"AU27", 0.18}, {"AU16", 0.1}}},
    {"k g", {{"AU27", 0.24}}},
    {"r w", {{"AU18", 0.35}, {"AU22", 0.2}, {"AU27", 0.12}}},
};
constexpr double kConsonantShare = 0.4;  // of a syllable's time
constexpr double kOverlap = 1.7;         // a move's duration per time between targets
constexpr double kBeatChance = 0.12;     // per syllable

AuTargets scaled(const AuTargets& targets, double gain) {
  AuTargets out = targets;
  for (auto& [au, intensity] : out) intensity *= gain;
  return out;
}

void beat_brows(ScriptWriter& writer, double time_s) {
  Random& random = writer.speech;
  const ScriptWriter::Action beat{time_s, random.uniform(0.12, 0.25), random.uniform(0.05, 0.4),
                                  random.uniform(0.2, 0.5), random.uniform(0.15, 0.6)};
  const bool lowers = random.chance(0.25);
  for (const char* au : {lowers ? "AU4" : "AU1", lowers ? "" : "AU2"}) {
    if (*au != 0 && writer.has(au)) writer.act(ScriptLayer::kSpeech, au, beat);
  }
}

/// From `begin_s` on; when the last sound is over.
double write_phrase(ScriptWriter& writer, double begin_s, double end_s) {
  Random& random = writer.speech;
  const double syllable_s = 1 / random.uniform(3, 6), loudness = random.uniform(0.7, 1.2);
  double time_s = begin_s;
  while (time_s < end_s) {
    const double this_s = syllable_s * random.uniform(0.8, 1.25), stress = random.chance(0.4) ? 1.1 : 0.75;
    const double sink = 1 - 0.25 * (time_s - begin_s) / (end_s - begin_s);  // phrases fade
    const double step_s[] = {kConsonantShare * this_s, (1 - kConsonantShare) * this_s};
    const Sound& consonant = kConsonants[random.index(kConsonants.size())];
    const Sound& vowel = kVowels[random.index(kVowels.size())];
    if (stress > 1 && random.chance(kBeatChance / 0.4)) beat_brows(writer, time_s);
    for (int i = 0; i < 2; ++i) {
      const AuTargets targets = scaled(i == 0 ? consonant.targets : vowel.targets, stress * loudness * sink);
      const double move_s = kOverlap * step_s[i];
      writer.go_to(ScriptLayer::kSpeech, writer.levels_of(targets, 1, random),
                   std::max(0.0, time_s - 0.5 * (move_s - step_s[i])), move_s, 0.02, random);
      time_s += step_s[i];
    }
  }
  const double close_s = random.uniform(0.2, 0.4);
  writer.go_to(ScriptLayer::kSpeech, std::vector<double>(writer.names().size(), 0.0), time_s, close_s, 0.05, random);
  writer.cue(begin_s, begin_s, time_s, "phrase");
  return time_s + 1.35 * close_s + 0.1;
}

}  // namespace

double write_speech(ScriptWriter& writer, double begin_s, double until_s) {
  Random& random = writer.speech;
  constexpr double kLongestEndS = 1.2;  // the last syllable and the lips' closing
  double time_s = begin_s;
  while (true) {
    const double end_s = std::min(time_s + random.uniform(1, 4), until_s - kLongestEndS);
    if (end_s - time_s < 0.5) return std::max(time_s, begin_s);
    time_s = write_phrase(writer, time_s, end_s);
    time_s += std::min(2.0, LogNormal{0.4, 0.6}.draw(random));
  }
}

void write_blinks(ScriptWriter& writer, double until_s, double per_minute) {
  Random& random = writer.blinks;
  if (!writer.has("AU45")) return;
  constexpr double kRefractoryS = 0.6;
  for (double time_s = 0; (time_s += kRefractoryS + random.exponential(60 / per_minute - kRefractoryS)) < until_s;) {
    // The lid falls faster than it rises; 0.2 to 0.4 s in all. Both lids within a few milliseconds.
    const double closing_s = random.uniform(0.07, 0.11), closed_s = random.uniform(0.02, 0.06),
                 opening_s = random.uniform(0.12, 0.23), peak = random.uniform(0.85, 1);
    for (const ScriptWriter::Channel& lid : writer.channels("AU45")) {
      const double begin_s = time_s + 0.008 * random.uniform(), reach = peak * random.uniform(0.97, 1);
      writer.move(ScriptLayer::kBlink, {lid.index, begin_s, closing_s, reach, 1});
      writer.move(ScriptLayer::kBlink, {lid.index, begin_s + closing_s + closed_s, opening_s, -reach, 0.8});
    }
  }
}

}  // namespace risorius
