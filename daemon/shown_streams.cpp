#include "daemon/shown_streams.h"

#include <fmt/format.h>
#include <stdexcept>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "daemon/time_slice.h"
#include "generate/transition_models.h"

namespace risorius {

ShownStreams::ShownStreams(const std::vector<Stream>& streams, const ShownConfig& config) {
  const ShownOptions options{
      .max_rate_hz = config.rate_hz, .bridge_s = config.bridge_s, .fade_s = config.fade_s, .rejoin_s = config.rejoin_s};
  for (const Stream& stream : streams) {
    State& state = states_.emplace_back(stream.upper_bounds, options);
    state.model = make_transition_model(config.model, stream.au_names);
    if (state.model == nullptr)
      throw UserError("[shown] model", "\"" + config.model + "\" is not known", "see risoriusd --print-config");
  }
}

void ShownStreams::count(State& state, const ShownFrame& shown) noexcept {
  state.messages.add();
  if (shown.origin != ShownOrigin::kSolved) state.predicted.add();
}

bool ShownStreams::take(const OutputItem& item, ShownFrame& out) noexcept {
  State& state = states_[item.stream_id];
  const std::scoped_lock lock(state.mutex);
  if (item.kind == OutputItem::Kind::kEndOfStream) state.face.end();
  if (item.kind == OutputItem::Kind::kSolved) {
    const bool is_out = state.face.process(item.solved.aus, out);
    if (!state.face.has_ended()) {  // else the take before goes on fading
      const std::int64_t received_ns = item.solved.aus.header.receive_time_ns;
      state.is_silent = false;
      state.arrived_ns = received_ns > 0 ? received_ns : monotonic_now_ns();
    }
    state.has_ended = state.face.has_ended();
    if (is_out) count(state, out);
    return is_out;
  }
  state.has_ended = state.face.has_ended();
  return false;
}

void ShownStreams::take(const Continuation& continuation) noexcept {
  State& state = states_[continuation.header.stream_id];
  const std::scoped_lock lock(state.mutex);
  state.face.use(continuation);
}

bool ShownStreams::pass(std::uint32_t stream_id, std::int64_t now_ns, ShownFrame& out) noexcept {
  State& state = states_[stream_id];
  if (!state.is_silent && !state.has_ended) return false;
  const std::scoped_lock lock(state.mutex);
  if (!state.face.pass(now_ns - state.arrived_ns, out)) return false;
  count(state, out);
  return true;
}

bool ShownStreams::note_silence(std::uint32_t stream_id, bool is_silent) {
  State& state = states_[stream_id];
  state.is_silent = is_silent;
  if (!is_silent && !state.has_ended) return false;
  const std::scoped_lock lock(state.mutex);
  return state.face.is_showing() || state.face.has_target() || state.is_preparing;
}

double ShownStreams::go_to(std::uint32_t stream_id, const LiveTargetRequest& asked) {
  LiveTarget target = asked.target;
  State& state = states_[stream_id];
  if (state.is_preparing) throw UserError("go_to", "another target is being prepared", "ask again");
  TransitionRequest request;
  std::int64_t began_ns = 0;
  {
    const std::scoped_lock lock(state.mutex);
    if (!state.face.has_face()) throw UserError("go_to", "no face is there to start from", "start the source first");
    if (state.is_silent || state.has_ended) state.face.note_time(monotonic_now_ns() - state.arrived_ns);
    try {
      request = state.face.request_of(target);
    } catch (const std::invalid_argument& error) {
      throw UserError("go_to", error.what(), "");
    }
    began_ns = state.face.now_ns();
  }
  if (asked.is_seconds_auto) {
    request.frames = state.model->expected_frames(request);  // ours: nothing is being prepared
    if (request.frames == 0)
      throw UserError("seconds",
                      fmt::format("\"auto\": the model {} cannot tell how long a face takes", state.model->name()),
                      "give a number, or [shown] model = \"expression_generator\"");
    target.seconds = static_cast<double>(request.frames) / ShownFace::kTransitionRate_hz;
    if (asked.is_return_auto) target.return_s = target.seconds;
  }
  state.is_preparing = true;
  {
    const std::scoped_lock lock(state.mutex);
    state.is_called_off = false;
  }
  state.targets.add();
  state.preparing = std::jthread([&state, request = std::move(request), target, began_ns] {
    ask_for_usual_slices();
    AuMatrix course;
    try {
      state.model->generate(request, course);
    } catch (const std::exception&) {
      course.resize(0, 0);  // nothing to follow; request_of has refused what models may refuse
    }
    {
      const std::scoped_lock lock(state.mutex);
      if (!state.is_called_off) state.face.follow(target, request, std::move(course), began_ns);
      state.is_preparing = false;  // under the lock: a release sees it prepared, called off, or followed
    }
  });
  return target.seconds;
}

void ShownStreams::release(std::uint32_t stream_id) {
  State& state = states_[stream_id];
  const std::scoped_lock lock(state.mutex);
  const bool is_coming = state.is_preparing && !state.is_called_off;
  if (!state.face.has_target() && !is_coming) throw UserError("release", "there is no target", "go_to sets one");
  if (is_coming) state.is_called_off = true;
  if (state.face.has_target()) state.face.release();
}

ShownStreams::Counts ShownStreams::counts(std::uint32_t stream_id) const noexcept {
  const State& state = states_[stream_id];
  return {state.messages.value(), state.predicted.value(), state.targets.value()};
}

}  // namespace risorius
