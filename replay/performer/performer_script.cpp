#include "replay/performer/performer_script.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string_view>
#include <utility>

#include "replay/performer/random.h"

namespace risorius {
namespace {

constexpr double kFirstActionS = 1;  // a take begins with a neutral face
constexpr std::string_view kJawSideways = "AU30";

/// AUs of an expression and how strong each is (prototypes after the FACS investigator's guide).
struct Part {
  std::string_view au;
  double share = 0;
};
struct Expression {
  std::string_view name;
  std::array<Part, 7> parts;
};

constexpr std::array kExpressions = std::to_array<Expression>({
    {"happy", {{{"AU6", 0.8}, {"AU12", 1}}}},
    {"sad", {{{"AU1", 0.9}, {"AU4", 0.6}, {"AU15", 0.8}, {"AU17", 0.4}}}},
    {"surprised", {{{"AU1", 0.9}, {"AU2", 1}, {"AU5", 0.6}, {"AU27", 0.7}}}},
    {"fear", {{{"AU1", 0.9}, {"AU2", 0.6}, {"AU4", 0.6}, {"AU5", 0.8}, {"AU7", 0.6}, {"AU20", 0.8}, {"AU27", 0.4}}}},
    {"anger", {{{"AU4", 1}, {"AU5", 0.4}, {"AU7", 0.8}, {"AU24", 0.7}}}},
    {"disgust", {{{"AU9", 1}, {"AU10", 0.7}, {"AU15", 0.3}, {"AU17", 0.4}}}},
    {"frowning", {{{"AU4", 1}, {"AU17", 0.4}}}},
});

/// Writes pulses for the AUs that the names hold; an AU without a column is left out.
class Writer {
 public:
  Writer(const std::vector<std::string>& names, double seconds, std::uint64_t seed)
      : names_(names),
        seconds_(seconds),
        expressions_(seed, 1),
        speech_(seed, 2),
        blinks_(seed, 3),
        order_(names.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    for (std::size_t i = order_.size(); i > 1; --i) std::swap(order_[i - 1], order_[expressions_.index(i)]);
  }

  std::vector<AuPulse> write() {
    write_expressions();
    write_speech();
    write_blinks();
    std::stable_sort(pulses_.begin(), pulses_.end(),
                     [](const AuPulse& a, const AuPulse& b) { return a.begin_s < b.begin_s; });
    return std::move(pulses_);
  }

 private:
  /// The pulse for "AU12" goes to the columns AU12, AU12L and AU12R; `left_excess` makes the left side stronger.
  void add(std::string_view au, AuPulse pulse, double left_excess = 0) {
    const double peak = pulse.peak;
    for (std::size_t k = 0; k < names_.size(); ++k) {
      const std::string_view name = names_[k];
      if (!name.starts_with(au)) continue;
      const std::string_view side = name.substr(au.size());
      if (!side.empty() && side != "L" && side != "R") continue;
      const double factor = side.empty() ? 1 : side == "L" ? 1 + left_excess : 1 - left_excess;
      pulse.au = static_cast<std::uint32_t>(k);
      pulse.peak = std::clamp(peak * factor, 0.0, 1.0);
      pulses_.push_back(pulse);
    }
  }

  /// Expressions, and now and then a single action, so that every column of the rig moves.
  void write_expressions() {
    Random& r = expressions_;
    for (double time_s = kFirstActionS; time_s < seconds_;) {
      AuPulse pulse{0, time_s, r.uniform(0.25, 0.8), r.uniform(0.4, 2), r.uniform(0.5, 1.4), r.uniform(0.45, 1)};
      const double left_excess = r.uniform(-0.15, 0.15);
      if (r.chance(0.5)) {
        add_single_action(pulse, left_excess);
      } else {
        add_expression(kExpressions[r.index(kExpressions.size())], pulse, left_excess);
      }
      time_s = pulse.end_s() + r.uniform(0.2, 1.5);
    }
  }

  /// One action, mostly with its other side. All columns come in turn, in a drawn order. Jaw left and right are
  /// opposites.
  void add_single_action(const AuPulse& pulse, double left_excess) {
    std::string_view au = names_[order_[next_single_++ % order_.size()]];
    const bool is_one_sided = expressions_.chance(0.3) || au.starts_with(kJawSideways);
    if (!is_one_sided && au.starts_with("AU") && (au.ends_with('L') || au.ends_with('R'))) au.remove_suffix(1);
    add(au, pulse, is_one_sided ? 0 : left_excess);
  }

  void add_expression(const Expression& expression, const AuPulse& whole, double left_excess) {
    for (const Part& part : expression.parts) {
      if (part.share == 0) break;
      AuPulse pulse = whole;
      pulse.begin_s += expressions_.uniform(0, 0.08);  // muscles do not start together
      pulse.peak = std::min(1.0, whole.peak * part.share * expressions_.uniform(0.8, 1.1));
      add(part.au, pulse, left_excess);
    }
  }

  /// Phrases of 1 to 4 s, four to seven syllables per second.
  void write_speech() {
    Random& r = speech_;
    for (double time_s = kFirstActionS; (time_s += r.uniform(1, 5)) < seconds_;) {
      const double phrase_end_s = time_s + r.uniform(1, 4);
      while (time_s < phrase_end_s) {
        const double syllable_s = r.uniform(0.14, 0.26);
        add_syllable(time_s, syllable_s);
        time_s += syllable_s;
      }
    }
  }

  void add_syllable(double begin_s, double length_s) {
    Random& r = speech_;
    const auto pulse = [&](double peak) {
      return AuPulse{0, begin_s, 0.5 * length_s, 0.1 * length_s, 0.7 * length_s, peak};
    };
    add("AU27", pulse(r.uniform(0.08, 0.4)));
    if (r.chance(0.35)) add(r.chance(0.5) ? "AU18" : "AU22", pulse(r.uniform(0.2, 0.6)));
    if (r.chance(0.25)) add("AU16", pulse(r.uniform(0.1, 0.4)), r.uniform(-0.1, 0.1));
    if (r.chance(0.2)) add("AU10", pulse(r.uniform(0.1, 0.3)), r.uniform(-0.1, 0.1));
    if (r.chance(0.2)) add("AU20", pulse(r.uniform(0.1, 0.4)), r.uniform(-0.1, 0.1));
    if (r.chance(0.2)) add("AU24", pulse(r.uniform(0.3, 0.7)));  // m, b, p
  }

  /// About 15 to 20 per minute; the lid falls faster than it rises.
  void write_blinks() {
    Random& r = blinks_;
    for (double time_s = 0; (time_s += 0.6 + r.exponential(3)) < seconds_;) {
      add("AU45", {0, time_s, r.uniform(0.07, 0.1), r.uniform(0.02, 0.06), r.uniform(0.12, 0.22), r.uniform(0.85, 1)});
    }
  }

  const std::vector<std::string>& names_;
  double seconds_;
  Random expressions_, speech_, blinks_;
  std::vector<std::size_t> order_;  ///< of single actions
  std::size_t next_single_ = 0;
  std::vector<AuPulse> pulses_;
};

double minimum_jerk(double u) noexcept {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (u * (6 * u - 15) + 10);
}

}  // namespace

double AuPulse::value_at(double time_s) const noexcept {
  const double since_s = time_s - begin_s;
  if (since_s <= 0 || time_s >= end_s()) return 0;
  if (since_s < onset_s) return peak * minimum_jerk(since_s / onset_s);
  const double falling_s = since_s - onset_s - hold_s;
  return falling_s <= 0 ? peak : peak * (1 - minimum_jerk(falling_s / offset_s));
}

PerformerScript::PerformerScript(const std::vector<std::string>& au_names, double seconds, std::uint64_t seed) {
  if (!au_names.empty()) pulses_ = Writer(au_names, seconds, seed).write();
}

void PerformerScript::intensities_at(double time_s, std::span<double> intensities) noexcept {
  std::fill(intensities.begin(), intensities.end(), 0.0);
  while (first_active_ < pulses_.size() && pulses_[first_active_].end_s() < time_s) ++first_active_;
  for (std::size_t p = first_active_; p < pulses_.size() && pulses_[p].begin_s < time_s; ++p) {
    double& x = intensities[pulses_[p].au];
    x = 1 - (1 - x) * (1 - pulses_[p].value_at(time_s));
  }
}

}  // namespace risorius
