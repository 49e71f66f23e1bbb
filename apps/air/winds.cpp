#include "air/winds.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/model/wind_file.h"
#include "samara/models/laws/ambient_flow.h"
#include "samara/models/wind/body_outline.h"
#include "terminal/terminal.h"

namespace samara::apps {

ModelInWind model_in_wind(const std::string& file, std::uint64_t seed,
                          const std::shared_ptr<const models::Model>& model,
                          const std::map<std::string, double>& values) {
  const std::string& name = model->info().name;
  if (name != "immersed_body") {
    throw ArgumentError(fmt::format(
        "--wind is for the model \"immersed_body\", or with --realisations for those in gusts; not "
        "for \"{}\"",
        name));
  }
  const models::wind::BodyOutline body =
      models::wind::outline_of(models::ParametricModel(model, values, {}), {});
  const codebooks::WindFile wind = codebooks::read_wind(file);
  if (wind.seen)
    throw InputError(
        file, "has turbulence of the kind \"seen\", which is along paths: --realisations was expected");
  return {.model = models::immersed_body_in(models::wind::wind_flow(wind.wind, body.length, seed, 0)),
          .shortest_gust = shortest_gust(wind.wind),
          .has_turbulence = wind.wind.turbulence.has_value()};
}

double shortest_gust(const models::wind::Wind& wind) {
  double least = std::numeric_limits<double>::infinity();
  for (const models::wind::Gust& gust : wind.gusts) least = std::min(least, gust.duration());
  return least;
}

void warn_of_gusts(double shortest, double step) {
  if (10.0 * step > shortest)
    warn(fmt::format("a gust lasts {:.3g} s and steps are of {:.3g} s; --step {:.2g} would follow it",
                     shortest, step, 0.1 * shortest));
}

}  // namespace samara::apps
