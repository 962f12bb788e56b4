#include "replay/dataset/episodes.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/check.h"
#include "capture/errors.h"

namespace risorius {
namespace {

constexpr int kJawDrop = 26, kMouthStretch = 27;

void require(bool holds, const char* option, double value, const char* range) {
  if (!holds)
    throw UserError(fmt::format("episodes: {} is {}", option, value), "out of range",
                    fmt::format("allowed: {}", range));
}

void validate_cut_points(const CutPoints& cuts, const EpisodeOptions& options) {
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const double floor = i == 0 ? 0 : cuts[i - 1];
    require(cuts[i] > floor && std::isfinite(cuts[i]), "a cut point", cuts[i], "above 0 and above the one before");
  }
  require(options.hysteresis >= 0 && options.hysteresis < cuts[0], "hysteresis", options.hysteresis,
          "0 to below the cut point of letter A");
  require(options.cap >= cuts.back() && std::isfinite(options.cap), "cap", options.cap,
          "at least the cut point of letter E");
}

void validate(const EpisodeOptions& options) {
  constexpr double kLongest_s = 1e6;
  require(options.scale > 0 && std::isfinite(options.scale), "scale", options.scale, "above 0");
  require(options.minimum_duration_s >= 0 && options.minimum_duration_s <= kLongest_s, "minimum_duration_s",
          options.minimum_duration_s, "0 to 1e6 s");
  require(options.longest_unobserved_s >= 0 && options.longest_unobserved_s <= kLongest_s, "longest_unobserved_s",
          options.longest_unobserved_s, "0 to 1e6 s");
  require(options.jaw_split > 0 && options.jaw_split < 1, "jaw_split", options.jaw_split, "above 0 and below 1");
  validate_cut_points(options.cut_points, options);
  for (const auto& [name, cuts] : options.cut_points_of) validate_cut_points(cuts, options);
}

CutPoints cut_points_for(const AuColumn& column, const EpisodeOptions& options) {
  for (const std::string& key : {column.name, fmt::format("AU{}", column.number)})
    if (const auto own = options.cut_points_of.find(key); own != options.cut_points_of.end()) return own->second;
  return options.cut_points;
}

char letter_of(double scaled_intensity, const CutPoints& cuts) noexcept {
  const auto reached = std::upper_bound(cuts.begin(), cuts.end(), scaled_intensity) - cuts.begin();
  return static_cast<char>('A' + std::max<std::ptrdiff_t>(reached, 1) - 1);
}

std::int64_t nanoseconds(double seconds) noexcept { return std::llround(seconds * 1e9); }

}  // namespace

EpisodeDetector::EpisodeDetector(const std::vector<std::string>& au_names, const EpisodeOptions& options)
    : options_(options),
      minimum_duration_ns_(nanoseconds(options.minimum_duration_s)),
      longest_unobserved_ns_(nanoseconds(options.longest_unobserved_s)) {
  validate(options);
  require(!au_names.empty() && au_names.size() <= kMaxAus, "number of AUs", static_cast<double>(au_names.size()),
          "1 to 64");
  bool has_jaw_drop = false;
  for (const std::string& name : au_names) has_jaw_drop |= parse_au_column(name).number == kJawDrop;
  for (const std::string& name : au_names) {
    const AuColumn column = parse_au_column(name);
    Track& track = tracks_.emplace_back();
    track.au_number = static_cast<std::uint8_t>(column.number);
    track.side = column.side;
    track.cut_points = cut_points_for(column, options);
    // One column of the whole jaw, as rigs have it: AU26 is its lower part, and there the letters begin.
    track.is_jaw = column.number == kMouthStretch && !has_jaw_drop;
    track.scale = track.is_jaw ? options.scale / options.jaw_split : options.scale;
  }
  // One push closes at most one episode per AU, and so does flush: room for a waiting frame, a push, and a flush.
  ring_.resize(3 * tracks_.size());
}

bool EpisodeDetector::push(const AuFrame& frame) noexcept {
  if (waiting_ > tracks_.size()) return false;
  ledger_.received.add();
  if (frame.count != tracks_.size()) {
    ledger_.refused.add();
    return true;
  }
  for (std::size_t column = 0; column < tracks_.size(); ++column) follow(tracks_[column], frame, column);
  ledger_.emitted.add();
  return true;
}

bool EpisodeDetector::pop(Episode& episode) noexcept {
  if (waiting_ == 0) return false;
  episode = ring_[first_];
  first_ = (first_ + 1) % ring_.size();
  --waiting_;
  return true;
}

void EpisodeDetector::flush() noexcept {
  for (std::size_t column = 0; column < tracks_.size(); ++column)
    if (tracks_[column].is_open) close(tracks_[column], column, EpisodeEnd::kEndOfTake);
}

double EpisodeDetector::scaled(const Track& track, double intensity) const noexcept {
  return std::min(options_.cap, intensity * track.scale);
}

void EpisodeDetector::follow(Track& track, const AuFrame& frame, std::size_t column) noexcept {
  const EpisodePoint now{frame.header.sequence, frame.header.capture_time_ns};
  if (track.is_open && difference_ns(now.time_ns, track.last_seen.time_ns) > longest_unobserved_ns_)
    close(track, column, EpisodeEnd::kNotObserved);
  const double intensity = frame.intensity[column];
  const bool is_seen =
      frame.kind != AuFrameKind::kPredicted && frame.state[column] == AuState::kObserved && std::isfinite(intensity);
  if (!is_seen) return;
  if (scaled(track, intensity) < track.cut_points[0] - options_.hysteresis) {
    if (track.is_open) close(track, column, EpisodeEnd::kOffset);
    return;
  }
  if (!track.is_open) {
    track.is_open = true;
    track.onset = track.apex = now;
    track.peak = intensity;
  } else if (intensity > track.peak) {
    track.apex = now;
    track.peak = intensity;
  }
  track.last_seen = now;
}

void EpisodeDetector::close(Track& track, std::size_t column, EpisodeEnd end) noexcept {
  track.is_open = false;
  if (scaled(track, track.peak) < track.cut_points[0]) return;  // never more than noise below letter A
  if (difference_ns(track.last_seen.time_ns, track.onset.time_ns) < minimum_duration_ns_) {
    too_short_.add();
    return;
  }
  RISORIUS_CHECK(waiting_ < ring_.size());
  Episode& episode = ring_[(first_ + waiting_) % ring_.size()];
  ++waiting_;
  episode = {.column = static_cast<std::uint32_t>(column),
             .au_number = track.au_number,
             .side = track.side,
             .onset = track.onset,
             .apex = track.apex,
             .offset = track.last_seen,
             .peak = track.peak,
             .closed_by = end};
  code(track, episode);
}

void EpisodeDetector::code(const Track& track, Episode& episode) const noexcept {
  episode.letter = letter_of(scaled(track, track.peak), track.cut_points);
  if (!track.is_jaw) return;
  episode.au_number = kJawDrop;
  // AU27 counts from the split on; up to its own letter A the jaw is still a full AU26.
  const double stretch =
      std::min(options_.cap, (track.peak - options_.jaw_split) / (1 - options_.jaw_split) * options_.scale);
  if (stretch < track.cut_points[0]) return;
  episode.au_number = kMouthStretch;
  episode.letter = letter_of(stretch, track.cut_points);
}

}  // namespace risorius
