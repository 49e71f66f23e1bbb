#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

/// Whether residuals look like independent noise.
///
/// Where they do not, something is left in them that the model lacks, or the tracking adds: errors that take
/// frames as independent are then too small, by about sqrt((1 + r)/(1 - r)) at a lag-1 autocorrelation r.
///
/// Frames are put on a grid of the median interval; missing frames are gaps, over which no pair reaches. With
/// m_k pairs of frames k apart, n residuals e,
///
///     r_k = (1/m_k sum e_i e_(i+k))/(1/n sum e_i^2),   Q = (n + 2)/n sum_(k=1..K) m_k r_k^2,
///
/// which is Ljung and Box's statistic (Biometrika 65 (1978) 297) if nothing is missing. For independent
/// residuals Q follows chi2 with K degrees of freedom, approximately from 20 residuals or so. The mean is not
/// taken off: residuals should scatter around zero. Residuals beyond three standard deviations (from the
/// median of their sizes) are pulled in to there, so that outliers do not hide the rest.
///
/// Unknowns fitted to a series leave its residuals slightly anticorrelated (r of about -p/n for p unknowns).
namespace samara::identification {

/// One output of one capture.
struct SeriesWhiteness {
  std::string capture = {};
  std::string output = {};
  int count = 0;           ///< residuals
  double lag1 = 0.0;       ///< autocorrelation of neighbouring frames; 0 if there are none
  int lags = 0;            ///< K
  double statistic = 0.0;  ///< Q
  /// How often independent residuals would have a larger Q. Empty for fewer than 8 residuals, or none that
  /// differ from zero.
  std::optional<double> p_value = {};
};

/// All series of a fit.
struct Whiteness {
  std::vector<SeriesWhiteness> series = {};
  int tested = 0;                      ///< series with a p-value
  int rejected = 0;                    ///< with one below 5 %
  double median_lag1 = 0.0;            ///< over tested series
  std::optional<double> p_value = {};  ///< of the sum of Q over all tested series
  std::string sentence = {};           ///< what to make of it
};

/// @param times s, not going back; one per residual
/// @param residuals NaN where missing
/// @param lags K; 0: a fifth of the residuals, at most 10
/// @throws ArgumentError for sizes that differ, times that go back, negative lags.
SeriesWhiteness series_whiteness(std::span<const double> times, std::span<const double> residuals,
                                 int lags = 0);

/// Pools series into one judgement.
Whiteness pool_whiteness(std::vector<SeriesWhiteness> series);

}  // namespace samara::identification
