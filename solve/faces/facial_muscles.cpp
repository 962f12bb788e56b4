#include "solve/faces/facial_muscles.h"

#include <array>

namespace risorius {
namespace {

using enum MuscleKind;
constexpr bool kPaired = true, kMiddle = false;

const Muscle kMuscles[] = {
    // Brows and forehead.
    {"frontalis, medial", "AU1", kPaired, kSheet, {12, 98, 94}, {12, 52, 102}, 34, 28, 6.2},
    // It has no bone to hold on to: what lifts the brow draws the hairline down.
    {"frontalis, medial: hairline", "AU1", kPaired, kSheet, {10, 60, 98}, {10, 104, 88}, 30, 30, 1.7, 1.5},
    {"frontalis, lateral", "AU2", kPaired, kSheet, {50, 98, 76}, {47, 53, 88}, 33, 30, 7.2, -0.5},
    {"corrugator supercilii", "AU4", kPaired, kSheet, {6, 40, 98}, {32, 57, 96}, 32, 25, 5.8, 2.0},
    {"depressor supercilii", "AU4", kPaired, kLinear, {9, 36, 94}, {12, 54, 102}, 25, 22, 3.2, 0.8},
    {"procerus", "AU4", kPaired, kLinear, {2, 28, 102}, {3, 48, 102}, 20, 13, 2.0, 0.8},
    // Lids.
    {"levator palpebrae", "AU5", kPaired, kUpperLid, {31, 44, 80}, {31, 36, 90}, 13, 16, 2.9},
    {"orbicularis oculi, orbital: cheek", "AU6", kPaired, kSheet, {40, 34, 88}, {48, 2, 82}, 30, 28, 4.8, 2.6},
    {"orbicularis oculi, orbital: lateral", "AU6", kPaired, kLinear, {40, 30, 84}, {57, 32, 62}, 20, 20, 3.0, 0.4},
    {"orbicularis oculi, orbital: lower lid", "AU6", kPaired, kLowerLid, {31, 36, 88}, {31, 25, 90}, 12, 16, 1.4},
    {"orbicularis oculi, palpebral: lower lid", "AU7", kPaired, kLowerLid, {31, 36, 88}, {31, 25, 90}, 13, 16, 2.6},
    {"orbicularis oculi, palpebral: upper lid", "AU7", kPaired, kUpperLid, {31, 26, 88}, {31, 36, 90}, 12, 16, -1.5},
    {"orbicularis oculi, palpebral: skin below", "AU7", kPaired, kLinear, {26, 30, 88}, {34, 17, 86}, 19, 25, 3.0, 0.6},
    {"orbicularis oculi, palpebral: blink, upper",
     "AU45",
     kPaired,
     kUpperLid,
     {31, 26, 88},
     {31, 36, 90},
     14,
     16,
     -8.44},
    {"orbicularis oculi, palpebral: blink, lower",
     "AU45",
     kPaired,
     kLowerLid,
     {31, 36, 88},
     {31, 25, 90},
     12,
     16,
     1.75},
    // Nose and upper lip.
    {"levator alaeque nasi: wing", "AU9", kPaired, kSheet, {11, 34, 90}, {15, -6, 98}, 27, 21, 6.4, 0.6},
    {"levator alaeque nasi: lip",
     "AU9",
     kPaired,
     kSheet,
     {10, 34, 90},
     {11, -26, 98},
     20,
     25,
     4.9,
     0.4,
     LipShare::kUpper},
    {"levator alaeque nasi: side of the nose", "AU9", kPaired, kLinear, {7, 40, 95}, {10, 19, 97}, 17, 11, 2.6, 1.6},
    {"procerus with it", "AU9", kPaired, kLinear, {4, 26, 100}, {10, 51, 102}, 24, 24, 3.6, 1.0},
    {"levator labii superioris",
     "AU10",
     kPaired,
     kSheet,
     {20, 22, 84},
     {12, -27, 98},
     22,
     26,
     6.4,
     0.6,
     LipShare::kUpper},
    {"levator labii superioris: fold", "AU10", kPaired, kLinear, {26, 22, 82}, {19, -8, 94}, 18, 16, 5.0, 1.6},
    // The corner of the mouth.
    {"zygomaticus major", "AU12", kPaired, kLinear, {60, 18, 46}, {26, -35, 92}, 44, 33, 13.0, 0.3},
    {"zygomaticus major: cheek", "AU12", kPaired, kLinear, {50, 36, 80}, {41, -1, 88}, 30, 27, 3.0, 3.4},
    {"levator anguli oris", "AU13", kPaired, kLinear, {23, 12, 86}, {26, -35, 92}, 32, 24, 8.6, 0.4},
    {"levator anguli oris: cheek", "AU13", kPaired, kLinear, {36, 24, 88}, {34, -12, 88}, 27, 23, 1.0, 4.2},
    {"buccinator", "AU14", kPaired, kLinear, {46, -27, 64}, {26, -35, 92}, 23, 20, 6.8},
    {"buccinator: behind the corner", "AU14", kPaired, kLinear, {26, -34, 76}, {39, -33, 82}, 15, 17, 1.8, 2.4},
    {"depressor anguli oris", "AU15", kPaired, kLinear, {33, -78, 72}, {25, -35.5, 92}, 36, 27, 7.6},
    {"depressor labii inferioris",
     "AU16",
     kPaired,
     kSheet,
     {15, -76, 88},
     {9, -42, 98},
     23,
     22,
     4.2,
     0,
     LipShare::kLower},
    {"mentalis: chin", "AU17", kMiddle, kLinear, {0, -48, 98}, {0, -72, 97}, 32, 36, 9.4, 2.6},
    {"mentalis: lower lip", "AU17", kMiddle, kSheet, {0, -24, 104}, {0, -43, 98}, 21, 27, 5.0, 2.6},
    {"risorius and platysma", "AU20", kPaired, kLinear, {66, -47, 56}, {26, -36, 92}, 46, 30, 10.0},
    {"platysma: beside the chin", "AU20", kPaired, kLinear, {52, -80, 60}, {30, -56, 84}, 24, 20, 3.0},
    // The ring of the mouth.
    {"incisivi labii: pucker", "AU18", kMiddle, kSphincter, {0, -34, 100}, {0, -34, 92}, 48, 31, 9.6, 8.5},
    {"orbicularis oris: funnel", "AU22", kMiddle, kSphincter, {0, -34, 100}, {0, -34, 92}, 44, 34, 5.0, 6.0},
    {"orbicularis oris: funnel, upper lip",
     "AU22",
     kMiddle,
     kSheet,
     {0, 0, 100},
     {0, -28, 100},
     19,
     28,
     5.0,
     1.5,
     LipShare::kUpper},
    {"orbicularis oris: funnel, lower lip",
     "AU22",
     kMiddle,
     kSheet,
     {0, -70, 100},
     {0, -41, 100},
     20,
     28,
     6.6,
     1.0,
     LipShare::kLower},
    {"orbicularis oris: tightened", "AU23", kMiddle, kSphincter, {0, -34, 100}, {0, -34, 92}, 44, 26, 4.2, 1.8},
    {"orbicularis oris: reds narrowed", "AU23", kMiddle, kRollIn, {0, -34, 84}, {0, -34, 92}, 9, 26, 2.6, -1.0},
    {"orbicularis oris: pressed", "AU24", kPaired, kRollIn, {0, -34, 84}, {11, -34, 92}, 12, 24, 2.9, -2.4},
    {"mentalis with it", "AU24", kPaired, kLinear, {6, -46, 100}, {6, -64, 97}, 30, 30, 1.9, 1.0},
    {"relaxed mentalis or orbicularis: upper lip",
     "AU25",
     kMiddle,
     kSheet,
     {0, 0, 100},
     {0, -29, 100},
     12,
     25,
     1.3,
     0.2,
     LipShare::kUpper},
    {"relaxed mentalis or orbicularis: lower lip",
     "AU25",
     kMiddle,
     kSheet,
     {0, -70, 100},
     {0, -40, 100},
     19,
     25,
     3.8,
     0,
     LipShare::kLower},
    {"orbicularis oris: sucked in", "AU28", kMiddle, kRollIn, {0, -34, 80}, {0, -34, 92}, 17, 29, 6.8, -8.0},
    // The jaw.
    {"digastric and lateral pterygoid", "AU27", kMiddle, kJawTurn, {0, 8, 14}, {0, -76, 96}, 27, 25, 37.0, 7.0},
    {"lateral pterygoids, both", "AU29", kMiddle, kJawShift, {0, -78.5, 111}, {0, -76, 96}, 27, 25, 10.0},
    {"lateral pterygoid, right", "AU30L", kMiddle, kJawShift, {12, -77.8, 97}, {0, -76, 96}, 27, 25, 8.5},
    {"lateral pterygoid, left", "AU30R", kMiddle, kJawShift, {-12, -77.8, 97}, {0, -76, 96}, 27, 25, 8.5},
    // Cheeks blown up: buccinator gives way.
    {"buccinator, blown out", "AU34", kPaired, kSheet, {70, -20, 96}, {44, -24, 76}, 38, 38, 12.5, 2.0},
    {"corner of the mouth, pushed by the air", "AU34", kPaired, kLinear, {36, -29, 122}, {29, -33, 92}, 30, 28, 8.0},
};

}  // namespace

std::span<const Muscle> facial_muscles() noexcept { return kMuscles; }

std::vector<AuColumn> facial_au_columns() {
  // By number, as people look for them.
  constexpr std::array<std::string_view, 27> kOrder{
      "AU1",  "AU2",  "AU4",  "AU5",  "AU6",  "AU7",  "AU9",  "AU10", "AU12", "AU13",  "AU14",  "AU15", "AU16", "AU17",
      "AU18", "AU20", "AU22", "AU23", "AU24", "AU25", "AU27", "AU28", "AU29", "AU30L", "AU30R", "AU34", "AU45"};
  std::vector<AuColumn> columns;
  for (const std::string_view au : kOrder) {
    for (const Muscle& muscle : kMuscles) {
      if (muscle.au != au) continue;
      // A closed lid closes no further, and lips between the teeth are as far in as they can be.
      const double bound = au == "AU45" || au == "AU28" ? 1.0 : 1.2;
      if (muscle.is_paired) {
        columns.push_back({std::string(au) + "L", au, 'L', bound});
        columns.push_back({std::string(au) + "R", au, 'R', bound});
      } else {
        columns.push_back({std::string(au), au, 0, bound});
      }
      break;
    }
  }
  return columns;
}

}  // namespace risorius
