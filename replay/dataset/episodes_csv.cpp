#include <stdexcept>

#include "replay/atomic_file.h"
#include "replay/dataset/episodes.h"
#include "replay/takes/csv_text.h"

namespace risorius {

void save_episodes(const std::filesystem::path& path, const std::vector<std::string>& au_names,
                   std::span<const Episode> episodes) {
  AtomicFile file(path);
  std::string line = "au,side,code,onset_frame,apex_frame,offset_frame,onset_s,apex_s,offset_s,peak,letter,closed_by\n";
  for (const Episode& episode : episodes) {
    if (episode.column >= au_names.size()) throw std::invalid_argument("save_episodes: an episode of no column");
    const std::string& name = au_names[episode.column];
    file.write(line);
    line.clear();
    append_text(line, episode.au_number == 0 ? name : std::to_string(episode.au_number));
    line += ',';
    if (episode.side != ColumnSide::kNone) line += static_cast<char>(episode.side);
    line += ',';
    append_text(line, facs_code(episode, name));
    for (const EpisodePoint& point : {episode.onset, episode.apex, episode.offset}) {
      line += ',';
      append_number(line, point.frame);
    }
    for (const EpisodePoint& point : {episode.onset, episode.apex, episode.offset}) {
      line += ',';
      append_seconds(line, point.time_ns);
    }
    line += ',';
    append_number(line, episode.peak);
    line += std::string(",") + episode.letter + "," + name_of(episode.closed_by) + "\n";
  }
  file.write(line);
  file.commit();
}

}  // namespace risorius
