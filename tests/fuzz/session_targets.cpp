#include "fuzz/session_targets.h"

#include <algorithm>

#include "capture/errors.h"
#include "fuzz/input_file.h"
#include "replay/mcap/mcap_reader.h"
#include "replay/mcap/mcap_writer.h"
#include "replay/session/tick_codec.h"

namespace risorius::fuzz {
namespace {

Bytes copy_of(const ByteAppender& out) { return {out.bytes().begin(), out.bytes().end()}; }

}  // namespace

void run_mcap(std::span<const std::byte> input) {
  static InputFile file("session.mcap");
  try {
    McapReader reader(file.write(input));
    std::size_t items = 0;
    for (auto item = reader.next(); item != McapReader::Item::kEnd; item = reader.next()) {
      require(++items <= input.size(), "no more records than bytes");
      if (item != McapReader::Item::kMessage) continue;
      require(reader.message().data.size() <= input.size(), "no more data than bytes");
      require(reader.channels().contains(reader.message().channel_id), "a message has its channel");
    }
    require(reader.next() == McapReader::Item::kEnd, "the end is the end");
    require(reader.offset() <= reader.size(), "it reads no further than the file goes");
  } catch (const UserError&) {
  }
}

std::vector<Bytes> mcap_seeds() {
  const InputFile file("seed.mcap");
  std::filesystem::remove(file.path());
  McapWriter writer(file.path());
  writer.write_metadata({"session", {{"format", "risorius-session"}, {"version", "1"}}});
  const std::uint16_t schema = writer.add_schema("view", "jsonschema", "{}");
  const std::uint16_t ticks = writer.add_channel(0, "/face/ticks", "x-risorius-tick", {{"stream", "face"}});
  const std::uint16_t view = writer.add_channel(schema, "/face/view/au", "json");
  const Bytes data = bytes_of("some bytes");
  for (std::uint32_t i = 0; i < 6; ++i) {
    writer.write({i % 2 == 0 ? ticks : view, i, 1000 + i, 1000 + i, data});
    if (i % 3 == 2) writer.end_chunk();
  }
  writer.finish();
  const Bytes whole = file.read();
  return {whole, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() * 2 / 3)}};
}

void run_tick(std::span<const std::byte> input) {
  static SessionTick tick;
  if (!decode_tick(input, tick)) return;
  // Of what is not of the Tick's kind an earlier input may have left anything.
  if (tick.kind == TickKind::kFrame)
    require(tick.frame.count <= kMaxMarkers, "a frame has no more markers than there can be");
  if (tick.kind == TickKind::kMarkerSet)
    require(tick.set.names.size() <= kMaxMarkers, "a set has no more markers than there can be");
  // Written again it means the same. (Not the same bytes: a flag may be any number but 0.)
  ByteAppender once, twice;
  const auto write = [](ByteAppender& out) {
    if (tick.kind == TickKind::kFrame) encode_tick(tick.frame, out);
    if (tick.kind == TickKind::kMarkerSet) encode_tick(tick.set, out);
    return out.size() > 0;
  };
  if (!write(once)) return;
  require(decode_tick(once.bytes(), tick), "what we write we can read");
  write(twice);
  require(std::ranges::equal(once.bytes(), twice.bytes()), "a Tick that was written and read is written as it was");
}

std::vector<Bytes> tick_seeds() {
  std::vector<Bytes> seeds;
  ByteAppender out;
  MarkerFrame frame;
  frame.count = 3;
  frame.state[1] = MarkerState::kMeasured;
  frame.position_mm[1] = {1, 2, 3};
  encode_tick(frame, out);
  seeds.push_back(copy_of(out));
  encode_tick(MarkerSet{.id = 4, .names = {"chin", "nose"}, .rate_hz = 120}, out);
  seeds.push_back(copy_of(out));
  encode_tick(ShapeFrame{}, out);
  seeds.push_back(copy_of(out));
  encode_end_of_stream_tick(out);
  seeds.push_back(copy_of(out));
  encode_neutral_tick(1'000'000'000, out);
  seeds.push_back(copy_of(out));
  encode_recording_tick(true, "take 7", out);
  seeds.push_back(copy_of(out));
  return seeds;
}

}  // namespace risorius::fuzz
