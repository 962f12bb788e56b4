#include "generate/safetensors.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

#include "capture/errors.h"

namespace risorius {
namespace {

Safetensors sample() {
  Safetensors file;
  file.metadata = {{"model", "sample"}, {"channels", "AU1,AU2"}};
  file.tensors["a"] = make_tensor(std::vector<float>{1, -2.5F, 3}, {3}, TensorType::kF32);
  file.tensors["b"] = make_tensor(std::vector<float>{1, 2, 3, 4}, {2, 2}, TensorType::kBf16);
  file.tensors["empty"] = make_tensor({}, {0, 4}, TensorType::kF32);
  return file;
}

Safetensors parsed(const std::string& bytes) { return parse_safetensors(std::as_bytes(std::span(bytes)), "test"); }

/// A file of this header and so many bytes of tensors.
std::string file_of(const std::string& header, std::size_t data) {
  std::string bytes(8, '\0');
  const std::uint64_t length = header.size();
  std::memcpy(bytes.data(), &length, 8);
  return bytes + header + std::string(data, 'x');
}

TEST(Safetensors, ReadsWhatItWrites) {
  const Safetensors file = sample(), read = parsed(safetensors_bytes(file));
  EXPECT_EQ(read.metadata, file.metadata);
  ASSERT_EQ(read.tensors.size(), 3u);
  EXPECT_EQ(read.tensors.at("a").values(), (std::vector<float>{1, -2.5F, 3}));
  EXPECT_EQ(read.tensors.at("b").values(), (std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(read.tensors.at("b").shape, (std::vector<std::int64_t>{2, 2}));
  EXPECT_EQ(safetensors_bytes(read), safetensors_bytes(file));
}

TEST(Safetensors, HasTheLayoutOfTheFormat) {
  Safetensors file;
  file.tensors["w"] = make_tensor(std::vector<float>{1}, {1}, TensorType::kF32);
  const std::string bytes = safetensors_bytes(file);
  const std::string header = R"({"w":{"data_offsets":[0,4],"dtype":"F32","shape":[1]}})";
  ASSERT_EQ(bytes.substr(8, header.size()), header);
  EXPECT_EQ(static_cast<unsigned char>(bytes[0]) % 8, 0) << "tensors begin at a multiple of 8";
  EXPECT_EQ(bytes.substr(bytes.size() - 4), std::string("\0\0\x80\x3f", 4)) << "1.0 little-endian";
}

TEST(Safetensors, RefusesEveryTruncationAndWhatIsTooMuch) {
  const std::string bytes = safetensors_bytes(sample());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW(parsed(bytes.substr(0, size)), UserError) << size;
  EXPECT_THROW(parsed(bytes + "x"), UserError);
}

TEST(Safetensors, RefusesHeadersThatDoNotFitTheBytes) {
  EXPECT_NO_THROW(parsed(file_of(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}})", 4)));
  for (
      const char* header :
      {R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,4]}})",
       R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[0,8]}})",
       R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[4,0]}})",
       R"({"a":{"dtype":"F64","shape":[1],"data_offsets":[0,4]}})",
       R"({"a":{"dtype":"F32","shape":[-1],"data_offsets":[0,4]}})", R"({"a":{"dtype":"F32","shape":[1]}})",
       R"({"a":{"dtype":"F32","shape":[4294967296,4294967296],"data_offsets":[0,4]}})",
       R"({"a":{"dtype":"F32","shape":"1","data_offsets":[0,4]}})", R"({"a":7})", "[]", "{", "",
       R"({"a":{"dtype":"BF16","shape":[1],"data_offsets":[2,4]}})",
       R"({"a":{"dtype":"BF16","shape":[2],"data_offsets":[0,4]},"b":{"dtype":"BF16","shape":[1],"data_offsets":[2,4]}})",
       R"({"__metadata__":{"x":1},"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}})"})
    EXPECT_THROW(parsed(file_of(header, 4)), UserError) << header;
  EXPECT_THROW(parsed(file_of(std::string(100'000, '['), 0)), UserError);
  std::string huge(8, '\xff');
  EXPECT_THROW(parsed(huge + "{}"), UserError);
}

TEST(Safetensors, SaysWhichTensorDoesNotFit) {
  const Safetensors file = sample();
  const std::vector<std::int64_t> shape{2, 3};
  try {
    file.require("w.safetensors", "b", shape);
    FAIL();
  } catch (const UserError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("w.safetensors, tensor 'b'"), std::string::npos) << text;
    EXPECT_NE(text.find("[2, 2]"), std::string::npos) << text;
    EXPECT_NE(text.find("[2, 3]"), std::string::npos) << text;
  }
  EXPECT_THROW(file.require("w", "c", shape), UserError);
  EXPECT_THROW(file.require_metadata("w", "rate_hz"), UserError);
}

TEST(Safetensors, RoundsToBf16ToNearestAndEven) {
  EXPECT_EQ(from_bf16(to_bf16(1.0F)), 1.0F);
  EXPECT_EQ(from_bf16(to_bf16(-3.140625F)), -3.140625F);
  // 1 + 2^-8 lies between 1 and 1 + 2^-7: to the even one; a little more goes up.
  EXPECT_EQ(from_bf16(to_bf16(1.00390625F)), 1.0F);
  EXPECT_EQ(from_bf16(to_bf16(1.00390637F)), 1.0078125F);
  EXPECT_EQ(from_bf16(to_bf16(1.01171875F)), 1.015625F);
  EXPECT_TRUE(std::isinf(from_bf16(to_bf16(std::numeric_limits<float>::infinity()))));
  EXPECT_TRUE(std::isnan(from_bf16(to_bf16(std::numeric_limits<float>::quiet_NaN()))));
  EXPECT_THROW(make_tensor(std::vector<float>{1, 2}, {3}, TensorType::kF32), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
