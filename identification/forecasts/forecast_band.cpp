#include "samara/identification/forecasts/forecast_band.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "samara/base/require.h"

namespace samara::identification {

double mixture_quantile(const Eigen::VectorXd& weights, const Eigen::VectorXd& means,
                        const Eigen::VectorXd& deviations, double probability) {
  constexpr double kFarthest = 12.0;  // deviations: beyond is nothing
  double lower = (means - kFarthest * deviations).minCoeff();
  double upper = (means + kFarthest * deviations).maxCoeff();
  const double total = weights.sum();
  const auto below = [&](double value) {
    double sum = 0.0;
    for (Eigen::Index k = 0; k < weights.size(); ++k)
      sum += 0.5 * weights[k] * std::erfc((means[k] - value) / (deviations[k] * std::numbers::sqrt2));
    return sum / total;
  };
  for (int step = 0; step < 80; ++step) {
    const double middle = 0.5 * (lower + upper);
    (below(middle) < probability ? lower : upper) = middle;
  }
  return 0.5 * (lower + upper);
}

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
        if (!std::isfinite(component.mean(row, o)) || !(variance > 0.0)) continue;
        weights[count] = component.weight;
        means[count] = component.mean(row, o);
        deviations[count++] = std::sqrt(variance);
      }
      if (count == 0 || !(weights.head(count).sum() > 0.0)) continue;
      const Eigen::VectorXd w = weights.head(count), m = means.head(count), d = deviations.head(count);
      band.mean(row, o) = w.dot(m) / w.sum();
      band.lower(row, o) = mixture_quantile(w, m, d, 0.5 * (1.0 - probability));
      band.upper(row, o) = mixture_quantile(w, m, d, 0.5 * (1.0 + probability));
    }
  }
  return band;
}

}  // namespace samara::identification
