// Weights on disk: the safetensors format (github.com/huggingface/safetensors). Eight bytes of header length, a JSON
// header {name: {dtype, shape, data_offsets}, "__metadata__": {key: text}}, then the tensors' bytes, little-endian.
// Reading is strict: sizes must follow from shapes, tensors must lie one behind the other and fill the file. F32 and
// BF16 tensors only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

enum class TensorType : std::uint8_t { kF32, kBf16 };

struct Tensor {
  TensorType type = TensorType::kF32;
  std::vector<std::int64_t> shape;  ///< row-major
  std::vector<std::byte> bytes;

  std::size_t size() const noexcept;  ///< number of values
  std::vector<float> values() const;  ///< bf16 widened exactly
};

struct Safetensors {
  std::map<std::string, std::string> metadata;
  std::map<std::string, Tensor> tensors;

  /// Throws UserError naming `place`, the tensor, its shape and the one expected.
  const Tensor& require(const std::string& place, const std::string& name, std::span<const std::int64_t> shape) const;
  /// Throws UserError if the key is missing.
  const std::string& require_metadata(const std::string& place, const std::string& key) const;
};

/// `place` stands in messages. Throws UserError (place, tensor or byte, problem, remedy).
Safetensors parse_safetensors(std::span<const std::byte> bytes, const std::string& place);
Safetensors load_safetensors(const std::filesystem::path& path);
/// The file's bytes: header padded to a multiple of 8, tensors in the order of their names. Throws
/// std::invalid_argument if a tensor's bytes do not fit its shape.
std::string safetensors_bytes(const Safetensors& file);

/// A tensor of these values; bf16 by rounding to nearest, ties to even. NaN stays NaN.
Tensor make_tensor(std::span<const float> values, std::vector<std::int64_t> shape, TensorType type);
std::uint16_t to_bf16(float value) noexcept;
float from_bf16(std::uint16_t bits) noexcept;

}  // namespace risorius
