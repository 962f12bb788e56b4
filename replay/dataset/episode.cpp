#include "replay/dataset/episode.h"

namespace risorius {

std::string facs_code(const Episode& episode, const std::string& column_name) {
  if (episode.au_number == 0) return column_name + ":" + episode.letter;
  std::string code = episode.side == ColumnSide::kNone ? "" : std::string(1, static_cast<char>(episode.side));
  return code + std::to_string(episode.au_number) + episode.letter;
}

const char* name_of(EpisodeEnd end) noexcept {
  switch (end) {
    case EpisodeEnd::kOffset:
      return "offset";
    case EpisodeEnd::kNotObserved:
      return "not observed";
    case EpisodeEnd::kEndOfTake:
      return "end of take";
  }
  return "";
}

}  // namespace risorius
