#include "fuzz/fuzz_target.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>

#include "fuzz/file_targets.h"
#include "fuzz/session_targets.h"
#include "fuzz/stream_targets.h"
#include "fuzz/text_targets.h"

namespace risorius::fuzz {
namespace {

// A new decoder or reader gets its line here.
constexpr std::array kTargets{
    Target{"native", run_native, native_seeds},
    Target{"livelink", run_live_link, live_link_seeds},
    Target{"natnet", run_natnet, natnet_seeds},
    Target{"qtm", run_qtm, qtm_seeds},
    Target{"vicon", run_vicon, vicon_seeds},
    Target{"c3d", run_c3d, c3d_seeds},
    Target{"trc", run_trc, trc_seeds},
    Target{"csv", run_csv, csv_seeds},
    Target{"iemocap", run_iemocap, iemocap_seeds},
    Target{"kinect", run_kinect, kinect_seeds},
    Target{"bnd", run_bnd, bnd_seeds},
    Target{"au_csv", run_au_csv, au_csv_seeds},
    Target{"livelink_csv", run_live_link_csv, live_link_csv_seeds},
    Target{"rig", run_rig, rig_seeds},
    Target{"landmarks", run_landmarks, landmark_seeds},
    Target{"config", run_config, config_seeds},
    Target{"control", run_control, control_seeds},
    Target{"mcap", run_mcap, mcap_seeds},
    Target{"safetensors", run_safetensors, safetensors_seeds},
    Target{"tick", run_tick, tick_seeds},
};

}  // namespace

std::span<const Target> targets() { return kTargets; }

const Target* find_target(std::string_view name) {
  const auto found = std::find_if(kTargets.begin(), kTargets.end(), [=](const Target& t) { return t.name == name; });
  return found == kTargets.end() ? nullptr : found;
}

void require(bool holds, const char* law) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: does not hold: %s\n", law);
  std::abort();
}

bool take_record(std::span<const std::byte>& input, Record& record) {
  if (input.size() < 3) return false;
  const auto at = [&](std::size_t i) { return std::to_integer<unsigned>(input[i]); };
  record.control = at(0);
  const std::size_t size = std::min<std::size_t>(at(1) | (at(2) << 8), input.size() - 3);
  record.bytes.assign(input.begin() + 3, input.begin() + 3 + static_cast<std::ptrdiff_t>(size));
  record.bytes.shrink_to_fit();
  input = input.subspan(3 + size);
  return true;
}

void append_record(unsigned control, std::span<const std::byte> bytes, Bytes& input) {
  for (const std::size_t value : {std::size_t{control}, bytes.size() & 0xff, bytes.size() >> 8})
    input.push_back(static_cast<std::byte>(value));
  input.insert(input.end(), bytes.begin(), bytes.end());
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Bytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

}  // namespace risorius::fuzz
