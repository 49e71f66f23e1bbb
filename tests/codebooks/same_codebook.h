#pragma once

#include <algorithm>
#include <cstring>

#include <catch2/catch.hpp>

#include "samara/codebooks/book/codebook.h"

/// Checks that two codebooks are the same to the last bit and letter.

inline bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

inline bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         (a.size() == 0 ||
          std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0);
}

inline void check_same_axis(const samara::pgd::Axis& a, const samara::pgd::Axis& b) {
  CHECK(a.name() == b.name());
  CHECK(a.unit() == b.unit());
  CHECK(a.role() == b.role());
  CHECK(a.basis() == b.basis());
  CHECK(a.transform() == b.transform());
  REQUIRE(a.has_elements() == b.has_elements());
  if (a.has_elements()) CHECK(a.degree() == b.degree());
  CHECK(same_bits(a.borders(), b.borders()));
  CHECK(same_bits(a.nodes(), b.nodes()));
}

inline void check_same_field(const samara::pgd::SeparatedField& a, const samara::pgd::SeparatedField& b) {
  REQUIRE(a.axis_count() == b.axis_count());
  REQUIRE(a.output_count() == b.output_count());
  for (std::size_t k = 0; k < a.axes().size(); ++k) {
    check_same_axis(a.axes()[k], b.axes()[k]);
    CHECK(same_bits(a.factors()[k], b.factors()[k]));
  }
  for (std::size_t o = 0; o < a.outputs().size(); ++o) {
    CHECK(a.outputs()[o].name == b.outputs()[o].name);
    CHECK(a.outputs()[o].unit == b.outputs()[o].unit);
  }
  CHECK(same_bits(a.weights(), b.weights()));
}

inline void check_same_field(const samara::pgd::TrainField& a, const samara::pgd::TrainField& b) {
  REQUIRE(a.axis_count() == b.axis_count());
  REQUIRE(a.output_count() == b.output_count());
  for (std::size_t k = 0; k < a.axes().size(); ++k) check_same_axis(a.axes()[k], b.axes()[k]);
  for (std::size_t o = 0; o < a.outputs().size(); ++o) {
    CHECK(a.outputs()[o].name == b.outputs()[o].name);
    CHECK(a.outputs()[o].unit == b.outputs()[o].unit);
  }
  for (std::size_t k = 0; k < a.train().cores.size(); ++k) {
    CHECK(a.train().cores[k].left == b.train().cores[k].left);
    CHECK(a.train().cores[k].size == b.train().cores[k].size);
    CHECK(same_bits(a.train().cores[k].data, b.train().cores[k].data));
  }
}

inline void check_same_group(const samara::codebooks::FieldGroup& a, const samara::codebooks::FieldGroup& b) {
  REQUIRE((a.train() == nullptr) == (b.train() == nullptr));
  if (a.train() != nullptr) {
    check_same_field(*a.train(), *b.train());
  } else {
    check_same_field(*a.sum(), *b.sum());
  }
}

inline void check_same_certificate(const samara::codebooks::Certificate& a,
                                   const samara::codebooks::Certificate& b) {
  CHECK(same_bits(a.tolerance, b.tolerance));
  CHECK(a.met == b.met);
  CHECK(same_bits(a.max_error, b.max_error));
  CHECK(a.points == b.points);
  CHECK(a.times == b.times);
  CHECK(a.failed_points == b.failed_points);
  CHECK(a.wrong_points == b.wrong_points);
  CHECK(a.climbed_points == b.climbed_points);
  CHECK(a.refuted_before == b.refuted_before);
  CHECK(a.seed == b.seed);
  CHECK(a.integrator == b.integrator);
  CHECK(same_bits(a.integrator_tolerance, b.integrator_tolerance));
  CHECK(same_bits(a.residual, b.residual));
  CHECK(same_bits(a.spent.discretisation, b.spent.discretisation));
  CHECK(same_bits(a.spent.compression, b.spent.compression));
  CHECK(same_bits(a.spent.nonlinearity, b.spent.nonlinearity));
  REQUIRE(a.norm_defect.has_value() == b.norm_defect.has_value());
  if (a.norm_defect) {
    CHECK(same_bits(a.norm_defect->max, b.norm_defect->max));
    CHECK(same_bits(a.norm_defect->rms, b.norm_defect->rms));
  }
  REQUIRE(a.outputs.size() == b.outputs.size());
  for (std::size_t o = 0; o < a.outputs.size(); ++o) {
    CHECK(a.outputs[o].name == b.outputs[o].name);
    CHECK(a.outputs[o].unit == b.outputs[o].unit);
    CHECK(same_bits(a.outputs[o].range, b.outputs[o].range));
    CHECK(same_bits(a.outputs[o].max, b.outputs[o].max));
    CHECK(same_bits(a.outputs[o].p95, b.outputs[o].p95));
    CHECK(same_bits(a.outputs[o].mean, b.outputs[o].mean));
    CHECK(same_bits(a.outputs[o].rms, b.outputs[o].rms));
    CHECK(same_bits(a.outputs[o].max_si, b.outputs[o].max_si));
    CHECK(a.outputs[o].worst == b.outputs[o].worst);
  }
}

inline void check_same_model(const samara::codebooks::ModelDescription& a,
                             const samara::codebooks::ModelDescription& b) {
  CHECK(a.name == b.name);
  CHECK(a.title == b.title);
  CHECK(a.equations == b.equations);
  CHECK(a.frames == b.frames);
  CHECK(a.source == b.source);
  CHECK(a.fixed == b.fixed);
  CHECK(a.fixed_units == b.fixed_units);
}

inline void check_same_build(const samara::codebooks::BuildRecord& a,
                             const samara::codebooks::BuildRecord& b) {
  CHECK(a.builder == b.builder);
  CHECK(a.strategy == b.strategy);
  CHECK(a.status == b.status);
  CHECK(a.message == b.message);
  CHECK(same_bits(a.evaluations, b.evaluations));
  CHECK(same_bits(a.grid_size, b.grid_size));
  CHECK(a.iterations == b.iterations);
  CHECK(a.rounds == b.rounds);
}

/// All that stays the same between two runs of one build.
inline void check_same_but_provenance(const samara::codebooks::Codebook& a,
                                      const samara::codebooks::Codebook& b) {
  CHECK(a.title() == b.title());
  check_same_model(a.model(), b.model());
  check_same_build(a.build(), b.build());
  REQUIRE(a.pieces().size() == b.pieces().size());
  for (std::size_t p = 0; p < a.pieces().size(); ++p) {
    REQUIRE(a.pieces()[p].groups().size() == b.pieces()[p].groups().size());
    for (std::size_t g = 0; g < a.pieces()[p].groups().size(); ++g)
      check_same_group(a.pieces()[p].groups()[g], b.pieces()[p].groups()[g]);
    const samara::codebooks::FrontMap *front = a.pieces()[p].front(), *other = b.pieces()[p].front();
    REQUIRE((front == nullptr) == (other == nullptr));
    if (front == nullptr) continue;
    CHECK(front->coordinate() == other->coordinate());
    CHECK(front->place() == other->place());
    CHECK(std::ranges::equal(front->others(), other->others(), {},
                             &samara::codebooks::FrontMap::Other::coefficients,
                             &samara::codebooks::FrontMap::Other::coefficients));
    CHECK(std::ranges::equal(front->others(), other->others(), {},
                             &samara::codebooks::FrontMap::Other::coordinate,
                             &samara::codebooks::FrontMap::Other::coordinate));
  }
  REQUIRE(a.certificate().has_value() == b.certificate().has_value());
  if (a.certificate()) check_same_certificate(*a.certificate(), *b.certificate());
}

inline void check_same_codebook(const samara::codebooks::Codebook& a, const samara::codebooks::Codebook& b) {
  check_same_but_provenance(a, b);
  CHECK(a.provenance().generator == b.provenance().generator);
  CHECK(a.provenance().plan == b.provenance().plan);
  CHECK(a.provenance().created == b.provenance().created);
  CHECK(a.provenance().host == b.provenance().host);
  CHECK(same_bits(a.provenance().build_seconds, b.provenance().build_seconds));
}
