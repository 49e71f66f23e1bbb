#pragma once

#include <cmath>

#include "samara/models/batch/law_kernel.h"

/// Sine and cosine that do not depend on what else is in a pack. The library's reduce all lanes by the largest of
/// their angles, which changes last digits: of no matter where trajectories are compared to a tolerance, but a
/// realisation is to have the same bits in any company.
namespace samara::models {

template <class S>
struct SineCosine {
  S sine, cosine;
};

inline SineCosine<double> sine_and_cosine(double angle) {
  return {std::sin(angle), std::cos(angle)};
}

inline SineCosine<Pack> sine_and_cosine(const Pack& angle) {
  SineCosine<Pack> both;
  for (std::size_t lane = 0; lane < Pack::size(); ++lane) {
    const double one = angle[lane];
    both.sine[lane] = std::sin(one);
    both.cosine[lane] = std::cos(one);
  }
  return both;
}

template <class S, int K>
SineCosine<Dual<S, K>> sine_and_cosine(const Dual<S, K>& angle) {
  const SineCosine<S> values = sine_and_cosine(angle.a);
  SineCosine<Dual<S, K>> both = {angle, angle};
  both.sine.a = values.sine;
  both.cosine.a = values.cosine;
  for (std::size_t k = 0; k < angle.v.size(); ++k) {
    both.sine.v[k] = values.cosine * angle.v[k];
    both.cosine.v[k] = -values.sine * angle.v[k];
  }
  return both;
}

}  // namespace samara::models
