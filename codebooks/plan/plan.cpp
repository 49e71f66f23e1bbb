#include "samara/codebooks/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/limits.h"
#include "samara/codebooks/book/certificate.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/codebooks/plan/plan_body.h"
#include "samara/codebooks/plan/plan_builder.h"
#include "samara/codebooks/plan/plan_command.h"
#include "samara/codebooks/plan/plan_subject.h"
#include "samara/io/text_file.h"
#include "samara/io/toml_document.h"
#include "samara/models/equations/equation_model.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;

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

/// Basis and transform of a free coordinate.
void read_axis_kind(const TomlTable& table, BoxEntry& entry) {
  entry.basis = pgd::basis_from_string(table.choice("basis", pgd::parameter_basis_names()));
  entry.transform =
      pgd::transform_from_string(table.choice("transform", {"none", "log", "reciprocal", "square_root"}));
  const pgd::BasisTraits& basis = pgd::basis_traits(entry.basis);
  if (!basis.tells_resolution && !entry.nodes)
    throw table.error("basis", fmt::format("is \"{}\", whose nodes the builder cannot choose: expected a key "
                                           "nodes beside it",
                                           to_string(entry.basis)));
  if (basis.odd_nodes && entry.nodes && *entry.nodes % 2 == 0) {
    throw table.error("nodes", fmt::format("is {}, expected an odd number of nodes on a {} axis",
                                           *entry.nodes, to_string(entry.basis)));
  }
  const bool periodic = basis.family == pgd::AxisFamily::periodic;
  if (periodic && entry.name.ends_with("(0)"))
    throw table.error(
        "basis", fmt::format("is \"{}\", but a solution is not periodic in an initial value", basis.name));
  if (periodic && entry.transform != pgd::Transform::none)
    throw table.error("transform", fmt::format("is not \"none\", which a {} axis cannot have", basis.name));
  if (!in_domain(entry.transform, entry.lower)) {
    throw table.error("transform", fmt::format("is \"{}\", which is not defined at the lower end {}",
                                               to_string(entry.transform), entry.lower));
  }
}

void check_size(const TomlTable& table, const std::string& key, double value) {
  if (std::abs(value) <= kLargestInput) return;
  throw table.error(key, fmt::format("has the number {}, expected at most {} in size", value, kLargestInput));
}

BoxEntry read_entry(const TomlTable& box, const std::string& key, const std::string& unit) {
  BoxEntry entry;
  entry.name = key;
  std::vector<double> range;
  if (box.is_table(key)) {
    const TomlTable table = box.table(key);
    table.expect_keys({"range", "nodes", "basis", "transform"});
    range = table.quantities("range", unit);
    if (const auto nodes = table.optional_integer("nodes")) {
      if (*nodes < 2 || *nodes > 2000)
        throw table.error("nodes", fmt::format("is {}, expected 2 to 2000", *nodes));
      entry.nodes = static_cast<int>(*nodes);
    }
  } else {
    range = box.quantities(key, unit);
  }
  if (range.size() != 2)
    throw box.error(key, fmt::format("has {} numbers, expected an interval [lower, upper]", range.size()));
  for (const double end : range) check_size(box, key, end);
  if (!(range[0] < range[1])) {
    throw box.error(key, fmt::format("is the interval [{}, {}], expected lower < upper", range[0], range[1]));
  }
  constexpr double kLeastWidth = 1e-9;  // of the ends; narrower ones have no nodes that differ
  if (range[1] - range[0] < kLeastWidth * std::max(std::abs(range[0]), std::abs(range[1]))) {
    throw box.error(key, fmt::format("is the interval [{}, {}], expected a width of at least {} of its ends",
                                     range[0], range[1], kLeastWidth));
  }
  entry.lower = range[0];
  entry.upper = range[1];
  if (box.is_table(key)) read_axis_kind(box.table(key), entry);
  return entry;
}

void read_tolerance(const TomlTable& root, const PlanSubject& subject, Plan& plan) {
  const auto table = root.optional_table("tolerance");
  if (!table) return;
  table->expect_keys({"relative", "absolute", "assurance"});
  plan.relative = table->optional_number("relative").value_or(plan.relative);
  if (!(plan.relative > 0.0 && plan.relative < 1.0)) {
    throw table->error("relative", fmt::format("is {}, expected more than 0 and less than 1", plan.relative));
  }
  if (plan.relative < kLeastTolerance) {
    throw table->error("relative",
                       fmt::format("is {}, expected at least {}, which is what the integrator can "
                                   "certify",
                                   plan.relative, kLeastTolerance));
  }
  plan.assurance = table->optional_number("assurance");
  constexpr double kLeastAssurance = 0.7, kMostAssurance = 0.999997;  // 10 and a million points
  if (plan.assurance && !(*plan.assurance >= kLeastAssurance && *plan.assurance <= kMostAssurance)) {
    throw table->error("assurance", fmt::format("is {}, expected {} to {}: a share of the box",
                                                *plan.assurance, kLeastAssurance, kMostAssurance));
  }
  const auto absolute = table->optional_table("absolute");
  if (!absolute) return;
  for (const std::string& key : absolute->keys()) {
    const std::string& unit = unit_of(*absolute, key, subject.outputs, subject, subject.what_output);
    const double value = absolute->difference(key, unit);
    if (!(value >= 0.0)) throw absolute->error(key, fmt::format("is {}, expected at least 0", value));
    plan.absolute[key] = value;
  }
}

/// A command may be called no oftener for the certificate than for the build.
void check_assurance_is_allowed(const TomlTable& root, const Plan& plan) {
  if (!plan.command || !plan.assurance) return;
  const int points = plan.certificate_points();
  const long allowed = plan.builder.max_calls > 0 ? plan.builder.max_calls : kMostSampledCalls;
  if (points <= allowed) return;
  throw root.table("tolerance")
      .error("assurance",
             fmt::format("is {}, which takes {} points, more than the {} calls that max_calls of "
                         "[builder] allows",
                         *plan.assurance, points, allowed));
}

/// What is given for a coordinate, fixed or free.
void read_coordinates(const TomlTable& root, const PlanSubject& subject, Plan& plan) {
  if (const auto fixed = root.optional_table("fixed")) {
    for (const std::string& key : fixed->keys()) {
      plan.fixed[key] =
          fixed->quantity(key, unit_of(*fixed, key, subject.settable, subject, subject.what_settable));
      check_size(*fixed, key, plan.fixed[key]);
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
    plan.box.push_back(read_entry(box, key, unit));
    check_meaning(box, key, subject, plan.box.back().lower);
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
  check_size(time, "end", plan.end);
  if (!(plan.end > 0.0)) throw time.error("end", fmt::format("is {}, expected more than 0", plan.end));
  constexpr double kShortest = 1e-60;
  if (plan.end < kShortest)
    throw time.error("end", fmt::format("is {}, expected at least {}", plan.end, kShortest));
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
    std::vector<double> centre;
    for (const BoxEntry& entry : plan.box) centre.push_back(0.5 * (entry.lower + entry.upper));
    model.check(centre);
  } catch (const ArgumentError& error) {
    throw InputError(plan.source, root.line(key), error.what());
  }
}

}  // namespace

int Plan::certificate_points(double seconds_per_call, double calls) const {
  constexpr double kLongCall = 60.0;  // s
  constexpr double kFewest = 10.0;
  if (assurance) return static_cast<int>(std::ceil(3.0 / (1.0 - *assurance) - 1e-6));
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
  std::uint64_t hash = 0xCBF29CE484222325u;  // FNV-1a
  for (const char c : question) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return pgd::Random(hash).bits();
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
  const TomlTable root = TomlTable::parse(text, name);
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
  return parse_plan(io::read_text_file(path), path.string(), {}, body_reader);
}

}  // namespace samara::codebooks
