#include "generate/transition_models.h"

#include "generate/interpolation.h"
#include "generate/shipped_models.h"

namespace risorius {

std::unique_ptr<TransitionModel> make_transition_model(std::string_view name,
                                                       const std::vector<std::string>& au_names) {
  if (name == "expression_generator") return shipped_expression_generator(au_names);
  return make_interpolation(name);
}

}  // namespace risorius
