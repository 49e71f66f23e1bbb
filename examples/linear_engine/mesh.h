#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

/// What a finite-element code hands over: matrices of linear triangles on the unit square, cut into
/// `cells` x `cells` squares of two triangles each, with a disc of another material in the middle.
struct Mesh {
  Eigen::SparseMatrix<double> mass;
  Eigen::SparseMatrix<double> stiffness_disc;   ///< of the triangles in the disc
  Eigen::SparseMatrix<double> stiffness_plate;  ///< of the others
  std::vector<int> border;                      ///< nodes on the border of the square
  std::vector<std::array<int, 3>> triangles;    ///< their corners

  explicit Mesh(int cells) : cells_(cells) {
    std::vector<Eigen::Triplet<double>> m, disc, plate;
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        add_triangle({node(i, j), node(i + 1, j), node(i, j + 1)}, m, disc, plate);
        add_triangle({node(i + 1, j + 1), node(i, j + 1), node(i + 1, j)}, m, disc, plate);
      }
    }
    const int n = (cells + 1) * (cells + 1);
    for (auto* matrix : {&mass, &stiffness_disc, &stiffness_plate}) matrix->resize(n, n);
    mass.setFromTriplets(m.begin(), m.end());
    stiffness_disc.setFromTriplets(disc.begin(), disc.end());
    stiffness_plate.setFromTriplets(plate.begin(), plate.end());
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j) {
        if (i == 0 || j == 0 || i == cells || j == cells) border.push_back(node(i, j));
      }
    }
  }

  int node(int i, int j) const { return i + j * (cells_ + 1); }
  Eigen::Vector2d place(int k) const {
    return Eigen::Vector2d(k % (cells_ + 1), k / (cells_ + 1)) / cells_;
  }

 private:
  using Triplets = std::vector<Eigen::Triplet<double>>;

  /// A right angle at the first corner; both legs are 1 / cells long.
  void add_triangle(const std::array<int, 3>& corners, Triplets& m, Triplets& disc,
                    Triplets& plate) {
    triangles.push_back(corners);
    const Eigen::Vector2d middle =
        (place(corners[0]) + place(corners[1]) + place(corners[2])) / 3.0;
    Triplets& stiffness = (middle - Eigen::Vector2d(0.5, 0.5)).norm() < 0.25 ? disc : plate;
    const double area = 0.5 / (cells_ * cells_);
    const Eigen::Matrix3d k{{1.0, -0.5, -0.5}, {-0.5, 0.5, 0.0}, {-0.5, 0.0, 0.5}};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        m.emplace_back(corners[a], corners[b], area / (a == b ? 6.0 : 12.0));
        stiffness.emplace_back(corners[a], corners[b],
                               k(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
      }
    }
  }

  int cells_;
};
