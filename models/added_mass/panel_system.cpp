#include "samara/models/added_mass/panel_system.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <tbb/task_arena.h>

#include "samara/base/parallel.h"
#include "samara/models/added_mass/panel_kernels.h"

namespace samara::models::added_mass {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPerFourPi = 0.25 * std::numbers::inv_pi;
/// Panels see each other exactly within so many sums of their radii, points and panels within so many radii.
constexpr double kNearPanels = 1.5;
constexpr double kNearPoints = 3.0;
/// Weight of Green's formula beside the energy of vortex loops, times half the root of the area: of the order
/// of the body's inverse size. The added mass of the leaf changes by up to 0.6 % from 0.1 to 1.
constexpr double kGreenWeight = 0.5;
/// Of a matrix, to one task.
constexpr std::size_t kLoopRows = 256;

/// A ball about the centroids of a block of panels, which are mostly neighbours: spares asking each lane
/// about panels that are near none.
struct BlockBall {
  Vector3d centre = Vector3d::Zero();
  double radius = 0.0;
  double greatest_radius = 0.0;  ///< of its panels

  BlockBall(const Panel* panels, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) centre += panels[i].centroid / static_cast<double>(size);
    for (std::size_t i = 0; i < size; ++i) {
      radius = std::max(radius, (panels[i].centroid - centre).norm());
      greatest_radius = std::max(greatest_radius, panels[i].radius);
    }
  }
  bool may_be_near(const Panel& panel, double reach) const {
    const double distance = radius + reach;
    return (panel.centroid - centre).squaredNorm() <= distance * distance * (1.0 + 1e-12);
  }
};

std::size_t blocks(std::size_t rows) {
  return (rows + kLanes - 1) / kLanes;
}

class Assembly {
 public:
  Assembly(const TriangleMesh& mesh, SharedProgress& progress)
      : mesh_(mesh),
        progress_(progress),
        n_(static_cast<std::size_t>(mesh.vertices.cols())),
        mass_(Eigen::VectorXd::Zero(mesh.vertices.cols())) {
    for (Index i = 0; i < mesh.triangles.cols(); ++i) {
      const Eigen::Vector3i t = mesh.triangles.col(i);
      panels_.emplace_back(mesh.vertices.col(t[0]), mesh.vertices.col(t[1]), mesh.vertices.col(t[2]));
      const Panel& p = panels_.back();
      far_.push_back(seen_from_far(p));
      area_ += p.area;
      for (int k = 0; k < 3; ++k) mass_[t[k]] += p.area / 3.0;
    }
    system_.matrix.resize(mesh.vertices.cols(), mesh.vertices.cols());
    system_.rhs.setZero(mesh.vertices.cols(), 6);
    system_.flux.setZero(mesh.vertices.cols(), 6);
  }

  PanelSystem run() {
    add_flux();
    parallel_for(blocks(n_), [&](std::size_t block) {
      if (!progress_.goes_on()) return;
      set_green_rows(block);
      progress_.count();
    });
    system_.rhs -= system_.flux;
    add_vortex_loops();
    return std::move(system_);
  }

 private:
  static FarPanel seen_from_far(const Panel& p) {
    FarPanel far{};
    for (int k = 0; k < 3; ++k) {
      far.centroid[k] = p.centroid[k];
      far.normal[k] = p.normal[k];
    }
    far.area_over_4pi = p.area * kPerFourPi;
    far.radius = p.radius;
    const Matrix3d& m = p.second_moment;
    const double moment[6] = {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(2, 0)};
    std::copy(std::begin(moment), std::end(moment), std::begin(far.moment));
    return far;
  }

  int corner(std::size_t panel, std::size_t k) const {
    return mesh_.triangles(static_cast<Index>(k), static_cast<Index>(panel));
  }

  /// Int psi_a v_j dS, exact: v is linear on each panel.
  void add_flux() {
    for (std::size_t i = 0; i < panels_.size(); ++i) {
      const Panel& p = panels_[i];
      Eigen::Matrix<double, 3, 6> v;
      for (std::size_t k = 0; k < 3; ++k) {
        v.row(static_cast<Index>(k)) << p.normal.transpose(), p.corner[k].cross(p.normal).transpose();
      }
      for (std::size_t k = 0; k < 3; ++k) {
        system_.flux.row(corner(i, k)) += p.area / 12.0 * (v.colwise().sum() + v.row(static_cast<Index>(k)));
      }
    }
  }

  // Green's formula at the corners: sets the rows of a block of corners, times weight and lumped mass.

  struct GreenLanes {
    /// Lanes of: minus the coefficients of phi; their sum; 6 right-hand sides.
    std::vector<double> dipole, sum, rhs;
  };

  void set_green_rows(std::size_t block) {
    LanePoints points{};
    const auto lanes = std::min(kLanes, n_ - block * kLanes);
    for (std::size_t l = 0; l < kLanes; ++l) {
      const Vector3d x = mesh_.vertices.col(static_cast<Index>(block * kLanes + std::min(l, lanes - 1)));
      for (int k = 0; k < 3; ++k) points.x[k][l] = x[k];
    }
    const std::size_t count = panels_.size();
    std::vector<double> source(count * kLanes), r2(count * kLanes), dipole(count * kLanes);
    far_sources(far_.data(), count, points, source.data(), r2.data());
    far_dipoles(far_.data(), count, points, dipole.data());
    GreenLanes sums{std::vector<double>(n_ * kLanes), std::vector<double>(kLanes),
                    std::vector<double>(6 * kLanes)};
    for (std::size_t j = 0; j < count; ++j) {
      const double reach = kNearPoints * far_[j].radius;
      for (std::size_t l = 0; l < lanes; ++l) {
        if (r2[j * kLanes + l] < reach * reach) {
          see_exactly(block * kLanes + l, l, j, source[j * kLanes + l], dipole[j * kLanes + l], sums);
        }
      }
      add_far_panel(j, &source[j * kLanes], &dipole[j * kLanes], sums);
    }
    write_green_rows(block * kLanes, lanes, sums);
  }

  /// Replaces the far values of a lane: `dipole` becomes 0, its part is added corner by corner.
  void see_exactly(std::size_t vertex, std::size_t lane, std::size_t j, double& source, double& dipole,
                   GreenLanes& sums) const {
    const Panel& p = panels_[j];
    const PanelIntegrals exact = integrate_panel(p, mesh_.vertices.col(static_cast<Index>(vertex)));
    source = kPerFourPi * exact.source;
    dipole = 0.0;
    const Vector3d moment = kPerFourPi * exact.source_moment - source * p.centroid;
    const Vector3d turning = moment.cross(p.normal);
    for (std::size_t c = 0; c < 3; ++c) sums.rhs[(3 + c) * kLanes + lane] -= turning[static_cast<Index>(c)];
    for (std::size_t k = 0; k < 3; ++k) {
      // A panel is in line with its own corners: it shows them no solid angle.
      if (corner(j, k) == static_cast<int>(vertex)) return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = kPerFourPi * exact.dipole[k];
      sums.dipole[static_cast<std::size_t>(corner(j, k)) * kLanes + lane] += value;
      sums.sum[lane] += value;
    }
  }

  void add_far_panel(std::size_t j, const double* source, const double* dipole, GreenLanes& sums) const {
    const Panel& p = panels_[j];
    const Vector3d turning = p.centroid.cross(p.normal);
    const double third = 1.0 / 3.0;
    const double dipole_factors[] = {third, third, third, 1.0};
    double* dipole_rows[] = {&sums.dipole[static_cast<std::size_t>(corner(j, 0)) * kLanes],
                             &sums.dipole[static_cast<std::size_t>(corner(j, 1)) * kLanes],
                             &sums.dipole[static_cast<std::size_t>(corner(j, 2)) * kLanes], sums.sum.data()};
    add_outer(dipole, dipole_factors, 4, dipole_rows);
    const double source_factors[] = {-p.normal[0], -p.normal[1], -p.normal[2],
                                     -turning[0],  -turning[1],  -turning[2]};
    double* rhs = sums.rhs.data();
    double* source_rows[] = {
        rhs, rhs + kLanes, rhs + 2 * kLanes, rhs + 3 * kLanes, rhs + 4 * kLanes, rhs + 5 * kLanes};
    add_outer(source, source_factors, 6, source_rows);
  }

  void write_green_rows(std::size_t first, std::size_t lanes, const GreenLanes& sums) {
    for (std::size_t l = 0; l < lanes; ++l) {
      const auto a = static_cast<Index>(first + l);
      const double weight = kGreenWeight / std::sqrt(0.25 * area_) * mass_[a];
      for (std::size_t b = 0; b < n_; ++b) {
        system_.matrix(a, static_cast<Index>(b)) = -weight * sums.dipole[b * kLanes + l];
      }
      system_.matrix(a, a) += weight * (1.0 + sums.sum[l]);
      for (std::size_t c = 0; c < 6; ++c) {
        system_.rhs(a, static_cast<Index>(c)) = weight * sums.rhs[c * kLanes + l];
      }
    }
  }

  // The energy of vortex loops.

  /// For each panel of a block the mean over it of what all others do there.
  struct LoopLanes {
    std::vector<double> potential;  ///< lanes x 3 x corners: Int curl psi_b G
    /// Columns: Phi = Int n G, T = Int y n^T G (by columns).
    Eigen::Matrix<double, 12, Eigen::Dynamic> moving;
    Eigen::VectorXd lift;  ///< x . Phi
  };

  void add_vortex_loops() {
    const std::size_t count = blocks(panels_.size());
    // Blocks of a group are prepared side by side, then added in order: each entry is summed in the same
    // order whatever the number of threads.
    const auto group = 4 * static_cast<std::size_t>(std::max(1, tbb::this_task_arena::max_concurrency()));
    std::vector<LoopLanes> lanes(std::min(group, count));
    for (std::size_t first = 0; first < count && progress_.goes_on(); first += group) {
      const std::size_t size = std::min(group, count - first);
      parallel_for(size, [&](std::size_t k) {
        see_loops(first + k, lanes[k]);
        progress_.count();
      });
      parallel_for((n_ + kLoopRows - 1) / kLoopRows, [&](std::size_t rows) {
        const std::size_t begin = rows * kLoopRows, end = std::min(n_, begin + kLoopRows);
        for (std::size_t k = 0; k < size; ++k) add_loop_rows(first + k, lanes[k], begin, end);
      });
      for (std::size_t k = 0; k < size; ++k) add_loop_rhs(first + k, lanes[k]);
    }
  }

  std::size_t panels_in(std::size_t block) const { return std::min(kLanes, panels_.size() - block * kLanes); }

  void see_loops(std::size_t block, LoopLanes& lanes) const {
    const std::size_t size = panels_in(block), count = panels_.size();
    LanePoints points{};
    for (std::size_t l = 0; l < kLanes; ++l) {
      const FarPanel& p = far_[block * kLanes + std::min(l, size - 1)];
      for (int k = 0; k < 3; ++k) points.x[k][l] = p.centroid[k];
      for (int k = 0; k < 6; ++k) points.moment[k][l] = p.moment[k];
    }
    std::vector<double> source(count * kLanes), r2(count * kLanes);
    far_sources(far_.data(), count, points, source.data(), r2.data());
    std::vector<double> potential(3 * n_ * kLanes), moving(12 * kLanes);
    lanes.moving.setZero(12, kLanes);
    lanes.lift.setZero(kLanes);
    const BlockBall ball(&panels_[block * kLanes], size);
    for (std::size_t j = 0; j < count; ++j) {
      if (ball.may_be_near(panels_[j], kNearPanels * (ball.greatest_radius + far_[j].radius))) {
        for (std::size_t l = 0; l < size; ++l) {
          const std::size_t i = block * kLanes + l;
          const double reach = kNearPanels * (far_[i].radius + far_[j].radius);
          if (r2[j * kLanes + l] < reach * reach) source[j * kLanes + l] = see_exactly(i, j, l, lanes);
        }
      }
      add_loops_of(j, &source[j * kLanes], potential, moving);
    }
    lanes.potential.resize(3 * n_ * kLanes);
    for (std::size_t b = 0; b < 3 * n_; ++b) {
      for (std::size_t l = 0; l < kLanes; ++l) lanes.potential[l * 3 * n_ + b] = potential[b * kLanes + l];
    }
    for (std::size_t c = 0; c < 12; ++c) {
      for (std::size_t l = 0; l < kLanes; ++l) {
        lanes.moving(static_cast<Index>(c), static_cast<Index>(l)) += moving[c * kLanes + l];
      }
    }
    for (std::size_t l = 0; l < size; ++l) {
      const auto lane = static_cast<Index>(l);
      lanes.lift[lane] += panels_[block * kLanes + l].centroid.dot(lanes.moving.col(lane).head<3>());
    }
  }

  /// The mean over panel i of Int G dS over panel j, by three points; adds what the lane's T and lift differ
  /// from their values with both at their centroids.
  double see_exactly(std::size_t i, std::size_t j, std::size_t lane, LoopLanes& lanes) const {
    const Panel &outer = panels_[i], &inner = panels_[j];
    double source = 0.0;
    Vector3d moment = Vector3d::Zero(), weighted = Vector3d::Zero();
    for (std::size_t q = 0; q < 3; ++q) {
      const Vector3d x = 0.5 * (outer.centroid + outer.corner[q]);  // 2/3, 1/6, 1/6: exact for quadratics
      const PanelIntegrals exact = integrate_panel(inner, x);
      source += exact.source;
      moment += exact.source_moment;
      weighted += exact.source * x;
    }
    const double scale = kPerFourPi / 3.0;
    source *= scale;
    const auto column = static_cast<Index>(lane);
    const Matrix3d T = (scale * moment - source * inner.centroid) * inner.normal.transpose();
    lanes.moving.col(column).tail<9>() += T.reshaped();
    lanes.lift[column] += (scale * weighted - source * outer.centroid).dot(inner.normal);
    return source;
  }

  void add_loops_of(std::size_t j, const double* source, std::vector<double>& potential,
                    std::vector<double>& moving) const {
    const Panel& p = panels_[j];
    double factors[21];
    double* rows[21];
    std::size_t r = 0;
    const auto add_row = [&](double factor, double* row) {
      factors[r] = factor;
      rows[r++] = row;
    };
    for (std::size_t b = 0; b < 3; ++b) {
      double* to = &potential[3 * static_cast<std::size_t>(corner(j, b)) * kLanes];
      // Component by component in separate tables, so that rows of the matrix read them contiguously.
      for (std::size_t k = 0; k < 3; ++k) add_row(p.curl[b][static_cast<Index>(k)], to + k * kLanes);
    }
    for (Index k = 0; k < 3; ++k) add_row(p.normal[k], &moving[static_cast<std::size_t>(k) * kLanes]);
    for (Index c = 0; c < 3; ++c) {
      for (Index k = 0; k < 3; ++k) {
        add_row(p.centroid[k] * p.normal[c], &moving[static_cast<std::size_t>(3 + 3 * c + k) * kLanes]);
      }
    }
    add_outer(source, factors, r, rows);
  }

  void add_loop_rows(std::size_t block, const LoopLanes& lanes, std::size_t begin, std::size_t end) {
    for (std::size_t l = 0; l < panels_in(block); ++l) {
      const std::size_t i = block * kLanes + l;
      const Panel& p = panels_[i];
      const double* potential = &lanes.potential[l * 3 * n_];
      for (std::size_t a = 0; a < 3; ++a) {
        const Vector3d c = p.area * p.curl[a];
        double* row = system_.matrix.data() + static_cast<std::size_t>(corner(i, a)) * n_;
        for (std::size_t b = begin; b < end; ++b) {
          row[b] += c[0] * potential[3 * b] + c[1] * potential[3 * b + 1] + c[2] * potential[3 * b + 2];
        }
      }
    }
  }

  /// What the sheet n x u of a motion u, and for a rotation the vorticity 2w within, do to each loop: with
  /// Phi = Int n G, T = Int y n^T G and Newton's potential of the body (tr T - x.Phi)/2 the vector potential
  /// is Phi x e_k for the translation along axis k and e_k (x.Phi) - T e_k for the rotation about it.
  void add_loop_rhs(std::size_t block, const LoopLanes& lanes) {
    for (std::size_t l = 0; l < panels_in(block); ++l) {
      const std::size_t i = block * kLanes + l;
      const Panel& p = panels_[i];
      const auto lane = static_cast<Index>(l);
      const Vector3d Phi = lanes.moving.col(lane).head<3>();
      const Matrix3d T = lanes.moving.col(lane).tail<9>().reshaped(3, 3);
      Eigen::Matrix<double, 3, 6> potential;
      for (int k = 0; k < 3; ++k) {
        potential.col(k) = Phi.cross(Vector3d::Unit(k));
        potential.col(3 + k) = lanes.lift[lane] * Vector3d::Unit(k) - T.col(k);
      }
      for (std::size_t a = 0; a < 3; ++a) {
        system_.rhs.row(corner(i, a)) += p.area * p.curl[a].transpose() * potential;
      }
    }
  }

  const TriangleMesh& mesh_;
  SharedProgress& progress_;
  std::size_t n_;
  std::vector<Panel> panels_;
  std::vector<FarPanel> far_;
  Eigen::VectorXd mass_;  ///< Int psi_a dS
  double area_ = 0.0;
  PanelSystem system_;
};

}  // namespace

PanelSystem assemble(const TriangleMesh& mesh, SharedProgress& progress) {
  return Assembly(mesh, progress).run();
}

double assembly_pieces(const TriangleMesh& mesh) {
  return static_cast<double>(blocks(static_cast<std::size_t>(mesh.vertices.cols())) +
                             blocks(static_cast<std::size_t>(mesh.triangles.cols())));
}

}  // namespace samara::models::added_mass
