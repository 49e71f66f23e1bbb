#pragma once

/// Quantiles and tails of the distributions that statements about fits and shares rest on.
namespace samara::identification {

/// @param share in (0, 1)
double normal_quantile(double share);
/// @param freedom degrees of freedom, above 0
double student_quantile(double freedom, double share);
double chi_squared_quantile(double freedom, double share);
/// Of Fisher's F with that many degrees of freedom above and below.
double fisher_quantile(double above, double below, double share);
/// Of the beta distribution of these two parameters, both above 0: of a chance after so many counts.
double beta_quantile(double a, double b, double share);

/// How likely a larger value is.
double chi_squared_tail(double freedom, double value);
/// How likely more than `count` of `trials` are, each with the same chance.
double binomial_tail(int trials, double chance, int count);

}  // namespace samara::identification
