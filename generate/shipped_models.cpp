#include "generate/shipped_models.h"

#include "generate/expression_generator.h"
#include "generate/learned_continuation.h"

// The files as they are, in read-only memory. RISORIUS_WEIGHTS_FOLDER is generate/weights, an absolute path.
#define RISORIUS_INCLUDE_WEIGHTS(symbol, file)                                 \
  asm(".pushsection .rodata\n"                                                 \
      ".balign 16\n" #symbol                                                   \
      ":\n"                                                                    \
      ".incbin \"" RISORIUS_WEIGHTS_FOLDER "/" file "\"\n" #symbol             \
      "_end:\n"                                                                \
      ".byte 0\n"                                                              \
      ".popsection\n");                                                        \
  extern "C" {                                                                 \
  extern const std::byte symbol[] __attribute__((visibility("hidden")));       \
  extern const std::byte symbol##_end[] __attribute__((visibility("hidden"))); \
  }

RISORIUS_INCLUDE_WEIGHTS(risorius_weights_expression_generator, "expression_generator.safetensors")
RISORIUS_INCLUDE_WEIGHTS(risorius_weights_continuation, "continuation.safetensors")

namespace risorius {
namespace {

Safetensors shipped(const std::byte* begin, const std::byte* end, const std::string& place) {
  return parse_safetensors({begin, static_cast<std::size_t>(end - begin)}, place);
}

const std::string kGeneratorPlace = "shipped expression_generator.safetensors";

Safetensors shipped_generator_weights() {
  return shipped(risorius_weights_expression_generator, risorius_weights_expression_generator_end, kGeneratorPlace);
}

}  // namespace

std::unique_ptr<TransitionModel> shipped_expression_generator(const std::vector<std::string>& names) {
  return std::make_unique<ExpressionGenerator>(shipped_generator_weights(), kGeneratorPlace, names);
}

std::string shipped_expression_generator_trained_on() {
  return shipped_generator_weights().require_metadata(kGeneratorPlace, "trained_on");
}

std::unique_ptr<ContinuationModel> shipped_continuation(const std::vector<std::string>& names,
                                                        std::vector<double> upper_bound) {
  const std::string place = "shipped continuation.safetensors";
  return std::make_unique<LearnedContinuation>(
      shipped(risorius_weights_continuation, risorius_weights_continuation_end, place), place, names,
      std::move(upper_bound));
}

}  // namespace risorius
