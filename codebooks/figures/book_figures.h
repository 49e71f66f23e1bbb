#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"
#include "samara/io/svg_chart.h"

/// What a codebook says, as panels of a picture (io/svg_chart.h). All panels need a codebook with time.
namespace samara::codebooks {

/// The middle of the box: of lists the value next to it. Parameters in order, SI.
Eigen::VectorXd middle_of_box(const Codebook& book);

/// Every output over time at one point. @param q parameters in order, SI  @param outputs names; empty: all
/// @throws ArgumentError for an unknown output or without time; OutsideBoxError for a point outside the box
std::vector<io::SvgPanel> trajectory_panels(const Codebook& book, const Eigen::VectorXd& q,
                                            const std::vector<std::string>& outputs = {});

/// The largest and the median difference from the reference integrator over time, at fresh points of the box, of the
/// range that the certificate names (else of the range at these points).
/// @param points at least 1
/// @throws ArgumentError without time or model; NoResultError where no point could be integrated
std::vector<io::SvgPanel> error_panels(const Codebook& book, int points, std::uint64_t seed,
                                       const std::vector<std::string>& outputs = {});

/// The largest rank and the numbers stored, by slab of time: the largest, and the sum, over all cells.
/// @throws ArgumentError without time
std::vector<io::SvgPanel> rank_panels(const Codebook& book);

/// First-order and total Sobol' indices over time, of inputs that are uniform over the box.
/// @throws ArgumentError without time; NoResultError where there are no indices
std::vector<io::SvgPanel> index_panels(const Codebook& book, const std::vector<std::string>& outputs = {});

}  // namespace samara::codebooks
