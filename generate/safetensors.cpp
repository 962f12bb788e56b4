#include "generate/safetensors.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "capture/errors.h"

namespace risorius {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "tensors are copied as they are");

constexpr std::size_t kLengthBytes = 8;
constexpr std::uint64_t kMostHeaderBytes = 1'000'000;
constexpr std::uint64_t kMostValues = 1'000'000'000;
constexpr std::size_t kMostDimensions = 8;
constexpr const char* kMetadataKey = "__metadata__";
constexpr const char* kRemedy = "is the file complete, and written by risorius-train?";

std::size_t bytes_of(TensorType type) noexcept { return type == TensorType::kF32 ? 4 : 2; }
const char* name_of(TensorType type) noexcept { return type == TensorType::kF32 ? "F32" : "BF16"; }

/// The product, or nothing where it grows beyond any model.
std::optional<std::uint64_t> count_of(const std::vector<std::int64_t>& shape) noexcept {
  std::uint64_t count = 1;
  for (const std::int64_t size : shape) {
    if (size < 0 || static_cast<std::uint64_t>(size) > kMostValues) return std::nullopt;
    count *= static_cast<std::uint64_t>(size);
    if (count > kMostValues) return std::nullopt;
  }
  return count;
}

/// An unsigned number of the JSON, without exceptions.
std::optional<std::uint64_t> unsigned_of(const json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  return value.get<std::uint64_t>();
}

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, const std::string& place) : bytes_(bytes), place_(place) {}

  Safetensors read() {
    const json header = read_header();
    Safetensors file;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
    for (const auto& [name, entry] : header.items()) {
      if (name == kMetadataKey) {
        read_metadata(entry, file);
      } else {
        ranges.push_back(read_tensor(name, entry, file));
      }
    }
    std::sort(ranges.begin(), ranges.end());
    std::uint64_t end = 0;
    for (const auto& [from, to] : ranges) {
      if (from != end) fail(fmt::format("tensors leave or share bytes at {}", std::min(from, end)));
      end = to;
    }
    if (end != data_.size()) fail(fmt::format("{} bytes of tensors, the header tells of {}", data_.size(), end));
    return file;
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw UserError(place_, problem, kRemedy); }
  [[noreturn]] void fail(const std::string& tensor, const std::string& problem) const {
    throw UserError(place_ + ", tensor '" + shown(tensor) + "'", problem, kRemedy);
  }

  json read_header() {
    if (bytes_.size() < kLengthBytes) fail(fmt::format("{} bytes are no safetensors file", bytes_.size()));
    std::uint64_t length = 0;
    std::memcpy(&length, bytes_.data(), kLengthBytes);
    if (length > kMostHeaderBytes || length > bytes_.size() - kLengthBytes)
      fail(fmt::format("a header of {} bytes in a file of {}", length, bytes_.size()));
    const auto* text = reinterpret_cast<const char*>(bytes_.data() + kLengthBytes);
    data_ = bytes_.subspan(kLengthBytes + static_cast<std::size_t>(length));
    if (is_too_deep({text, static_cast<std::size_t>(length)})) fail("the header's JSON is nested too deeply");
    json header = json::parse(text, text + length, nullptr, false);
    if (!header.is_object()) fail("the header is no JSON object");
    return header;
  }

  /// Parsing recurses; a header needs four levels.
  static bool is_too_deep(std::string_view text) noexcept {
    int depth = 0, deepest = 0;
    for (const char c : text) {
      if (c == '{' || c == '[') deepest = std::max(deepest, ++depth);
      if (c == '}' || c == ']') --depth;
    }
    return deepest > 64;
  }

  void read_metadata(const json& entry, Safetensors& file) const {
    if (!entry.is_object()) fail("__metadata__ is no object");
    for (const auto& [key, value] : entry.items()) {
      if (!value.is_string()) fail("metadata '" + shown(key) + "' is no text");
      file.metadata[key] = value.get<std::string>();
    }
  }

  std::pair<std::uint64_t, std::uint64_t> read_tensor(const std::string& name, const json& entry,
                                                      Safetensors& file) const {
    if (!entry.is_object() || !entry.contains("dtype") || !entry.contains("shape") || !entry.contains("data_offsets"))
      fail(name, "wants dtype, shape and data_offsets");
    Tensor tensor;
    const json &type = entry["dtype"], &shape = entry["shape"], &offsets = entry["data_offsets"];
    if (type != "F32" && type != "BF16")
      fail(name, "dtype " + shown(type.dump(-1, ' ', true)) + "; read are F32 and BF16");
    tensor.type = type == "F32" ? TensorType::kF32 : TensorType::kBf16;
    if (!shape.is_array() || shape.size() > kMostDimensions) fail(name, "shape is no list of at most 8 numbers");
    for (const json& size : shape) {
      const auto value = unsigned_of(size);
      if (!value || *value > kMostValues) fail(name, "shape holds something else than sizes");
      tensor.shape.push_back(static_cast<std::int64_t>(*value));
    }
    const auto count = count_of(tensor.shape);
    if (!count) fail(name, "is larger than any model");
    const auto from = offsets.is_array() && offsets.size() == 2 ? unsigned_of(offsets[0]) : std::nullopt;
    const auto to = offsets.is_array() && offsets.size() == 2 ? unsigned_of(offsets[1]) : std::nullopt;
    if (!from || !to || *from > *to || *to > data_.size())
      fail(name, fmt::format("data_offsets do not lie in the file's {} bytes of tensors", data_.size()));
    if (*to - *from != *count * bytes_of(tensor.type))
      fail(name, fmt::format("{} bytes for {} values of {}", *to - *from, *count, name_of(tensor.type)));
    const auto data = data_.subspan(static_cast<std::size_t>(*from), static_cast<std::size_t>(*to - *from));
    tensor.bytes.assign(data.begin(), data.end());
    file.tensors[name] = std::move(tensor);
    return {*from, *to};
  }

  std::span<const std::byte> bytes_, data_;
  const std::string& place_;
};

}  // namespace

std::uint16_t to_bf16(float value) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  if (std::isnan(value)) return static_cast<std::uint16_t>((bits >> 16) | 0x40U);
  return static_cast<std::uint16_t>((bits + 0x7FFFU + ((bits >> 16) & 1U)) >> 16);
}

float from_bf16(std::uint16_t bits) noexcept { return std::bit_cast<float>(static_cast<std::uint32_t>(bits) << 16); }

std::size_t Tensor::size() const noexcept { return bytes.size() / bytes_of(type); }

std::vector<float> Tensor::values() const {
  std::vector<float> result(size());
  if (type == TensorType::kF32) {
    std::memcpy(result.data(), bytes.data(), bytes.size());
    return result;
  }
  for (std::size_t i = 0; i < result.size(); ++i) {
    std::uint16_t bits = 0;
    std::memcpy(&bits, bytes.data() + 2 * i, 2);
    result[i] = from_bf16(bits);
  }
  return result;
}

const Tensor& Safetensors::require(const std::string& place, const std::string& name,
                                   std::span<const std::int64_t> shape) const {
  const auto found = tensors.find(name);
  if (found == tensors.end()) throw UserError(place, "has no tensor '" + name + "'", kRemedy);
  if (!std::equal(shape.begin(), shape.end(), found->second.shape.begin(), found->second.shape.end()))
    throw UserError(place + ", tensor '" + name + "'",
                    fmt::format("has shape [{}], the model needs [{}]", fmt::join(found->second.shape, ", "),
                                fmt::join(shape, ", ")),
                    kRemedy);
  return found->second;
}

const std::string& Safetensors::require_metadata(const std::string& place, const std::string& key) const {
  const auto found = metadata.find(key);
  if (found == metadata.end()) throw UserError(place, "has no metadata '" + key + "'", kRemedy);
  return found->second;
}

Safetensors parse_safetensors(std::span<const std::byte> bytes, const std::string& place) {
  return Reader(bytes, place).read();
}

Safetensors load_safetensors(const std::filesystem::path& path) {
  // Of a folder, a stream says nothing before it is read, and then throws its own.
  if (std::filesystem::is_directory(path)) throw UserError(path.string(), "is a folder", "name a file of weights");
  std::ifstream stream(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.good() && !stream.eof()) throw UserError(path.string(), "cannot be read", "check name and permissions");
  return parse_safetensors(std::as_bytes(std::span(text)), path.string());
}

std::string safetensors_bytes(const Safetensors& file) {
  json header = json::object();
  if (!file.metadata.empty()) header[kMetadataKey] = file.metadata;
  std::uint64_t offset = 0;
  for (const auto& [name, tensor] : file.tensors) {
    const auto count = count_of(tensor.shape);
    if (!count || *count * bytes_of(tensor.type) != tensor.bytes.size())
      throw std::invalid_argument("safetensors_bytes: the bytes of '" + name + "' do not fit its shape");
    const std::uint64_t end = offset + tensor.bytes.size();
    header[name] = {{"dtype", name_of(tensor.type)}, {"shape", tensor.shape}, {"data_offsets", {offset, end}}};
    offset = end;
  }
  std::string text = header.dump();
  text.append((kLengthBytes - text.size() % kLengthBytes) % kLengthBytes, ' ');
  const auto length = static_cast<std::uint64_t>(text.size());
  std::string result(kLengthBytes, '\0');
  std::memcpy(result.data(), &length, kLengthBytes);
  result += text;
  for (const auto& [name, tensor] : file.tensors)
    result.append(reinterpret_cast<const char*>(tensor.bytes.data()), tensor.bytes.size());
  return result;
}

Tensor make_tensor(std::span<const float> values, std::vector<std::int64_t> shape, TensorType type) {
  Tensor tensor{type, std::move(shape), std::vector<std::byte>(values.size() * bytes_of(type))};
  if (count_of(tensor.shape) != values.size())
    throw std::invalid_argument(fmt::format("make_tensor: {} values do not fit the shape", values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (type == TensorType::kF32) {
      std::memcpy(tensor.bytes.data() + 4 * i, &values[i], 4);
    } else {
      const std::uint16_t bits = to_bf16(values[i]);
      std::memcpy(tensor.bytes.data() + 2 * i, &bits, 2);
    }
  }
  return tensor;
}

}  // namespace risorius
