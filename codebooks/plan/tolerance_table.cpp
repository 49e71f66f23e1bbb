#include "samara/codebooks/plan/tolerance_table.h"

#include <fmt/format.h>

#include "samara/codebooks/model/model_file.h"

namespace samara::codebooks {

using io::TomlTable;

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

std::string tolerance_text(const BuildRequest& request) {
  std::string text = fmt::format("[tolerance]\nrelative = {}\n", request.relative);
  if (request.assurance) text += fmt::format("assurance = {}\n", *request.assurance);
  if (!request.absolute.empty()) text += "[tolerance.absolute]\n";
  for (const auto& [name, value] : request.absolute)
    text += fmt::format("{} = {}\n", quoted_toml(name), value);
  return text;
}

}  // namespace samara::codebooks
