#include <cmath>
#include <memory>
#include <sstream>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "files.h"
#include "samara/base/streams.h"
#include "samara/identification/files/fit_files.h"
#include "samara/identification/petab/petab_result.h"
#include "samara/io/delimited_table.h"

using namespace samara::identification;
using Catch::Contains;

namespace {

constexpr double kDecayRate = 0.8;

/// v' = -rate v: v = v(0) exp(-rate t).
struct DecayProblem {
  TemporaryDirectory files;
  std::string model;
  std::string parameters =
      "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\n"
      "rate\tlog10\t0.1\t5\t1\t1\n";
  std::string observables = "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\t0.01\n";
  std::string conditions = "conditionId\tv\nslow\t2\nfast\t5\n";
  std::string measurements;

  DecayProblem() {
    model = files
                .put("decay.toml",
                     "name = \"decay\"\n[states]\nv = { initial = 2, unit = \"m/s\" }\n[parameters]\nrate = "
                     "{ unit = "
                     "\"1/s\", above = 0 }\n[rates]\nv = \"-rate*v\"\n")
                .string();
    measurements = rows({{"slow", 2.0}, {"fast", 5.0}}, 0.0);
  }

  /// Twelve frames of each condition; the first not at 0, where the motion begins.
  static std::string rows(const std::vector<std::pair<std::string, double>>& starts, double noise,
                          const std::string& more = "", const std::string& heading = "") {
    samara::Stream stream(7, 0);
    std::string text = "observableId\tsimulationConditionId\tmeasurement\ttime" + heading + "\n";
    for (const auto& [condition, start] : starts) {
      for (int k = 1; k <= 12; ++k)
        text +=
            fmt::format("speed\t{}\t{}\t{}{}\n", condition,
                        start * std::exp(-kDecayRate * 0.15 * k) + noise * stream.normal(), 0.15 * k, more);
    }
    return text;
  }

  FitRequest request() const {
    files.put("parameters.tsv", parameters);
    files.put("observables.tsv", observables);
    files.put("conditions.tsv", conditions);
    files.put("measurements.tsv", measurements);
    const auto file = files.put("problem.yaml",
                                "# a problem\nformat_version: 1\nparameter_file: "
                                "\"parameters.tsv\"\nproblems:\n- condition_files:\n  - "
                                "conditions.tsv\n  measurement_files: [measurements.tsv]\n  "
                                "observable_files:\n    - observables.tsv\n  "
                                "sbml_files:\n  - none.xml\n");
    return {.source = model, .captures = {file}};
  }
  FitReport fit() const { return fit_files(request()); }
  std::string complaint() const {
    return error_of<samara::InputError>([&] { fit(); });
  }
};

double found(const FitReport& report, const std::string& name) {
  for (const Coefficient& c : report.fit.coefficients)
    if (c.name == name) return c.value;
  FAIL("no coefficient " << name);
  return 0.0;
}

/// Nominal values that were written, by parameter.
std::map<std::string, std::string> nominal(const FitReport& report) {
  const auto table =
      samara::io::DelimitedTable::parse(report.petab_parameters, "written", {.delimiter = '\t'});
  std::map<std::string, std::string> values;
  for (std::size_t row = 0; row < table.rows(); ++row)
    values[table.texts("parameterId")[row]] = table.texts("nominalValue")[row];
  return values;
}

}  // namespace

TEST_CASE("a PEtab problem is fitted, its conditions known, and the tables come back with what was found") {
  const DecayProblem problem;
  const FitReport report = problem.fit();
  REQUIRE(report.is_usable);
  // Exact data: what is left is the integrator's.
  CHECK(found(report, "rate") == Approx(kDecayRate).epsilon(1e-6));
  REQUIRE(report.fit.captures.size() == 2);
  CHECK(std::stod(nominal(report).at("rate")) == found(report, "rate"));
  const auto table =
      samara::io::DelimitedTable::parse(report.petab_simulations, "written", {.delimiter = '\t'});
  REQUIRE(table.rows() == 24);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto at = static_cast<Eigen::Index>(row);
    const double start = table.texts("simulationConditionId")[row] == "slow" ? 2.0 : 5.0;
    CHECK(table.texts("observableId")[row] == "speed");
    CHECK(table.numbers("simulation")[at] ==
          Approx(start * std::exp(-kDecayRate * table.numbers("time")[at])).epsilon(1e-5));
  }
}

TEST_CASE(
    "the turns of an attitude, which are one residual of four observables, have no rows of simulations") {
  PetabProblem problem;
  problem.observables = {{"x", "place"}, {"qw", "q0"}};
  CaptureFit capture;
  capture.labels[kPetabCondition] = "drop";
  capture.residuals = {{"x", "m", 0.1}, {"attitude", "rad", 0.2}};
  capture.times.setConstant(1, 0.5);
  capture.measured.setConstant(1, 1, 2.0);
  capture.model.setConstant(1, 1, 3.0);
  FitResult fit;
  fit.captures = {capture};
  CHECK(petab_simulations(problem, fit) ==
        "observableId\tsimulationConditionId\ttime\tsimulation\nplace\tdrop\t0.5\t3\n");
}

TEST_CASE("the noise of an attitude in PEtab is that of its four numbers, and its turn has twice as much") {
  const TemporaryDirectory files;
  const std::string parts[] = {"qw", "qx", "qy", "qz"};
  std::string measurements = "observableId\tsimulationConditionId\tmeasurement\ttime\n";
  for (const double time : {0.0, 0.1, 0.2}) {
    for (const std::string& part : parts)
      measurements += fmt::format("{}_seen\tdrop\t{}\t{}\n", part, part == "qw" ? 1.0 : 0.0, time);
  }
  files.put("measurements.tsv", measurements);
  files.put("conditions.tsv", "conditionId\tconditionName\ndrop\tA\n");
  files.put("parameters.tsv",
            "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\n"
            "rate\tlin\t0.1\t5\t1\t1\n");
  const auto problem_with = [&](const std::string& noise_of_qz) {
    std::string observables = "observableId\tobservableFormula\tnoiseFormula\n";
    for (const std::string& part : parts)
      observables += fmt::format("{0}_seen\t{0}\t{1}\n", part, part == "qz" ? noise_of_qz : "0.01");
    files.put("observables.tsv", observables);
    const auto file = files.put("problem.yaml",
                                "format_version: 1\nparameter_file: parameters.tsv\nproblems:\n"
                                "- condition_files: [conditions.tsv]\n"
                                "  measurement_files: [measurements.tsv]\n"
                                "  observable_files: [observables.tsv]\n");
    ConfigNames names{.coordinates = {{"rate", "1/s"}}, .outputs = {}};
    for (const std::string& part : parts) names.outputs[part] = "1";
    const std::string config = read_petab(file, names).config;
    return parse_fit_config(config, "config", names);
  };
  CHECK(problem_with("0.01").loss.attitude_scale == Approx(0.02));
  CHECK(problem_with("0.01").loss.scales.empty());  // a fit refuses one of a single number
  CHECK_THAT(error_of<samara::InputError>([&] { problem_with("0.02"); }),
             Contains("observables.tsv:5") && Contains("one level of the four numbers of an attitude"));
}

TEST_CASE("conditions of a PEtab problem may have parameters of their own, and noise may be estimated") {
  DecayProblem problem;
  problem.parameters +=
      "v_slow\tlin\t0.5\t9\t3\t1\nv_fast\tlin\t0.5\t9\t3\t1\nsigma\tlog10\t1e-4\t1\t0.1\t1\n";
  problem.observables = "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\tsigma\n";
  problem.conditions = "conditionId\tconditionName\tv\nslow\tA\tv_slow\nfast\tB\tv_fast\n";
  problem.measurements = DecayProblem::rows({{"slow", 2.0}, {"fast", 5.0}}, 0.02);
  const FitReport report = problem.fit();
  REQUIRE(report.is_usable);
  const auto values = nominal(report);
  // 24 values with noise of 0.02: four standard errors.
  CHECK(found(report, "rate") == Approx(kDecayRate).margin(0.02));
  CHECK(std::stod(values.at("v_slow")) == Approx(2.0).margin(0.06));
  CHECK(std::stod(values.at("v_fast")) == Approx(5.0).margin(0.06));
  CHECK(std::stod(values.at("sigma")) == Approx(0.02).margin(0.013));
}

TEST_CASE("measurements of a condition may stand in several files of a PEtab problem, and are one capture") {
  DecayProblem problem;
  problem.parameters += "v_slow\tlin\t0.5\t9\t3\t1\nv_fast\tlin\t0.5\t9\t3\t1\n";
  problem.conditions = "conditionId\tv\nslow\tv_slow\nfast\tv_fast\n";
  problem.measurements = DecayProblem::rows({{"slow", 2.0}, {"fast", 5.0}}, 0.02);
  const FitReport one = problem.fit();
  const FitRequest request = problem.request();
  // Every second row in another file.
  std::string parts[2];
  std::istringstream lines(problem.measurements);
  std::string line;
  for (int k = 0; std::getline(lines, line); ++k) {
    for (int part = 0; part < 2; ++part)
      if (k == 0 || k % 2 == part) parts[part] += line + "\n";
  }
  problem.files.put("measurements.tsv", parts[0]);
  problem.files.put("more.tsv", parts[1]);
  problem.files.put(
      "problem.yaml",
      "format_version: 1\nparameter_file: parameters.tsv\nproblems:\n- condition_files: "
      "[conditions.tsv]\n  measurement_files: [measurements.tsv, more.tsv]\n  observable_files: "
      "[observables.tsv]\n");
  const FitReport two = fit_files(request);
  REQUIRE(two.fit.captures.size() == 2);
  CHECK(two.fit.clusters == one.fit.clusters);
  CHECK(found(two, "rate") == Approx(found(one, "rate")).epsilon(1e-6));
  CHECK(*two.fit.coefficients[0].standard_error ==
        Approx(*one.fit.coefficients[0].standard_error).epsilon(1e-4));
}

TEST_CASE("an angle of a PEtab problem is compared as it is, not around the circle") {
  const TemporaryDirectory files;
  const auto model = files.put("turn.toml",
                               "name = \"turn\"\n[states]\ntheta = { initial = 0, unit = \"rad\" }\n"
                               "[parameters]\nomega = { unit = \"rad/s\", above = 0 }\n[rates]\ntheta = "
                               "\"omega\"\n");
  // A whole turn more or less in each second: 7.5 - 2 pi would do as well around the circle.
  constexpr double kRate = 7.5;
  std::string measurements = "observableId\tsimulationConditionId\tmeasurement\ttime\n";
  for (int k = 1; k <= 8; ++k) measurements += fmt::format("angle\tonly\t{}\t{}\n", kRate * k, k);
  files.put("measurements.tsv", measurements);
  files.put("conditions.tsv", "conditionId\nonly\n");
  files.put("observables.tsv", "observableId\tobservableFormula\tnoiseFormula\nangle\ttheta\t0.05\n");
  files.put("parameters.tsv",
            "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\n"
            "omega\tlin\t0.1\t10\t1\t1\n");
  const auto problem =
      files.put("problem.yaml",
                "format_version: 1\nparameter_file: parameters.tsv\nproblems:\n- "
                "condition_files: [conditions.tsv]\n  measurement_files: [measurements.tsv]\n"
                "  observable_files: [observables.tsv]\n");
  CHECK(found(fit_files({.source = model.string(), .captures = {problem}}), "omega") ==
        Approx(kRate).epsilon(1e-6));
}

TEST_CASE("priors, parameters that are held and noise beside the measurements are taken from PEtab tables") {
  DecayProblem problem;
  problem.parameters =
      "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\tobjectivePriorType\t"
      "objectivePriorParameters\n"
      "rate\tlin\t0.1\t5\t1\t1\tnormal\t1.2;1e-6\nstart\tlin\t\t\t2\t0\t\t\n";
  problem.observables = "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\tnoiseParameter1_speed\n";
  problem.conditions = "conditionId\tv\nslow\tstart\n";
  problem.measurements = DecayProblem::rows({{"slow", 2.0}}, 0.0, "\t0.05", "\tnoiseParameters");
  // A prior so sharp that the data do not count.
  CHECK(found(problem.fit(), "rate") == Approx(1.2).epsilon(1e-4));
  // The same measurements once more are another replicate.
  const std::string again = DecayProblem::rows({{"slow", 2.0}}, 0.0, "\t0.05", "\tnoiseParameters");
  problem.measurements += again.substr(again.find('\n') + 1);
  CHECK(problem.fit().fit.captures.size() == 2);
}

TEST_CASE("uniform priors of a PEtab problem bound on every scale, and other counts of numbers are refused") {
  const auto with = [](const std::string& scale, const std::string& prior) {
    auto problem = std::make_unique<DecayProblem>();
    problem->parameters =
        "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\tobjectivePriorType\t"
        "objectivePriorParameters\nrate\t" +
        scale + "\t0.1\t5\t1\t1\t" + prior + "\n";
    return problem;
  };
  // The rate of the data, 0.8, lies below each of them.
  CHECK(found(with("log10", "uniform\t1.5;3")->fit(), "rate") == Approx(1.5).epsilon(1e-6));
  CHECK(found(with("lin", "parameterScaleUniform\t1.5;3")->fit(), "rate") == Approx(1.5).epsilon(1e-6));
  CHECK(found(with("log10", "parameterScaleUniform\t0.2;0.6")->fit(), "rate") ==
        Approx(std::pow(10.0, 0.2)).epsilon(1e-6));
  CHECK(found(with("log", "parameterScaleUniform\t0.25;1")->fit(), "rate") ==
        Approx(std::exp(0.25)).epsilon(1e-6));
  CHECK_THAT(with("log10", "uniform\t2;3;4")->complaint(),
             Contains("parameters.tsv:2") && Contains("are 3 numbers"));
  CHECK_THAT(with("lin", "uniform\t3;2")->complaint(), Contains("a lower and a higher one"));
  CHECK_THAT(with("lin", "\t2;3")->complaint(), Contains("without an objectivePriorType"));
  CHECK_THAT(with("lin", "uniform\t6;7")->complaint(), Contains("nothing in common"));
}

TEST_CASE("a logNormal prior is a density of the parameter, a parameterScaleNormal one of its logarithm") {
  const auto most_likely = [](const std::string& scale, const std::string& prior) {
    DecayProblem problem;
    problem.parameters =
        "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\tobjectivePriorType\t"
        "objectivePriorParameters\nrate\t" +
        scale + "\t0.1\t5\t1\t1\t" + prior + "\n";
    // So noisy that the prior alone counts.
    problem.observables = "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\t1e4\n";
    const FitReport report = problem.fit();
    CHECK_THAT(report.petab_parameters, Contains("\t" + prior + "\t"));
    return found(report, "rate");
  };
  // d/dx of (ln x - m)^2/(2 s^2) + ln x is 0 at exp(m - s^2), on whatever scale x is looked for.
  for (const char* scale : {"lin", "log", "log10"})
    CHECK(most_likely(scale, "logNormal\t0.5;0.6") == Approx(std::exp(0.5 - 0.36)).epsilon(1e-4));
  CHECK(most_likely("log", "parameterScaleNormal\t0.5;0.6") == Approx(std::exp(0.5)).epsilon(1e-4));
  CHECK(most_likely("log10", "parameterScaleNormal\t0.5;0.6") == Approx(std::pow(10.0, 0.5)).epsilon(1e-4));
  CHECK(most_likely("lin", "parameterScaleNormal\t0.5;0.6") == Approx(0.5).epsilon(1e-4));
}

TEST_CASE("measurements of a PEtab problem with NaN or NA count as not seen, and a note counts them") {
  DecayProblem problem;
  problem.measurements +=
      "speed\tslow\tNaN\t1.85\nspeed\tslow\tNA\t1.9\nspeed\tslow\t\t1.95\nspeed\tfast\t\t1.85\n";
  const FitReport report = problem.fit();
  REQUIRE(report.fit.captures.size() == 2);
  CHECK(report.fit.captures[0].frames == 12);
  CHECK(report.fit.captures[0].notes == std::vector<std::string>{"2 cells with NaN or NA count as not seen"});
  CHECK(report.fit.captures[1].notes.empty());
}

TEST_CASE("the parameters that a PEtab fit writes are the rows it read, and say the same again") {
  DecayProblem problem;
  problem.parameters =
      "parameterId\tparameterName\tparameterScale\tlowerBound\tupperBound\testimate\tobjectivePriorType\t"
      "objectivePriorParameters\tgroup\n"
      "rate\t\"the \"\"rate\"\"\"\tlin\t0.1\t5.0\t1\tnormal\t1.2;1e-6\tdecay\n";
  const std::string written = problem.fit().petab_parameters;
  CHECK_THAT(written, Catch::StartsWith("parameterId\tparameterName\tparameterScale\tlowerBound\tupperBound\t"
                                        "estimate\tobjectivePriorType\tobjectivePriorParameters\tgroup\t"
                                        "nominalValue\tstandardError\n") &&
                          Contains("\t0.1\t5.0\t1\tnormal\t1.2;1e-6\tdecay\t1."));
  problem.parameters = written;
  const FitReport again = problem.fit();
  CHECK(found(again, "rate") == Approx(1.2).epsilon(1e-4));
  CHECK(again.petab_parameters.substr(0, written.size() / 2) == written.substr(0, written.size() / 2));
}

TEST_CASE("a noise level of a PEtab problem has no prior, and a warning where it leaves its bounds") {
  DecayProblem problem;
  const std::string head = problem.parameters.substr(0, problem.parameters.find('\n'));
  const auto with = [&](const std::string& sigma) {
    auto other = std::make_unique<DecayProblem>();
    other->parameters =
        head + "\tobjectivePriorType\tobjectivePriorParameters\nrate\tlin\t0.1\t5\t1\t1\t\t\n" + sigma;
    other->observables = "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\tsigma\n";
    other->measurements = DecayProblem::rows({{"slow", 2.0}, {"fast", 5.0}}, 0.02);
    return other;
  };
  CHECK_THAT(with("sigma\tlin\t0.5\t1\t0.6\t1\tnormal\t0.6;0.001\n")->complaint(),
             Contains("parameters.tsv:3") && Contains("\"sigma\" is a noise level"));
  const auto bounded = with("sigma\tlin\t0.5\t1\t0.6\t1\t\t\n");
  const FitReport report = bounded->fit();
  CHECK(report.fit.warnings.has(WarningKind::noise, "outside its bounds of 0.5 to 1"));
  CHECK(nominal(report).at("sigma") == "0.5");
  bounded->parameters = report.petab_parameters;
  CHECK(bounded->fit().is_usable);
}

TEST_CASE("what a PEtab problem says and a fit does not know is refused with its file and line") {
  DecayProblem problem;
  const auto with = [&](std::string DecayProblem::*table, const std::string& text) {
    DecayProblem other;
    other.*table = text;
    return other.complaint();
  };
  const std::string head = "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\n";
  CHECK_THAT(with(&DecayProblem::parameters, head + "rat\tlin\t0.1\t5\t1\t1\n"),
             Contains("parameters.tsv:2") && Contains("\"rat\"") && Contains("rate"));
  CHECK_THAT(with(&DecayProblem::parameters, head + "rate\tlin\t5\t0.1\t1\t1\n"), Contains("lower < upper"));
  CHECK_THAT(with(&DecayProblem::parameters, head + "rate\tlin\t0.1\t5\t\t0\n"), Contains("no nominalValue"));
  CHECK_THAT(with(&DecayProblem::parameters, head + "rate\tlin\t0.1\t5\t1\tyes\n"), Contains("0 or 1"));
  for (const char* row : {"rate\tlin\t0.1\t1e300\t1\t1\n", "rate\tlin\t1e-300\t5\t1\t1\n"})
    CHECK_THAT(
        with(&DecayProblem::parameters, head + row),
        Contains("parameters.tsv:2") && Contains("a number of 1e-60 to 1e+60 in size, or 0, was expected"));
  const std::string prior =
      "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\tobjectivePriorType\t"
      "objectivePriorParameters\nrate\tlog10\t0.1\t5\t1\t1\tparameterScaleNormal\t";
  CHECK_THAT(with(&DecayProblem::parameters, prior + "1e300;1\n"),
             Contains("one of objectivePriorParameters"));
  CHECK_THAT(with(&DecayProblem::parameters, prior + "1000;1\n"),
             Contains("the prior is highest at exp(2302.59); exp(-138) to exp(138) was expected"));
  CHECK_THAT(with(&DecayProblem::conditions, "conditionId\tv\nslow\t2\nfast\t1e300\n"),
             Contains("conditions.tsv:3") && Contains("v(0) is 1e+300"));
  const std::string seen = "observableId\tsimulationConditionId\tmeasurement\ttime\n";
  CHECK_THAT(with(&DecayProblem::measurements, seen + "speed\tslow\t1e300\t1\n"),
             Contains("measurements.tsv:2") && Contains("the measurement is 1e+300"));
  CHECK_THAT(with(&DecayProblem::measurements, seen + "speed\tslow\t1\t1e300\n"),
             Contains("the time is 1e+300; 0 to 1e+60 was expected"));
  const std::string observed = "observableId\tobservableFormula\tnoiseFormula\n";
  CHECK_THAT(with(&DecayProblem::observables, observed + "speed\tv\t1e300\n"),
             Contains("the noise of \"speed\" is 1e+300"));
  CHECK_THAT(with(&DecayProblem::observables, observed + "speed\t2*v\t0.1\n"),
             Contains("observables.tsv:2") && Contains("one output"));
  CHECK_THAT(with(&DecayProblem::observables, observed + "speed\tv\t0.1*v\n"),
             Contains("a number or a parameter"));
  CHECK_THAT(
      with(&DecayProblem::observables,
           "observableId\tobservableFormula\tnoiseFormula\tobservableTransformation\nspeed\tv\t0.1\tlog\n"),
      Contains("observableTransformation is \"log\""));
  CHECK_THAT(with(&DecayProblem::conditions, "conditionId\tv\nslow\t2\n"), Contains("no condition \"fast\""));
  CHECK_THAT(with(&DecayProblem::conditions, "conditionId\tw\nslow\t2\nfast\t2\n"),
             Contains("none of its states"));
  CHECK_THAT(with(&DecayProblem::conditions, "conditionId\tv\nslow\t2\nfast\n"), Contains("cells"));
  const std::string measured =
      "observableId\tsimulationConditionId\tmeasurement\ttime\tpreequilibrationConditionId\n";
  CHECK_THAT(with(&DecayProblem::measurements, measured + "speed\tslow\t1\t0.5\tfast\n"),
             Contains("preequilibration"));
  CHECK_THAT(with(&DecayProblem::measurements, measured + "speed\tslow\t1\tinf\t\n"),
             Contains("finite number"));
  CHECK_THAT(with(&DecayProblem::measurements, measured + "speeds\tslow\t1\t1\t\n"),
             Contains("no observable \"speeds\""));

  const auto file_error = [&](const std::string& text) {
    FitRequest request = problem.request();
    problem.files.put("problem.yaml", text);
    return error_of<samara::InputError>([&] { fit_files(request); });
  };
  CHECK_THAT(file_error("format_version: 2\n"), Contains("format_version is \"2\""));
  CHECK_THAT(file_error("format_version: 1\nparameter_file: p.tsv\n"),
             Contains("condition_files is missing"));
  CHECK_THAT(file_error("format_version: 1\nparamter_file: p.tsv\n"),
             Contains("problem.yaml:2") && Contains("parameter_file"));
  CHECK_THAT(file_error("format_version: 1\nnonsense\n"), Contains("problem.yaml:2"));
  FitRequest both = problem.request();
  both.config_text = "starts = 2";
  CHECK_THROWS_WITH(fit_files(both), Contains("no --config"));
}
