#include <fmt/format.h>

#include "commands.h"
#include "output.h"
#include "samara/base/errors.h"
#include "samara/codebooks/certify.h"
#include "samara/codebooks/store.h"
#include "terminal.h"

namespace samara::apps {

int run(const ValidateArguments& arguments) {
  const codebooks::Codebook book = codebooks::load(arguments.book);
  codebooks::CertifyOptions options;
  options.points = arguments.points;
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
  const models::ParametricModel model = [&] {
    try {
      return codebooks::model_of(book);
    } catch (const ArgumentError& error) {
      throw InputError(arguments.book, error.what());
    }
  }();
  codebooks::Certificate certificate = codebooks::certify(book, model, options);
  if (book.certificate()) {
    certificate.residual = book.certificate()->residual;
    certificate.spent = book.certificate()->spent;
  }
  clear_progress();
  if (certificate.norm_defect && certificate.norm_defect->max > options.tolerance && book.certificate()) {
    warn(fmt::format("{} stores quaternions whose norm is off by {:.3g}, more than its tolerance {:.3g}",
                     arguments.book, certificate.norm_defect->max, options.tolerance));
  }
  if (arguments.json) {
    Json object = {{"schema", "samara-validate/1"}};
    object["certificate"] = to_json(certificate, book);
    print(object);
  } else {
    print(to_table(certificate, book));
  }
  return certificate.met ? kDone : kToleranceMissed;
}

}  // namespace samara::apps
