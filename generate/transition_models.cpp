#include "generate/transition_models.h"

#include "generate/interpolation.h"

namespace risorius {

std::vector<std::string_view> transition_model_names() {
  return {"minimum_jerk", "hold", "linear", "cubic_hermite", "quintic"};
}

std::unique_ptr<TransitionModel> make_transition_model(std::string_view name, const std::vector<std::string>&) {
  return make_interpolation(name);
}

}  // namespace risorius
