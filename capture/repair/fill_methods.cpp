#include "capture/repair/fill_methods.h"

#include <array>
#include <fmt/format.h>

#include "capture/check.h"
#include "capture/errors.h"
#include "capture/repair/baselines/interpolation.h"
#include "capture/repair/baselines/kalman_fill.h"
#include "capture/repair/baselines/online_pca_fill.h"
#include "capture/repair/baselines/pca_fill.h"
#include "capture/repair/gap_filler.h"
#include "capture/repair/offline_repair.h"

namespace risorius {
namespace {

using Frames = std::vector<MarkerFrame>;

void fill_causally(Frames& frames, const MarkerSet& set, std::int64_t max_gap_ns, FillMethod method) {
  GapFillerOptions options;
  options.method = method;
  options.max_gap_ns = max_gap_ns;
  GapFiller filler(options);
  filler.use_marker_set(set);
  for (MarkerFrame& frame : frames) {
    RISORIUS_CHECK(filler.push(frame));
    filler.pop(frame);
  }
}

constexpr std::array kMethods{
    FillMethodEntry{"offline", false, true, "the default: a regression per gap, on past, future and the other markers",
                    [](Frames& frames, const MarkerSet& set, std::int64_t max_gap_ns) {
                      OfflineFillOptions options;
                      options.max_gap_ns = max_gap_ns;
                      fill_offline(frames, set, options);
                    }},
    FillMethodEntry{"causal", true, true, "the live default",
                    [](Frames& frames, const MarkerSet& set, std::int64_t max_gap_ns) {
                      fill_causally(frames, set, max_gap_ns, FillMethod::kCovariance);
                    }},
    FillMethodEntry{"linear", false, true, "straight in the world (seed 000)",
                    [](Frames& frames, const MarkerSet&, std::int64_t max_gap_ns) { fill_linear(frames, max_gap_ns); }},
    FillMethodEntry{"linear_head", false, true, "straight in the head's frame",
                    [](Frames& frames, const MarkerSet& set, std::int64_t max_gap_ns) {
                      fill_linear_in_head(frames, set, max_gap_ns);
                    }},
    FillMethodEntry{"cubic", false, true, "through two samples on each side",
                    [](Frames& frames, const MarkerSet&, std::int64_t max_gap_ns) { fill_cubic(frames, max_gap_ns); }},
    FillMethodEntry{"kalman", false, false, "low-dimensional Kalman smoother (Burke & Lasenby 2016)",
                    [](Frames& frames, const MarkerSet&, std::int64_t max_gap_ns) { fill_kalman(frames, max_gap_ns); }},
    FillMethodEntry{"pca", false, false, "marker intercorrelations (Gloersen & Federolf 2016)",
                    [](Frames& frames, const MarkerSet&, std::int64_t max_gap_ns) { fill_pca(frames, max_gap_ns); }},
    FillMethodEntry{"hold", true, true, "stays where it was on the head",
                    [](Frames& frames, const MarkerSet& set, std::int64_t max_gap_ns) {
                      fill_causally(frames, set, max_gap_ns, FillMethod::kHold);
                    }},
    FillMethodEntry{"damped_velocity", true, true, "goes on and comes to rest on the head",
                    [](Frames& frames, const MarkerSet& set, std::int64_t max_gap_ns) {
                      fill_causally(frames, set, max_gap_ns, FillMethod::kDampedVelocity);
                    }},
    FillMethodEntry{"online_pca", true, false, "components of the frames so far, in the head's frame",
                    [](Frames& frames, const MarkerSet& set, std::int64_t max_gap_ns) {
                      fill_online_pca(frames, set, max_gap_ns);
                    }},
};

}  // namespace

std::span<const FillMethodEntry> fill_methods() noexcept { return kMethods; }

const FillMethodEntry& fill_method_named(std::string_view name) {
  std::string names;
  for (const FillMethodEntry& method : kMethods) {
    if (method.name == name) return method;
    names += (names.empty() ? "" : ", ") + std::string(method.name);
  }
  throw UserError(std::string(name), "is not a way to fill gaps", "there are: " + names);
}

}  // namespace risorius
