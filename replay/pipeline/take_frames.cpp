#include "replay/pipeline/take_frames.h"

#include "capture/errors.h"
#include "replay/pipeline/offline_pipeline.h"

namespace risorius {

TakeFrames take_frames_of(TakeReader& take, const std::string& place, std::size_t most) {
  TakeFrames result{place, take.info().markers, read_despiked(take, {})};
  if (result.frames.empty()) throw UserError(place, "has no frames", "give a take of the actor");
  if (result.frames.size() <= most) return result;
  const std::size_t all = result.frames.size();
  for (std::size_t i = 0; i < most; ++i) result.frames[i] = result.frames[i * all / most];
  result.frames.resize(most);
  return result;
}

}  // namespace risorius
