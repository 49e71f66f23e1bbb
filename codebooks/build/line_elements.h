#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

/// A coordinate in elements, for functions whose steep parts cover a small part of it.
struct LineElements {
  pgd::Axis axis;
  Eigen::MatrixXd steepest;  ///< a point of the box per line of the first look: where values change most
};

struct LineElementsOptions {
  Eigen::VectorXd borders;  ///< of elements to begin with; empty: two halves
  double tolerance = 1e-4;  ///< of a value between the nodes
  int degree = 8;           ///< even: the middle of an element is a node
  int max_nodes = 512;
  long max_points = 120'000;  ///< to be asked for
};

/// Elements of one coordinate of a box, halved until the polynomials through their nodes follow values along lines, at
/// points between the nodes. A front crosses different lines in different places: whenever all elements follow some
/// lines they are tried along fresh ones, until these find nothing.
/// @param coordinate along which the lines run, from `lower` to `upper`; the label may have a transform
/// @param values over their scales, a column per point of the box
/// @param fresh_bases points that lines go through, drawn anew with each call; as many each time, a multiple of 8
/// @returns nothing where the nodes or the points allowed do not suffice
std::optional<LineElements> elements_along(
    Eigen::Index coordinate, const pgd::Axis::Label& label, double lower, double upper,
    const std::function<Eigen::MatrixXd(const Eigen::MatrixXd& points)>& values,
    const std::function<Eigen::MatrixXd()>& fresh_bases, const LineElementsOptions& options);

/// Points of a box in the measure of its nodes: every element of an axis is as likely as any other.
Eigen::MatrixXd points_by_elements(const std::vector<pgd::Axis>& axes, int count, pgd::Random& random);

}  // namespace samara::codebooks
