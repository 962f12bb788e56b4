#include <utility>

#include "capture/wire/natnet_codec.h"
#include "capture/wire/natnet_reader.h"

namespace risorius {
namespace {

enum class Description : std::int32_t { kMarkerSet, kRigidBody, kSkeleton, kForcePlate, kDevice, kCamera, kAsset };

void read_names(NatnetReader& reader, std::uint32_t count, std::vector<std::string>& names) {
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) names.emplace_back(reader.string());
}

NatnetAsset read_marker_set(NatnetReader& reader) {
  NatnetAsset asset{.kind = NatnetAsset::Kind::kMarkerSet, .name = std::string(reader.string())};
  read_names(reader, reader.count(1), asset.marker_names);
  return asset;
}

NatnetAsset read_rigid_body(NatnetReader& reader, NatnetVersion version) {
  NatnetAsset asset{.kind = NatnetAsset::Kind::kRigidBody, .name = std::string(reader.string())};
  asset.id = reader.read<std::int32_t>();
  reader.take(4 + 12);                                  // parent, offset
  if (version >= NatnetVersion{4, 2}) reader.take(16);  // rotation
  const std::uint32_t markers = reader.count(12 + 4);
  reader.take(markers, 12 + 4);  // positions, then active labels
  if (version >= NatnetVersion{4}) read_names(reader, markers, asset.marker_names);
  return asset;
}

// Its bones are rigid bodies whose markers are the skeleton's.
NatnetAsset read_skeleton(NatnetReader& reader, NatnetVersion version) {
  NatnetAsset asset{.kind = NatnetAsset::Kind::kSkeleton, .name = std::string(reader.string())};
  asset.id = reader.read<std::int32_t>();
  const std::uint32_t bones = reader.count(25);
  for (std::uint32_t i = 0; i < bones && reader.ok(); ++i) read_rigid_body(reader, version);
  return asset;
}

NatnetAsset read_asset(NatnetReader& reader, NatnetVersion version) {
  NatnetAsset asset{.kind = NatnetAsset::Kind::kAsset, .name = std::string(reader.string())};
  reader.read<std::int32_t>();  // type
  asset.id = reader.read<std::int32_t>();
  const std::uint32_t bodies = reader.count(25);
  for (std::uint32_t i = 0; i < bodies && reader.ok(); ++i) read_rigid_body(reader, version);
  const std::uint32_t markers = reader.count(1 + 4 + 12 + 4 + 2);
  for (std::uint32_t i = 0; i < markers && reader.ok(); ++i) {
    asset.marker_names.emplace_back(reader.string());
    asset.marker_ids.push_back(reader.read<std::int32_t>());
    reader.take(12 + 4 + 2);  // position, size, params
  }
  return asset;
}

void skip_channel_names(NatnetReader& reader) {
  reader.take(8);  // type, data type
  const std::uint32_t channels = reader.count(1);
  for (std::uint32_t i = 0; i < channels && reader.ok(); ++i) reader.string();
}

// False: a description that we do not know.
bool read_description(NatnetReader& reader, NatnetVersion version, std::int32_t type, std::vector<NatnetAsset>& model) {
  constexpr std::size_t kForcePlateNumbers = (2 + 3 + 144 + 12) * 4;  // size, origin, calibration, corners
  constexpr std::size_t kCameraNumbers = (3 + 4) * 4;
  switch (static_cast<Description>(type)) {
    case Description::kMarkerSet:
      model.push_back(read_marker_set(reader));
      return true;
    case Description::kRigidBody:
      model.push_back(read_rigid_body(reader, version));
      return true;
    case Description::kSkeleton:
      model.push_back(read_skeleton(reader, version));
      return true;
    case Description::kAsset:
      model.push_back(read_asset(reader, version));
      return true;
    case Description::kForcePlate:
      reader.take(4);
      reader.string();
      reader.take(kForcePlateNumbers);
      skip_channel_names(reader);
      return true;
    case Description::kDevice:
      reader.take(4);
      reader.string();
      reader.string();
      skip_channel_names(reader);
      return true;
    case Description::kCamera:
      reader.string();
      reader.take(kCameraNumbers);
      return true;
  }
  return false;
}

NatnetError decode_in_layout(std::span<const std::byte> payload, NatnetVersion version,
                             std::vector<NatnetAsset>& model) {
  model.clear();
  NatnetReader reader(payload);
  const std::uint32_t descriptions = reader.count(4);
  for (std::uint32_t i = 0; i < descriptions && reader.ok(); ++i) {
    const auto type = reader.read<std::int32_t>();
    if (!version.sized()) {
      // Without sizes nothing after an unknown description can be found.
      if (!read_description(reader, version, type, model)) break;
      continue;
    }
    NatnetReader inside(reader.take(reader.count(1), 1));
    if (!reader.ok()) break;
    const std::size_t before = model.size();
    read_description(inside, version, type, model);
    // Only marker sets must be as we know them; the rest may have changed in a later version, and is passed over.
    if (inside.ok()) continue;
    if (type == static_cast<std::int32_t>(Description::kMarkerSet)) return inside.error();
    model.resize(before);
  }
  return reader.error();
}

}  // namespace

NatnetError decode_model(std::span<const std::byte> payload, NatnetVersion version, std::vector<NatnetAsset>& model) {
  if (version < NatnetVersion{3}) return NatnetError::kOldVersion;
  std::vector<NatnetAsset> read;
  NatnetError error = decode_in_layout(payload, version, read);
  if (error != NatnetError::kNone) {
    const NatnetVersion other = version.sized() ? NatnetVersion{4, 0} : NatnetVersion{4, 1};
    if (decode_in_layout(payload, other, read) == NatnetError::kNone) error = NatnetError::kNone;
  }
  if (error == NatnetError::kNone) model = std::move(read);
  return error;
}

}  // namespace risorius
