// Which marker of our set a record of a Vicon frame is: (subject id, marker id) -> index, from the subjects that the
// server describes. Descriptions come with every frame; only changed ones cost anything.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "capture/wire/vicon_codec.h"

namespace risorius {

class ViconNames {
 public:
  /// `subject`: the one to take; "": all, under plain marker names if only one has markers, else "SUBJECT:MARKER".
  explicit ViconNames(std::string subject) : wanted_(std::move(subject)) {}

  enum class Outcome : std::uint8_t { kSame, kChanged, kBad };
  /// The bodies of all SubjectInfo objects of one packet, at least one. kBad: malformed, nothing has changed.
  Outcome describe(std::span<const std::span<const std::byte>> subjects);

  /// Another server may describe others.
  void forget() noexcept;

  const std::vector<std::string>& names() const noexcept { return names_; }
  std::optional<std::size_t> find(std::uint32_t subject, std::uint32_t marker) const noexcept;

 private:
  bool same(std::span<const std::span<const std::byte>> subjects) const noexcept;

  std::string wanted_;
  std::vector<std::vector<std::byte>> described_;
  std::vector<std::string> names_;
  std::unordered_map<std::uint64_t, std::size_t> index_;
};

}  // namespace risorius
