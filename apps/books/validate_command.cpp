#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/bodies.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/codebooks/certify/builder_end.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/certify/certify_plan.h"
#include "samara/codebooks/fields/ready_field.h"
#include "samara/codebooks/file/load.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

struct ValidateArguments {
  std::string book;
  std::string plan;  ///< whose command is called; empty: the codebook is one of a model
  std::optional<int> points;
  std::uint64_t seed = 1;
  std::string output;
  bool json = false;
};

/// Errors of arguments are those of the file.
template <class Make>
auto blaming(const std::string& file, const Make& make) {
  try {
    return make();
  } catch (const ArgumentError& error) {
    throw InputError(file, error.what());
  }
}

/// The program of a codebook of a command comes from the user's plan, never from the codebook.
codebooks::Certificate certify_by_plan(const codebooks::Codebook& book, const ValidateArguments& arguments,
                                       codebooks::CertifyOptions options) {
  const codebooks::Plan plan = codebooks::read_plan(arguments.plan, parameters_of);
  if (plan.command && !arguments.points) options.points = plan.certificate_points();
  return blaming(arguments.plan, [&] { return codebooks::certify(book, plan, options); });
}

codebooks::Certificate certify_by_model(const codebooks::Codebook& book, const ValidateArguments& arguments,
                                        const codebooks::CertifyOptions& options) {
  if (book.space()) {
    const auto reference = blaming(arguments.book, [&] { return codebooks::exact_reference(book); });
    return codebooks::certify(book, reference, options);
  }
  const models::ParametricModel model = blaming(arguments.book, [&] { return codebooks::model_of(book); });
  return codebooks::certify(book, model, options);
}

void check_plan(const codebooks::Codebook& book, const ValidateArguments& arguments) {
  if (book.is_of_command() && arguments.plan.empty()) {
    throw ArgumentError(fmt::format(
        "{} was sampled from a command, and no program that stands in a codebook is executed: name "
        "the plan whose command is to be called, --plan PLAN.toml",
        arguments.book));
  }
  if (!book.is_of_command() && !arguments.plan.empty()) {
    throw ArgumentError(fmt::format("{} is a solution of the model {}, which needs no --plan", arguments.book,
                                    book.model().name));
  }
}

int run_validate(const ValidateArguments& arguments) {
  if (!arguments.output.empty())
    check_text_output(arguments.output, {arguments.book, arguments.plan}, arguments.json ? ".json" : ".txt");
  const codebooks::Codebook book = codebooks::load(arguments.book);
  check_plan(book, arguments);
  codebooks::CertifyOptions options;
  options.points = arguments.points.value_or(options.points);
  options.seed = arguments.seed;
  options.progress = progress_line();
  if (book.certificate()) {
    options.tolerance = book.certificate()->tolerance;
    // The range of an output counts at least as much as it did at the build: there the absolute tolerances
    // entered.
    for (const codebooks::OutputError& o : book.certificate()->outputs) options.absolute[o.name] = o.range;
  } else {
    warn(fmt::format("{} has no certificate: errors are compared with zero", arguments.book));
  }
  codebooks::Certificate certificate = book.is_of_command() ? certify_by_plan(book, arguments, options)
                                                            : certify_by_model(book, arguments, options);
  if (book.certificate()) {
    certificate.residual = book.certificate()->residual;
    certificate.spent = book.certificate()->spent;
    certificate.met = certificate.met &&
                      codebooks::is_left_to_certificate(book.build(), certificate.spent, options.tolerance);
  }
  clear_progress();
  if (certificate.norm_defect && certificate.norm_defect->max > options.tolerance && book.certificate()) {
    warn(fmt::format("{} stores quaternions whose norm is off by {:.3g}, more than its tolerance {:.3g}",
                     arguments.book, certificate.norm_defect->max, options.tolerance));
  }
  Json object = {{"schema", "samara-validate/1"}};
  object["certificate"] = to_json(certificate, book);
  if (arguments.json)
    write_answer(arguments.output, json_line(object));
  else
    write_readable(arguments.output, to_table(certificate, book));
  return certificate.met ? kDone : kToleranceMissed;
}

}  // namespace

void add_validate(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<ValidateArguments>();
  CLI::App* command = app.add_subcommand("validate", "certifies a codebook again, on fresh points");
  command->add_option("BOOK", values->book, "codebook file")->required();
  command->add_option("--plan", values->plan,
                      "of a codebook of a command: the plan whose command is called; none that stands in a "
                      "codebook is ever executed");
  command
      ->add_option("--points", values->points,
                   "scrambled Sobol' points in the box; default: 2000, of a command what its plan says")
      ->check(whole_number())
      ->check(CLI::Range(1, 100000000));
  command->add_option("--seed", values->seed, "of the scrambling, from 0")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_validate);
}

}  // namespace samara::apps
