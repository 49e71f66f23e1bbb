#include "samara/identification/statistics/quantiles.h"

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>

// The one source of this room and of those below it that reads these headers: each takes seconds to compile.
namespace samara::identification {

double normal_quantile(double share) {
  return quantile(boost::math::normal(), share);
}

double student_quantile(double freedom, double share) {
  return quantile(boost::math::students_t(freedom), share);
}

double chi_squared_quantile(double freedom, double share) {
  return quantile(boost::math::chi_squared(freedom), share);
}

double fisher_quantile(double above, double below, double share) {
  return quantile(boost::math::fisher_f(above, below), share);
}

double beta_quantile(double a, double b, double share) {
  return boost::math::ibeta_inv(a, b, share);
}

double chi_squared_tail(double freedom, double value) {
  return cdf(complement(boost::math::chi_squared(freedom), value));
}

double binomial_tail(int trials, double chance, int count) {
  return cdf(complement(boost::math::binomial(trials, chance), count));
}

}  // namespace samara::identification
