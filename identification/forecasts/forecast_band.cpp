#include "samara/identification/forecasts/forecast_band.h"

#include <cmath>
#include <limits>

#include "samara/base/require.h"
#include "samara/identification/forecasts/proper_scores.h"

namespace samara::identification {

ForecastBand band_of(const Forecast& forecast, double probability) {
  require(probability > 0.0 && probability < 1.0, "probability", probability, "a number between 0 and 1",
          "band_of");
  const Eigen::Index rows = forecast.times.size(), columns = std::ssize(forecast.outputs);
  ForecastBand band;
  for (Eigen::MatrixXd* table : {&band.mean, &band.lower, &band.upper})
    table->setConstant(rows, columns, std::numeric_limits<double>::quiet_NaN());
  const Eigen::Index most = std::ssize(forecast.components);
  for (Eigen::Index row = 0; row < rows; ++row) {
    for (Eigen::Index o = 0; o < columns; ++o) {
      Eigen::VectorXd weights(most), means(most), deviations(most);
      Eigen::Index count = 0;
      for (const ForecastComponent& component : forecast.components) {
        const double variance = component.covariance[static_cast<std::size_t>(row)](o, o);
        if (!std::isfinite(component.mean(row, o)) || !std::isfinite(variance) || variance < 0.0) continue;
        weights[count] = component.weight;
        means[count] = component.mean(row, o);
        deviations[count++] = std::sqrt(variance);
      }
      if (count == 0 || !(weights.head(count).sum() > 0.0)) continue;
      const NormalMixture mixture = {weights.head(count) / weights.head(count).sum(), means.head(count),
                                     deviations.head(count)};
      band.mean(row, o) = mixture.weights.dot(mixture.means);
      band.lower(row, o) = quantile(mixture, 0.5 * (1.0 - probability));
      band.upper(row, o) = quantile(mixture, 0.5 * (1.0 + probability));
    }
  }
  return band;
}

}  // namespace samara::identification
