#include "replay/performer/truth_files.h"

#include "replay/takes/csv_text.h"

namespace risorius {
namespace {

std::filesystem::path beside(std::filesystem::path path, const char* what) {
  return path.replace_extension(std::string(".") + what + ".csv");
}

}  // namespace

CauseWriter::CauseWriter(const std::filesystem::path& path) : file_(path) { file_.write("frame,causes\n"); }

void CauseWriter::write(std::uint64_t frame, std::span<const DefectCause> causes) {
  line_.clear();
  append_number(line_, frame);
  line_ += ',';
  for (const DefectCause cause : causes) line_ += static_cast<char>(cause);
  line_ += '\n';
  file_.write(line_);
}

void CauseWriter::finish() { file_.commit(); }

std::vector<std::filesystem::path> TruthWriter::paths_for(const std::filesystem::path& au_csv) {
  return {au_csv, beside(au_csv, "pose"), beside(au_csv, "markers"), beside(au_csv, "cues")};
}

TruthWriter::TruthWriter(const std::filesystem::path& au_csv, const std::vector<std::string>& au_names)
    : paths_(paths_for(au_csv)), aus_(au_csv, au_names), poses_(paths_[1]), causes_(paths_[2]) {
  poses_.write(
      "frame,translation_x_mm,translation_y_mm,translation_z_mm,rotation_x,rotation_y,rotation_z,rotation_w\n");
}

void TruthWriter::write(const AuFrame& truth, std::span<const DefectCause> causes) {
  aus_.write(truth);
  line_.clear();
  append_number(line_, truth.header.sequence);
  for (const double value : truth.world_from_head.translation_mm) append_number(line_ += ',', value);
  for (const double value : truth.world_from_head.rotation_xyzw) append_number(line_ += ',', value);
  line_ += '\n';
  poses_.write(line_);
  causes_.write(truth.header.sequence, causes);
}

void TruthWriter::finish(const std::vector<ScriptCue>& cues) {
  aus_.finish();
  poses_.commit();
  causes_.finish();
  AtomicFile file(paths_[3]);
  line_ = "begin_s,apex_s,end_s,cue\n";
  for (const ScriptCue& cue : cues) {
    for (const double time_s : {cue.begin_s, cue.apex_s, cue.end_s}) {
      append_number(line_, time_s);
      line_ += ',';
    }
    append_text(line_, cue.what);
    line_ += '\n';
  }
  file.write(line_);
  file.commit();
}

}  // namespace risorius
