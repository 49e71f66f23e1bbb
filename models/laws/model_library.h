#pragma once

#include <memory>

#include "samara/models/laws/law_model.h"

/// Models of your own for the command: a shared library that `samara --model-library libmine.so ..` loads.
///
///     struct Pendulum { .. };                 // a law, see law_model.h
///     SAMARA_MODEL_LIBRARY(Pendulum)          // once in the library, outside of all namespaces; all its laws
namespace samara::models {

/// Of what a library and its user must agree on: changes with Model, ModelInfo and the functions below.
inline constexpr const char* kModelInterface = "samara-models/1";

using AddModel = void (*)(const std::shared_ptr<const Model>& model);

template <class... Laws>
void add_laws(AddModel add) {
  (add(make_model<Laws>()), ...);
}

}  // namespace samara::models

#define SAMARA_MODEL_LIBRARY(...)                                                                          \
  extern "C" __attribute__((visibility("default"))) const char* samara_model_interface() {                 \
    return samara::models::kModelInterface;                                                                \
  }                                                                                                        \
  extern "C" __attribute__((visibility("default"))) void samara_add_models(samara::models::AddModel add) { \
    samara::models::add_laws<__VA_ARGS__>(add);                                                            \
  }
