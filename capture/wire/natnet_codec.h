// OptiTrack's NatNet messages as pure functions between bytes and values, both ways (capture/README.md, "NatNet").
// Decoding is strict about lengths, reads nothing out of bounds, allocates nothing for a frame and no more than the
// message's own bytes for a model definition. From 4.1 on sections carry their size, and what is not known is skipped.
// Frames and the strings in them are views: they live as long as the bytes that they were decoded from.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

inline constexpr std::uint16_t kNatnetCommandPort = 1510;
inline constexpr std::uint16_t kNatnetDataPort = 1511;
inline constexpr std::size_t kMaxNatnetDatagramBytes = 65535;

enum class NatnetMessage : std::uint16_t {
  kConnect = 0,
  kServerInfo = 1,
  kRequest = 2,
  kResponse = 3,
  kRequestModelDef = 4,
  kModelDef = 5,
  kRequestFrameOfData = 6,
  kFrameOfData = 7,
  kMessageString = 8,
  kDisconnect = 9,
  kKeepAlive = 10,
  kDisconnectByTimeout = 11,
  kEchoRequest = 12,
  kEchoResponse = 13,
  kDiscovery = 14,
  kUnrecognizedRequest = 100,
  kUnrecognizedRequest256 = 256,  ///< of some servers
};

/// Why a datagram is of no use. The first group is about its bytes alone, the second about what came before it.
enum class NatnetError : std::uint8_t {
  kNone,
  kTooShort,        ///< no whole header
  kBadLength,       ///< shorter than its header says
  kUnknownMessage,  ///< a message that we do not take
  kTruncated,       ///< a section, string or record runs past the end
  kBadCount,        ///< a negative number of something
  kOldVersion,      ///< before 3.0

  kUnknownSender,   ///< not from the server's address
  kNotConnected,    ///< before the server has said who it is
  kUnknownModel,    ///< a frame before the names of its markers are known
  kModelChanging,   ///< a frame after the server said that its models changed, before it said to what
  kNoMarkers,       ///< a model definition without a marker name that is wanted
  kTooManyMarkers,  ///< more than kMaxMarkers names
  kTooManySets,
  kBadTime,  ///< a frame without any capture time that can be
};
inline constexpr std::size_t kNatnetErrorCount = static_cast<std::size_t>(NatnetError::kBadTime) + 1;
/// In the order of the enumeration: the names of the counters.
std::span<const std::string_view> natnet_error_names() noexcept;

struct NatnetVersion {
  std::uint8_t major = 0, minor = 0, build = 0, revision = 0;
  friend auto operator<=>(const NatnetVersion&, const NatnetVersion&) = default;
  /// Do sections and descriptions carry their size?
  bool sized() const noexcept { return *this >= NatnetVersion{4, 1}; }
};

struct NatnetPacket {
  std::uint16_t id = 0;  ///< NatnetMessage, or a number that we do not know
  std::span<const std::byte> payload;
  NatnetMessage message() const noexcept { return static_cast<NatnetMessage>(id); }
};
NatnetError decode_natnet(std::span<const std::byte> datagram, NatnetPacket& packet) noexcept;

struct NatnetServerInfo {
  std::string name;  ///< of the application, at most 255 bytes
  std::array<std::uint8_t, 4> application_version{};
  NatnetVersion version;              ///< of the frames and model definitions that follow
  std::uint64_t clock_frequency = 0;  ///< ticks per second; 0: not said
  std::uint16_t data_port = 0;        ///< 0: not said
  bool multicast = false;
  std::array<std::uint8_t, 4> group{};
  friend bool operator==(const NatnetServerInfo&, const NatnetServerInfo&) = default;
};
NatnetError decode_server_info(std::span<const std::byte> payload, NatnetServerInfo& info);

/// One entry of a model definition that has a name; those without markers too.
struct NatnetAsset {
  enum class Kind : std::uint8_t { kMarkerSet, kRigidBody, kSkeleton, kAsset };
  Kind kind = Kind::kMarkerSet;
  std::string name;
  std::optional<std::int32_t> id;         ///< marker sets have none
  std::vector<std::string> marker_names;  ///< in the order of their members
  std::vector<std::int32_t> marker_ids;   ///< kAsset: of each marker; else empty
};
/// Force plates, devices, cameras and unknown descriptions are passed over. `payload` of kModelDef.
NatnetError decode_model(std::span<const std::byte> payload, NatnetVersion version, std::vector<NatnetAsset>& model);

struct NatnetLabelledMarker {
  static constexpr std::size_t kBytes = 26;
  enum Params : std::int16_t {
    kOccluded = 1,
    kPointCloudSolved = 2,
    kModelFilled = 4,
    kHasModel = 8,
    kUnlabelled = 16
  };
  std::int32_t id = 0;
  float x = 0, y = 0, z = 0;  ///< metres
  float size = 0;
  std::int16_t params = 0;
  float residual = 0;

  std::uint16_t model() const noexcept { return static_cast<std::uint16_t>(static_cast<std::uint32_t>(id) >> 16); }
  std::uint16_t member() const noexcept { return static_cast<std::uint16_t>(static_cast<std::uint32_t>(id) & 0xFFFF); }
  /// Seen by cameras in this frame: neither occluded nor put there by the model alone.
  bool measured() const noexcept {
    return (params & kOccluded) == 0 && ((params & kModelFilled) == 0 || (params & kPointCloudSolved) != 0);
  }
};

struct NatnetSuffix {
  enum Params : std::int16_t { kRecording = 1, kModelsChanged = 2, kEditMode = 4, kBitstreamChanged = 8 };
  std::uint32_t timecode = 0, timecode_sub = 0;
  double timestamp_s = 0;
  std::uint64_t mid_exposure_ticks = 0, data_received_ticks = 0, transmit_ticks = 0;
  std::int16_t params = 0;
};

struct NatnetFrame {
  std::int32_t frame_number = 0;
  std::uint32_t marker_set_count = 0;
  std::span<const std::byte> marker_sets;  ///< checked; read with take_marker_set
  std::size_t labelled_count = 0, labelled_stride = NatnetLabelledMarker::kBytes;
  std::span<const std::byte> labelled;  ///< checked; read with labelled_marker
  NatnetSuffix suffix;
  bool other_layout = false;  ///< it was not in its version's layout but in that of the other side of 4.1
};
/// A frame that does not fit the layout of `version` exactly, and fits the other one exactly, is read in that:
/// the server's version may change while frames are on their way.
NatnetError decode_frame(std::span<const std::byte> payload, NatnetVersion version, NatnetFrame& frame) noexcept;

struct NatnetMarkerSetView {
  std::string_view name;
  std::span<const std::byte> positions;  ///< 3 f32 each, metres
  std::size_t count() const noexcept { return positions.size() / 12; }
  std::array<float, 3> position(std::size_t i) const noexcept;
};
/// Takes the next one off `marker_sets` of a decoded frame, which must not be empty.
NatnetMarkerSetView take_marker_set(std::span<const std::byte>& marker_sets) noexcept;
NatnetLabelledMarker labelled_marker(const NatnetFrame& frame, std::size_t i) noexcept;

/// Ticks of the two clocks; `host_ticks` in a response only.
struct NatnetEcho {
  std::uint64_t client_ticks = 0, host_ticks = 0;
};
NatnetError decode_echo_request(std::span<const std::byte> payload, NatnetEcho& echo) noexcept;
NatnetError decode_echo_response(std::span<const std::byte> payload, NatnetEcho& echo) noexcept;
/// The text of kRequest or kMessageString, up to its NUL.
std::string_view decode_text(std::span<const std::byte> payload) noexcept;

// Encoding: each replaces `out` by one whole datagram.

using NatnetDatagram = std::vector<std::byte>;

/// Servers differ in which form of CONNECT they answer: who we are, "Ping", or the bare header. Tried in this order:
/// OptiTrack's own library sends the first, and there are servers that the last one ends.
enum class NatnetConnectForm : std::uint8_t { kSender, kPing, kHeader };
inline constexpr std::size_t kNatnetConnectForms = 3;

void encode_connect(NatnetConnectForm form, NatnetDatagram& out);
/// Marker sets and rigid bodies, by name: some servers answer this request only, others only the bare one.
void encode_masked_model_request(NatnetDatagram& out);
/// A message without payload.
void encode_bare(NatnetMessage message, NatnetDatagram& out);
void encode_text(NatnetMessage message, std::string_view text, NatnetDatagram& out);
void encode_response(float value, NatnetDatagram& out);
void encode_response(std::int32_t value, NatnetDatagram& out);
void encode_server_info(const NatnetServerInfo& info, NatnetDatagram& out);
void encode_echo_request(std::uint64_t client_ticks, NatnetDatagram& out);
void encode_echo_response(const NatnetEcho& echo, NatnetDatagram& out);
/// Marker sets; 3.0 to 4.1.
void encode_model(std::span<const NatnetAsset> marker_sets, NatnetVersion version, NatnetDatagram& out);

/// What a server sends of one frame: the positions of one marker set in metres, one labelled marker for each.
struct NatnetFrameToSend {
  std::int32_t frame_number = 0;
  std::string_view marker_set;
  std::span<const NatnetLabelledMarker> markers;  ///< id, position, size, params, residual as they go out
  NatnetSuffix suffix;
};
void encode_frame(const NatnetFrameToSend& frame, NatnetVersion version, NatnetDatagram& out);

}  // namespace risorius
