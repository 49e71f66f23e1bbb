#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"

/// Where a codebook is compared with what it stands for. How many points there are is the plan's:
/// Plan::certificate_points().
namespace samara::codebooks {

/// Times between the builder's nodes and at its borders: twice as many in every time element as it has nodes;
/// none where the codebook has no time.
std::vector<double> certificate_times(const Codebook& book);

/// Places of the coordinate of space: all nodes of a list; of elements the nodes and halfway between neighbours; else
/// equally spaced, twice as many as nodes.
/// @throws ArgumentError unless the codebook has one coordinate of space
Eigen::VectorXd certificate_places(const Codebook& book);

/// Scrambled Sobol' points of the box: parameters x count. Of lists, each value as often as the others.
/// @throws ArgumentError for a codebook of time alone
Eigen::MatrixXd certificate_points(const Codebook& book, int count, std::uint64_t seed);

/// Lower and upper corner of the box of the parameters, for climbs: those whose values are a list have no
/// width.
std::pair<Eigen::VectorXd, Eigen::VectorXd> certificate_box(const Codebook& book);

}  // namespace samara::codebooks
