#include "fuzz/file_targets.h"

#include <filesystem>
#include <fmt/format.h>

#include "capture/errors.h"
#include "fuzz/input_file.h"
#include "generate/safetensors.h"
#include "replay/takes/au_csv.h"
#include "replay/takes/bnd_reader.h"
#include "replay/takes/c3d_reader.h"
#include "replay/takes/c3d_writer.h"
#include "replay/takes/csv_take.h"
#include "replay/takes/iemocap_reader.h"
#include "replay/takes/kinect_text_reader.h"
#include "replay/takes/live_link_csv.h"
#include "replay/takes/trc_reader.h"

namespace risorius::fuzz {
namespace {

/// More than this of a take says nothing new.
constexpr std::size_t kMostFrames = 200;

template <class Reader>
void read_take(const std::filesystem::path& path) {
  try {
    Reader reader(path, TakeOptions{});
    const TakeInfo& info = reader.info();
    require(info.markers.names.size() <= kMaxMarkers, "a take has no more markers than there can be");
    MarkerFrame frame;
    std::size_t frames = 0;
    std::uint64_t sequence = 0;
    while (frames < kMostFrames && reader.next(frame)) {
      require(frame.count == info.markers.names.size(), "a frame fits its set");
      require(frames == 0 || frame.header.sequence > sequence, "sequences rise");
      sequence = frame.header.sequence;
      ++frames;
    }
    reader.rewind();
    require(frames == 0 || reader.next(frame), "what was read once can be read again");
  } catch (const UserError&) {
  }
}

}  // namespace

void run_c3d(std::span<const std::byte> input) {
  static InputFile file("take.c3d");
  read_take<C3dReader>(file.write(input));
}

std::vector<Bytes> c3d_seeds() {
  const InputFile file("seed.c3d");
  C3dWriter writer(file.path(), {.id = 1, .names = {"chin", "nose"}, .rate_hz = 120}, "fuzz");
  for (std::uint64_t s = 0; s < 4; ++s) {
    MarkerFrame frame;
    frame.header.sequence = s;
    frame.count = 2;
    frame.state[0] = MarkerState::kMeasured;
    frame.position_mm[0] = {1, 2, static_cast<float>(s)};
    writer.write(frame);
  }
  writer.finish();
  return {file.read()};
}

void run_trc(std::span<const std::byte> input) {
  static InputFile file("take.trc");
  read_take<TrcReader>(file.write(input));
}

std::vector<Bytes> trc_seeds() {
  return {
      bytes_of("PathFileType\t4\t(X/Y/Z)\tface.trc\r\n"
               "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\r\n"
               "100.00\t100.00\t3\t2\tcm\t100.00\t1\t3\r\n"
               "Frame#\tTime\tChin\t\t\tBrow L\t\t\r\n"
               "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\r\n\r\n"
               "1\t0.000\t1.5\t2\t-3e-1\t4\t5\t6\t\r\n2\t0.010\t\t\t\t4\t5\t6\r\n4\t0.030\t1\t2\t3\t\t\t\r\n")};
}

void run_csv(std::span<const std::byte> input) {
  static InputFile file("take.csv");
  read_take<CsvTakeReader>(file.write(input));
}

std::vector<Bytes> csv_seeds() {
  return {bytes_of("frame,time_s,chin_x,chin_y,chin_z,nose_x,nose_y,nose_z\n0,0,1,2,3,4,5,6\n1,0.01,,,,4.5,5,6\n"
                   "2,0.02,1,2,3e0,4,5,6\n4,0.04,1,2,3,4,5,6\n"),
          bytes_of("time_s;chin_x;chin_y;chin_z\n0;1;2;3\n0.011;1;2;3\n0.019;1;2;3\n")};
}

void run_iemocap(std::span<const std::byte> input) {
  static InputFile file("take.txt");
  read_take<IemocapReader>(file.write(input));
}

std::vector<Bytes> iemocap_seeds() {
  return {
      bytes_of("CH1 TNOSE LH1 Mou3\nFrame# Time x y z x y z x y z x y z\n1 0.00000 1.5 2 3 4 5 6 0.1 0.2 0.3 7 8 9\n"
               "2 0.00833 NaN NaN NaN 4 5 6 0.1 0.2 0.3 7 8 9\r\n3 0.01667 1 2 3 4 5 6 nan nan nan 7 8 9\n")};
}

void run_kinect(std::span<const std::byte> input) {
  static InputFile file("datapoints.txt");
  read_take<KinectTextReader>(file.write(input));
}

std::vector<Bytes> kinect_seeds() {
  return {
      bytes_of("0.0 0x 0y 0z 1x 1y 1z\n1390385453.938 310.5 240 1050 215 345 1050\n1390385454.0 1 2 0 1 2 3\n"
               "1390385454.62 1 1 900 1 1 900\r\n1390385454.125 1e2 1 900 -1 +1 900\n")};
}

void run_bnd(std::span<const std::byte> input) {
  static InputFile file("001.bnd");
  read_take<BndReader>(file.write(input));
}

std::vector<Bytes> bnd_seeds() {
  std::string text;
  for (int i = 1; i <= 83; ++i) text += fmt::format("{}\t{}.5\t{}\t{}\r\n", i, i, i, -i);
  return {bytes_of(text), bytes_of("1 2 3 4\n2 NaN 4 5\n")};
}

void run_au_csv(std::span<const std::byte> input) {
  static InputFile file("au.csv");
  try {
    const AuSeries series = load_au_csv(file.write(input));
    require(series.names.size() <= input.size(), "no more AUs than bytes");
  } catch (const UserError&) {
  }
}

std::vector<Bytes> au_csv_seeds() { return {bytes_of("Frame,AU1L,AU1R,AU27\n0,0.1,0.5,1.2\n1,,,1\n3,0,1,0.25\n")}; }

void run_live_link_csv(std::span<const std::byte> input) {
  static InputFile file("face.csv");
  const auto& path = file.write(input);
  try {
    is_live_link_csv(path);
    load_live_link_csv(path);
  } catch (const UserError&) {
  }
  try {
    load_live_link_csv(path, 60.0);
  } catch (const UserError&) {
  }
}

std::vector<Bytes> live_link_csv_seeds() {
  return {
      bytes_of("Timecode,BlendShapeCount,EyeBlinkLeft,JawOpen,MouthSmileLeft,HeadYaw,HeadPitch,HeadRoll\n"
               "10:00:00:00.000,61,0.1,0.2,0.3,0.1,0.1,0.1\n10:00:00:01.000,61,,,,,,\n"
               "10:00:00:02.500,61,0.1,1.003,0.3,0.1,0.1,0.1\n10:00:01:00.000,61,0.1,0.2,0.3,0.1,0.1,0.1\n")};
}

void run_safetensors(std::span<const std::byte> input) {
  try {
    const Safetensors file = parse_safetensors(input, "input");
    for (const auto& [name, tensor] : file.tensors)
      require(tensor.values().size() == tensor.size(), "a tensor has as many values as its shape says");
    const std::string bytes = safetensors_bytes(file);
    const Safetensors again = parse_safetensors(std::as_bytes(std::span(bytes)), "again");
    require(safetensors_bytes(again) == bytes, "written and read, it is the same");
  } catch (const UserError&) {
  }
}

std::vector<Bytes> safetensors_seeds() {
  Safetensors file;
  file.metadata = {{"model", "seed"}, {"rate_hz", "120"}};
  const std::vector<float> values{1, -2, 3, 0.5F};
  file.tensors["output.weight"] = make_tensor(values, {2, 2}, TensorType::kBf16);
  file.tensors["output.bias"] = make_tensor(values, {4}, TensorType::kF32);
  return {bytes_of(safetensors_bytes(file)), bytes_of(safetensors_bytes({}))};
}

}  // namespace risorius::fuzz
