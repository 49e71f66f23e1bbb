#include "models/model_with_series.h"

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/identification/series/coefficient_series.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/models/interface/following_model.h"

namespace samara::apps {

void ModelWithSeries::check_time(double end) const {
  const codebooks::Coordinate& t = book->coordinates().front();
  const double rounding = 1e-9 * (t.upper - t.lower);  // differences of measured times end a little off
  if (t.lower <= rounding && end <= t.upper + rounding) return;
  throw OutsideBoxError(fmt::format(
      "the series of coefficients goes from {} to {} {}, and the simulation from 0 to {}; --until "
      "within the series was expected",
      t.lower, t.upper, t.unit, end));
}

ModelWithSeries model_with_series(const std::string& file, const std::shared_ptr<const models::Model>& model,
                                  const std::map<std::string, double>& set) {
  ModelWithSeries steered{
      .book = std::make_unique<codebooks::Codebook>(codebooks::load(file)), .model = nullptr, .values = set};
  for (const pgd::OutputLabel& output : steered.book->outputs()) {
    if (!set.contains(output.name)) continue;
    throw ArgumentError(fmt::format("--set names \"{}\", which follows \"{}\"; one of the two was expected",
                                    output.name, file));
  }
  try {
    steered.model = models::following(model, identification::codebook_course(*steered.book, model->info()));
  } catch (const ArgumentError& error) {
    throw InputError(file, error.what());
  }
  steered.values.insert(steered.book->model().fixed.begin(), steered.book->model().fixed.end());
  return steered;
}

}  // namespace samara::apps
