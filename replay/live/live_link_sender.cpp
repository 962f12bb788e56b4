#include "replay/live/live_link_sender.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "capture/errors.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

/// The rate as the packets state it: whole, or NTSC's, or in thousandths.
void state_rate(double rate_hz, LiveLinkPacket& packet) {
  const auto states = [&](double fps, std::int32_t denominator) {
    packet.fps = static_cast<std::int32_t>(std::lround(fps));
    packet.denominator = denominator;
    return std::abs(packet.rate_hz() - rate_hz) < 1e-3;
  };
  if (states(rate_hz, 1) || states(std::round(rate_hz) * 1000, 1001)) return;
  states(rate_hz * 1000, 1000);
}

}  // namespace

LiveLinkTiming::LiveLinkTiming(const std::filesystem::path& path, const LiveLinkTake& take)
    : info_{.path = path,
            .markers = {.names = {}, .rate_hz = take.rate_hz},
            .frame_count = take.shapes.frames.size(),
            .warnings = take.warnings},
      take_(take) {}

bool LiveLinkTiming::next(MarkerFrame& frame) {
  if (next_ == take_.shapes.frames.size()) return false;
  frame = MarkerFrame{};
  frame.header.sequence = take_.shapes.frames[next_++];
  frame.header.capture_time_ns = capture_time_of(frame.header.sequence, take_.rate_hz);
  return true;
}

LiveLinkSender::LiveLinkSender(boost::asio::io_context& io, const LiveLinkTake& take,
                               const LiveLinkSenderOptions& options)
    : take_(take), options_(options), socket_(io) {
  const auto& names = take.shapes.names;
  for (const std::string_view shape : live_link_shape_names()) {
    const auto found = std::ranges::find(names, shape);
    if (found == names.end())
      throw UserError("the recording", fmt::format("has no column for {}", shape), "give a whole recording of the app");
    column_of_shape_.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  error_code error;
  target_ = udp::endpoint(boost::asio::ip::make_address(options_.address, error), options_.port);
  if (error || options_.port == 0) {
    throw UserError(fmt::format("{}:{}", options_.address, options_.port), "is no IP address and port to send to",
                    "such as 127.0.0.1:11111");
  }
  packet_.form = options_.form;
  packet_.device_id = "$00000000-0000-0000-0000-000000000000";
  packet_.name = options_.device;
  state_rate(take.rate_hz, packet_);
}

void LiveLinkSender::start(const MarkerSet&) {
  error_code error;
  socket_.open(target_.protocol(), error);
  if (error) throw UserError(endpoint(), "cannot open a socket: " + error.message(), "is this kind of address set up?");
}

void LiveLinkSender::send_frame(const MarkerFrame& frame, std::int64_t) {
  ++statistics_.frames;
  const auto& frames = take_.shapes.frames;
  const std::uint64_t in_round = frame.header.sequence % (frames.back() + 1);
  const auto found = std::ranges::lower_bound(frames, in_round);
  if (found == frames.end() || *found != in_round) return;
  const auto line = static_cast<std::size_t>(found - frames.begin());
  const auto& row = take_.shapes.intensities[line];
  packet_.has_face = false;
  packet_.value.fill(0);
  for (std::size_t i = 0; i < kFaceShapes; ++i) {
    packet_.value[i] = static_cast<float>(row[column_of_shape_[i]]);
    packet_.has_face = packet_.has_face || !std::isnan(packet_.value[i]);
  }
  std::ranges::copy(take_.angles[line], packet_.value.begin() + kFaceShapes);
  const std::uint64_t day = static_cast<std::uint64_t>(std::llround(86400.0 * std::round(packet_.rate_hz())));
  packet_.frame =
      static_cast<std::int32_t>((static_cast<std::uint64_t>(options_.first_frame) + frame.header.sequence) % day);
  bytes_.clear();
  encode_live_link(packet_, bytes_);
  error_code error;
  socket_.send_to(boost::asio::buffer(bytes_.bytes().data(), bytes_.size()), target_, 0, error);
  ++(error ? statistics_.frames_not_sent : statistics_.frames_sent);
}

void LiveLinkSender::stop() noexcept {
  error_code ignored;
  socket_.close(ignored);
}

std::string LiveLinkSender::endpoint() const {
  const bool ipv6 = target_.address().is_v6();
  return fmt::format("livelink://{}{}{}:{}", ipv6 ? "[" : "", options_.address, ipv6 ? "]" : "", options_.port);
}

}  // namespace risorius
