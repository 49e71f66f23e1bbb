#include <cmath>

#include <fmt/format.h>

#include "commands.h"
#include "output.h"
#include "samara/models/model.h"
#include "terminal.h"

namespace samara::apps {

namespace {

std::string default_text(const models::ParameterInfo& parameter) {
  if (parameter.default_value) return fmt::format("{}", *parameter.default_value);
  return parameter.derived.empty() ? "required" : parameter.derived;
}

Json to_json(const models::ModelInfo& info) {
  Json object = {{"name", info.name},
                 {"title", info.title},
                 {"equations", info.equations},
                 {"frames", info.frames},
                 {"source", info.source},
                 {"validity", info.validity},
                 {"symmetries", info.symmetries},
                 {"time_unit", models::time_unit(info)},
                 {"states", Json::array()},
                 {"parameters", Json::array()}};
  for (const auto& s : info.states) {
    object["states"].push_back({{"name", s.name},
                                {"unit", s.unit},
                                {"default_initial", s.default_initial},
                                {"description", s.description}});
  }
  for (const auto& p : info.parameters) {
    Json parameter = {{"name", p.name}, {"unit", p.unit}, {"description", p.description}};
    parameter["default"] = p.default_value ? Json(*p.default_value) : Json(nullptr);
    parameter["derived"] = p.derived.empty() ? Json(nullptr) : Json(p.derived);
    parameter["lower"] = std::isfinite(p.lower) ? Json(p.lower) : Json(nullptr);
    parameter["lower_inclusive"] = p.lower_inclusive;
    object["parameters"].push_back(parameter);
  }
  return object;
}

std::string explain(const models::ModelInfo& info) {
  std::string text = fmt::format("{}: {}\n\n  {}\n\n  frames: {}\n  source: {}\n  valid: {}\n", info.name,
                                 info.title, info.equations, info.frames, info.source, info.validity);
  for (const std::string& symmetry : info.symmetries) text += fmt::format("  symmetry: {}\n", symmetry);
  text += fmt::format("\n  {:<16} {:<8} {:<40} {}\n", "parameter", "unit", "default", "meaning");
  for (const auto& p : info.parameters) {
    text += fmt::format("  {:<16} {:<8} {:<40} {}\n", p.name, p.unit, default_text(p), p.description);
  }
  text += fmt::format("\n  {:<16} {:<8} {:<40} {}\n", "initial value", "unit", "default", "state");
  for (const auto& s : info.states) {
    text += fmt::format("  {:<16} {:<8} {:<40} {}\n", s.name + "(0)", s.unit,
                        fmt::format("{}", s.default_initial), s.description);
  }
  return text;
}

}  // namespace

int run(const ModelsArguments& arguments) {
  std::vector<std::string> names = models::model_names();
  if (!arguments.model.empty()) names = {models::find_model(arguments.model)->info().name};
  if (arguments.json) {
    Json object = {{"schema", "samara-models/1"}, {"models", Json::array()}};
    for (const std::string& name : names)
      object["models"].push_back(to_json(models::find_model(name)->info()));
    print(object);
  } else if (!arguments.model.empty()) {
    print(explain(models::find_model(arguments.model)->info()));
  } else {
    for (const std::string& name : names) {
      print(fmt::format("{:<24} {}\n", name, models::find_model(name)->info().title));
    }
  }
  return kDone;
}

}  // namespace samara::apps
