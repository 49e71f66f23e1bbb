#include "samara/codebooks/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/certificate.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/codebooks/plan/body_table.h"
#include "samara/codebooks/plan/box_table.h"
#include "samara/codebooks/plan/builder_table.h"
#include "samara/codebooks/plan/command_table.h"
#include "samara/codebooks/plan/plan_subject.h"
#include "samara/codebooks/plan/tolerance_table.h"
#include "samara/io/checksum.h"
#include "samara/io/text_file.h"
#include "samara/io/toml_document.h"
#include "samara/models/equations/equation_model.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;

constexpr const char* kKind = "a plan of a codebook";  // of such a file, in messages

/// A title is shown on terminals and stored in files, one line.
std::string read_title(const TomlTable& root) {
  std::string title = root.optional_string("title").value_or("");
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  const auto bad = std::find_if(title.begin(), title.end(), is_control);
  if (bad == title.end()) return title;
  throw root.error("title",
                   fmt::format("has the control character \\x{:02x} in it, expected one line of text",
                               static_cast<unsigned char>(*bad)));
}

/// What is given for a coordinate, fixed or free.
void read_coordinates(const TomlTable& root, const PlanSubject& subject, Plan& plan) {
  if (const auto fixed = root.optional_table("fixed")) {
    for (const std::string& key : fixed->keys()) {
      plan.fixed[key] =
          fixed->quantity(key, unit_of(*fixed, key, subject.settable, subject, subject.what_settable));
      check_meaning(*fixed, key, subject, plan.fixed[key]);
    }
  }
  const TomlTable box = root.table("box");
  for (const std::string& key : box.keys()) {
    const std::string& unit = unit_of(box, key, subject.settable, subject, subject.what_settable);
    if (subject.field != nullptr && key == subject.field->extent) {
      throw box.error(
          key, fmt::format("is free, expected it in [fixed]: it is how far {} goes", subject.field->place));
    }
    if (plan.fixed.count(key) > 0)
      throw box.error(key, "is fixed in [fixed] and free in [box], expected one of them");
    plan.box.push_back(read_box_entry(box, key, unit));
    for (const double end : {plan.box.back().lower, plan.box.back().upper})
      check_meaning(box, key, subject, end);
  }
  if (plan.box.empty())
    throw root.error("box", fmt::format("is empty, expected at least one free {}", subject.what_settable));
}

/// A command may do without time.
void read_time(const TomlTable& root, const PlanSubject& subject, Plan& plan) {
  if (plan.command && !root.has("time")) return;
  const TomlTable time = root.table("time");
  time.expect_keys({"end"});
  plan.end = time.quantity("end", subject.time_unit);
  if (!(plan.end > 0.0)) throw time.error("end", fmt::format("is {}, expected more than 0", plan.end));
}

bool is_given(const Plan& plan, const std::string& name) {
  return plan.fixed.contains(name) || std::ranges::count(plan.box, name, &BoxEntry::name) > 0;
}

/// Nothing that the model or the command asks for may be missing.
void check_complete(const TomlTable& root, const Plan& plan) {
  if (plan.field != nullptr) {
    for (const models::ParameterInfo& parameter : plan.field->info.parameters) {
      if (parameter.default_value || is_given(plan, parameter.name)) continue;
      throw root.error("model", fmt::format("needs \"{}\" ({}), expected in [box] or [fixed]", parameter.name,
                                            parameter.unit));
    }
    return;
  }
  if (plan.command) {
    for (const CommandQuantity& input : plan.command->inputs) {
      if (is_given(plan, input.name)) continue;
      throw root.table("command").table("inputs").error(
          input.name, "is given no values, expected an interval in [box] or a number in [fixed]");
    }
    return;
  }
  std::string missing;
  for (const models::ParameterInfo& parameter : plan.definition->info().parameters) {
    if (parameter.default_value || !parameter.derived.empty() || is_given(plan, parameter.name)) continue;
    missing += fmt::format("{}\"{}\"{}", missing.empty() ? "" : ", ", parameter.name,
                           parameter.unit == "1" ? "" : fmt::format(" ({})", parameter.unit));
  }
  const std::string key = root.has("equations") ? "equations" : "model";
  if (!missing.empty()) throw root.error(key, fmt::format("needs {}, expected in [fixed] or [box]", missing));
  try {
    const models::ParametricModel model = plan.parametric_model();
    for (const double share : {0.5, 0.0, 1.0}) {
      std::vector<double> point;
      for (const BoxEntry& entry : plan.box)
        point.push_back((1.0 - share) * entry.lower + share * entry.upper);
      model.check(point);
    }
  } catch (const ArgumentError& error) {
    throw InputError(plan.source, root.line(key), error.what());
  }
}

}  // namespace

int Plan::certificate_points(double seconds_per_call, double calls, int refuted_before) const {
  constexpr double kLongCall = 60.0;  // s
  constexpr double kFewest = 10.0;
  if (assurance) {
    // log 20 = 3.0 and log 2 = 0.7: an allowed chance of error of 0.05, which every refutation halves.
    return static_cast<int>(std::ceil((3.0 + 0.7 * refuted_before) / (1.0 - *assurance) - 1e-6));
  }
  if (!command) return kCertificatePoints;
  double points = kCertificatePoints;
  if (builder.max_calls > 0) points = std::min(points, static_cast<double>(builder.max_calls));
  if (seconds_per_call > kLongCall) points = std::min(points, std::max(calls, kFewest));
  return static_cast<int>(points);
}

std::uint64_t Plan::certificate_seed() const {
  std::string question = model;
  if (const models::Equations* equations = definition ? models::equations_of(*definition) : nullptr)
    question += to_toml(*equations);
  for (const auto& [name, value] : fixed) question += fmt::format("|{} {}", name, value);
  for (const BoxEntry& entry : box)
    question += fmt::format("|{} {} {}", entry.name, entry.lower, entry.upper);
  question += fmt::format("|{} {}|{} {}|{}", end, relative, builder.kind, builder.strategy, builder.seed);
  return pgd::Random(io::fnv1a(question)).bits();
}

std::string Plan::whole_text() const {
  const models::Equations* equations = definition ? models::equations_of(*definition) : nullptr;
  std::string whole = equations == nullptr ? text : text + "\n# the model\n" + to_toml(*equations);
  for (const auto& [name, value] : of_body) whole += fmt::format("\n# {} = {}", name, value);
  return whole;
}

bool BuildRequest::prescribes_axes() const {
  return std::ranges::any_of(box, &BoxEntry::prescribes_axis);
}

models::ParametricModel Plan::parametric_model() const {
  if (command) throw ArgumentError(fmt::format("the plan {} is one of a command and has no model", source));
  if (field != nullptr)
    throw ArgumentError(fmt::format("the plan {} is one of a field, which has no trajectories", source));
  std::vector<std::string> free;
  for (const BoxEntry& entry : box) free.push_back(entry.name);
  return models::ParametricModel(definition, fixed, free);
}

Plan parse_plan(const std::string& text, const std::string& name,
                const std::shared_ptr<const models::Model>& model, const BodyReader& body_reader) {
  const TomlTable root = TomlTable::parse(text, name, kKind);
  if (root.has("rates") && !root.has("box"))
    throw root.error("rates",
                     "are those of a model, not of a plan: a plan names the file by `model = \"..\"`");
  root.expect_keys(
      {"model", "equations", "command", "title", "body", "fixed", "box", "time", "tolerance", "builder"});
  Plan plan;
  plan.source = name;
  plan.text = text;
  if (const auto command = root.optional_table("command")) {
    for (const char* other : {"model", "equations"}) {
      if (root.has(other)) throw root.error("command", "stands beside a model, expected one of the two");
    }
    plan.command = read_command(*command);
  }
  const PlanSubject subject = plan.command ? subject_of(*plan.command)
                              : model      ? subject_of(model)
                                           : read_subject(root);
  plan.definition = subject.model;
  plan.field = subject.field;
  if (!model && root.has("model") && is_model_file(root.string("model")))
    plan.model_file = (std::filesystem::path(root.file()).parent_path() / root.string("model")).string();
  if (subject.info() != nullptr) plan.model = subject.info()->name;
  plan.title = read_title(root);
  read_coordinates(root, subject, plan);
  read_body(root, body_reader, plan);
  read_time(root, subject, plan);
  read_tolerance(root, subject, plan);
  read_builder(root, plan);
  check_assurance_is_allowed(root, plan);
  check_complete(root, plan);
  return plan;
}

Plan read_plan(const std::filesystem::path& path, const BodyReader& body_reader) {
  return parse_plan(io::read_text_file(path, {.expected = kKind}), path.string(), {}, body_reader);
}

}  // namespace samara::codebooks
