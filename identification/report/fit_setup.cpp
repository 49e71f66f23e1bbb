#include "samara/identification/report/fit_setup.h"

#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "samara/identification/problem/prior_formats.h"

namespace samara::identification {

namespace {

using ParsedJson = nlohmann::json;
using Names = std::vector<std::string>;

constexpr const char* kOffsetOf = "offset of ";

Json json_of(const CameraOptions& camera) {
  return {{"scale", number(camera.scale)},
          {"rotation", number(camera.rotation)},
          {"axes", camera.axes},
          {"angles", camera.angles ? Json(*camera.angles) : Json(nullptr)}};
}

template <class Value>
std::optional<Value> value_of(const ParsedJson& object, const char* key) {
  const ParsedJson& value = object.at(key);
  if (value.is_null()) return {};
  return value.get<Value>();
}

CameraOptions camera_of(const ParsedJson& object) {
  return {.scale = value_of<double>(object, "scale"),
          .rotation = value_of<double>(object, "rotation"),
          .axes = object.at("axes").get<Names>(),
          .angles = value_of<Names>(object, "angles")};
}

FitOptions setup_of(const ParsedJson& object) {
  FitOptions setup;
  setup.compared.outputs = object.at("outputs").get<Names>();
  setup.compared.averaged_frames = object.at("averaged_frames").get<int>();
  setup.compared.periods = object.value("periods", setup.compared.periods);
  setup.unknowns.shared = object.at("shared").get<Names>();
  setup.unknowns.per_capture = object.at("per_capture").get<Names>();
  setup.unknowns.fixed = object.at("fixed").get<std::map<std::string, double>>();
  setup.unknowns.offsets = object.at("offsets").get<Names>();
  for (const auto& name : object.at("known").get<Names>()) setup.unknowns.known.emplace(name, name);
  for (const auto& [name, interval] : object.at("box").items())
    setup.unknowns.box[name] = {interval.at(0).get<double>(), interval.at(1).get<double>()};
  for (const auto& [name, prior] : object.at("priors").items())
    setup.priors.coordinates[name] = prior_of(prior);
  setup.camera = camera_of(object.at("camera"));
  setup.starts.round_body = object.at("round_body").get<bool>();
  return setup;
}

/// What coefficients and captures tell of it.
FitOptions guessed_setup(const FitResult& fitted) {
  FitOptions setup;
  setup.unknowns.offsets = Names();
  for (const Coefficient& c : fitted.coefficients) {
    setup.unknowns.shared.push_back(c.name);
    setup.unknowns.box[c.name] = {c.lower, c.upper};
  }
  for (const OutputRms& residual : fitted.residuals) setup.compared.outputs.push_back(residual.output);
  if (fitted.captures.empty()) return setup;
  for (const Nuisance& n : fitted.captures.front().nuisances) {
    if (n.name.starts_with(kOffsetOf)) {
      setup.unknowns.offsets->push_back(n.name.substr(std::string(kOffsetOf).size()));
    } else {
      setup.unknowns.per_capture.push_back(n.name);
    }
  }
  for (const auto& [name, value] : fitted.captures.front().known) setup.unknowns.known.emplace(name, name);
  return setup;
}

}  // namespace

Json setup_json(const FitOptions& setup) {
  Json known = Json::array();
  for (const auto& [name, value] : setup.unknowns.known) known.push_back(name);
  Json box = Json::object();
  for (const auto& [name, interval] : setup.unknowns.box) box[name] = {interval.lower, interval.upper};
  Json priors = Json::object();
  for (const auto& [name, prior] : setup.priors.coordinates) priors[name] = prior_json(prior);
  return {{"outputs", setup.compared.outputs},
          {"averaged_frames", setup.compared.averaged_frames},
          {"periods", setup.compared.periods},
          {"shared", setup.unknowns.shared},
          {"per_capture", setup.unknowns.per_capture},
          {"known", known},
          {"fixed", setup.unknowns.fixed},
          {"box", box},
          {"offsets", setup.unknowns.offsets.value_or(Names())},
          {"priors", priors},
          {"camera", json_of(setup.camera)},
          {"round_body", setup.starts.round_body}};
}

FitOptions read_setup(const ParsedJson& fit, const FitResult& fitted) {
  const auto found = fit.find("setup");
  return found == fit.end() ? guessed_setup(fitted) : setup_of(*found);
}

}  // namespace samara::identification
