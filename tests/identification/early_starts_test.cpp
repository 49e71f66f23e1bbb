#include <algorithm>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/identification/files/fit_files.h"
#include "samara/identification/problem/segments.h"
#include "samara/models/equations/equation_model.h"
#include "synthetic.h"

using namespace samara;
using namespace samara::identification;

namespace {

/// Frames every 0.1 s.
std::vector<Capture> averaged_brakings() {
  const std::vector<double> times = even_times(21, 2.0);
  return {make_capture("a", times, BrakedFamily::depths(1.0, 1.0, times)),
          make_capture("b", times, BrakedFamily::depths(1.0, 1.5, times))};
}

/// Of the braked body, frames that are means of five.
Warnings warnings_with(const auto& change) {
  BrakedFamily family;
  FitOptions options;
  options.compared.averaged_frames = 5;
  change(family.mutable_info(), options);
  return warnings_of_early_starts(family.info(), averaged_brakings(), options);
}

}  // namespace

TEST_CASE("an initial value of which something is known is named where frames are means of several") {
  const std::string kWhen = ": since frames are means of 5, it is taken for the value 0.2 s before the first";
  CHECK(warnings_with([](models::FamilyInfo&, FitOptions&) {}).empty());
  const Warnings fixed =
      warnings_with([](models::FamilyInfo&, FitOptions& options) { options.unknowns.fixed["v(0)"] = 1.5; });
  CHECK(fixed.size() == 1);
  CHECK(fixed.has(WarningKind::model, "v(0) is fixed at 1.5" + kWhen));
  CHECK(warnings_with([](models::FamilyInfo& family, FitOptions&) {
          family.fixed["w(0)"] = 0.0;
        }).has(WarningKind::model, "w(0) is fixed at 0" + kWhen));
  CHECK(warnings_with([](models::FamilyInfo&, FitOptions& options) {
          options.unknowns.known["v(0)"] = "speed";
        }).has(WarningKind::model, "v(0) is known of each capture" + kWhen));
  CHECK(warnings_with([](models::FamilyInfo&, FitOptions& options) {
          options.unknowns.shared = {"k", "v(0)"};
        }).has(WarningKind::model, "v(0) is one for all captures" + kWhen));
  CHECK(warnings_with([](models::FamilyInfo&, FitOptions& options) {
          options.priors.coordinates["v(0)"] = {.mean = 1.0, .deviation = 0.1};
        }).has(WarningKind::model, "v(0) has a prior" + kWhen));
}

TEST_CASE(
    "an initial value that offsets take up, or that says nothing of the motion, may belong to any time") {
  CHECK(warnings_with([](models::FamilyInfo& family, FitOptions&) { family.fixed["x(0)"] = 0.0; }).empty());
  CHECK(warnings_with([](models::FamilyInfo& family, FitOptions& options) {
          family.fixed["x(0)"] = 0.0;
          options.unknowns.offsets = std::vector<std::string>{};
        }).size() == 1);
  CHECK(warnings_with([](models::FamilyInfo& family, FitOptions& options) {
          family.outputs.push_back({"w", "rad/s"});
          family.fixed["w(0)"] = 0.0;
          options.starts.round_body = true;
        }).empty());
  CHECK(warnings_with([](models::FamilyInfo&, FitOptions& options) {
          options.unknowns.fixed["v(0)"] = 1.5;
          options.compared.averaged_frames = 1;
        }).empty());
}

TEST_CASE("an initial value before the first frame is warned of in every fit, and before a fit of files") {
  const auto model =
      models::equation_model({.name = "braked",
                              .states = {{.name = "x", .unit = "m"}, {.name = "v", .unit = "m/s"}},
                              .parameters = {{.name = "k", .unit = "1/s"}},
                              .rates = {"v", "-k*v"}});
  const std::string kWarning =
      "x(0) is fixed at 0: since frames are means of 3, it is taken for the value 0.1 s before the first "
      "frame";
  std::vector<std::string> told;
  bool is_told_before = false;
  const FitReport report =
      fit_files({.model = model,
                 .measured = averaged_brakings(),
                 .config_text = "averaged_frames = 3\n"
                                "offsets = []\n"
                                "outputs = [\"x\"]\n"
                                "starts = 1\n"
                                "[fixed]\n"
                                "\"x(0)\" = 0.0\n"
                                "[box]\n"
                                "k = [0.2, 5.0]\n"
                                "\"v(0)\" = [0.2, 3.0]\n",
                 .progress =
                     [&](const Progress&) {
                       is_told_before = std::ranges::count(told, kWarning) == 1;
                       return true;
                     },
                 .warning = [&](const std::string& sentence) { told.push_back(sentence); }});
  CAPTURE(text_of(report.fit.warnings));
  CHECK(is_told_before);
  CHECK(report.fit.warnings.has(WarningKind::model, kWarning));

  BrakedFamily family;
  FitOptions options;
  options.compared.averaged_frames = 3;
  options.compared.outputs = {"x"};
  options.unknowns.offsets = std::vector<std::string>{};
  family.mutable_info().fixed["x(0)"] = 0.0;
  CHECK(fit(family, averaged_brakings(), options).warnings.has(WarningKind::model, kWarning));
}
