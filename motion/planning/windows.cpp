#include "samara/motion/planning/windows.h"

#include <algorithm>
#include <cmath>

#include "samara/motion/ghost/bounded_quadratic.h"
#include "samara/motion/planning/fall_cost.h"

namespace samara::motion {

namespace {

constexpr int kTrials = 5;  ///< of a window, with more and more damping

long steps_between(const PlannedFall& fall, double from, double to) {
  return std::lround((to - from) / fall.plan().search.step);
}

}  // namespace

Windows::Windows(const PlannedFall& fall, std::vector<CourseKnot>& knots)
    : fall_(fall), knots_(knots), count_(fall.names().size()), motion_(fall, kMoved), roaming_(fall) {}

bool Windows::improve(std::size_t first, const ReplayedFall& now) {
  now_ = &now;
  if (steps_between(fall_, now.at_knots[first].t, horizon(first)) < 10) return false;
  const Look here = look(first, now, true);
  if (!std::isfinite(here.cost) || !here.H.allFinite()) return false;
  const Eigen::Index n = here.g.size();
  Eigen::VectorXd lower(n), upper(n), z(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto j = static_cast<std::size_t>(i) % count_;
    lower[i] = fall_.plan().box[j].lower;
    upper[i] = fall_.plan().box[j].upper;
    z[i] = knots_[first + static_cast<std::size_t>(i) / count_].values[j];
  }
  double damping = 1e-3;
  for (int trial = 0; trial < kTrials; ++trial, damping *= 10.0) {
    Eigen::MatrixXd H = here.H;
    for (Eigen::Index i = 0; i < n; ++i) H(i, i) += damping * (here.H(i, i) + 1e-9 * here.H.trace());
    put(first, bounded_minimum(H, H * z - here.g, lower, upper, z));
    if (look(first, now, false).cost < here.cost) return true;
  }
  put(first, z);
  return false;
}

Eigen::Index Windows::unknowns(std::size_t first) const {
  return static_cast<Eigen::Index>(std::min(kMoved, knots_.size() - first) * count_);
}

long Windows::samples_every(double length, std::size_t knots) const {
  return std::max(1L, steps_between(fall_, 0.0, length) / static_cast<long>(20 * knots));
}

template <class Record>
bool Windows::run(std::size_t first, const FallPoint& from, double end, bool derivatives,
                  const Record& record) {
  const double h = fall_.plan().search.step;
  motion_.begin(from, derivatives ? std::min(kMoved, knots_.size() - first) : 0);
  const std::size_t last = std::min(knots_.size(), first + kSeen);
  const long all = steps_between(fall_, from.t, end), every = samples_every(end - from.t, last - first);
  // By the trapezoidal rule, as the cost of a fall is added up.
  const auto sample = [&](std::size_t k, long step) {
    const long since = step == 0 ? 0 : (step - 1) % every + 1,
               next = std::min(every - step % every, all - step);
    record(k, 0.5 * h * static_cast<double>(since + next));
  };
  sample(first, 0);
  long step = 0;
  double t = from.t;
  for (std::size_t k = first; k < last; ++k) {
    motion_.turn(knots_[k]);
    // The fall may be over before its last knots come.
    const double until = k + 1 < last ? std::min(knots_[k + 1].t, end) : end;
    for (long left = steps_between(fall_, t, until); left > 0;) {
      const long now = std::min(left, every - step % every);
      if (!motion_.step(now)) return false;
      left -= now;
      step += now;
      if (step % every == 0 || step == all) sample(k, step);
    }
    t = until;
  }
  return true;
}

double Windows::horizon(std::size_t first) const {
  return first + kSeen < knots_.size() ? std::min(knots_[first + kSeen].t, now_->end.t) : now_->end.t;
}

double Windows::fallen() const {
  return height_fallen(fall_, now_->end.height);
}

void Windows::add_changes(std::size_t first, const FallPoint& from, Look& look) const {
  const auto knots = static_cast<Eigen::Index>(std::min(kMoved, knots_.size() - first));
  const double whole = std::sqrt(fallen());
  for (Eigen::Index k = 0; k <= knots; ++k) {
    const std::size_t knot = first + static_cast<std::size_t>(k);
    if (knot >= knots_.size()) break;
    for (std::size_t j = 0; j < count_; ++j) {
      const double weight = change_weight(fall_, j) / whole;
      const double before = k == 0 ? from.heading_for[j] : knots_[knot - 1].values[j];
      const double change = weight * (knots_[knot].values[j] - before);
      look.cost += change * change;
      const Eigen::Index here = k * static_cast<Eigen::Index>(count_) + static_cast<Eigen::Index>(j);
      const Eigen::Index there = here - static_cast<Eigen::Index>(count_);
      if (look.g.size() == 0) continue;
      const bool has_here = k<knots, has_there = k> 0;
      if (has_here) {
        look.H(here, here) += weight * weight;
        look.g[here] += weight * change;
      }
      if (has_there) {
        look.H(there, there) += weight * weight;
        look.g[there] -= weight * change;
      }
      if (has_here && has_there) {
        look.H(here, there) -= weight * weight;
        look.H(there, here) -= weight * weight;
      }
    }
  }
}

Eigen::Matrix3Xd Windows::moved_places() const {
  const Eigen::MatrixXd& tangents = motion_.tangents();
  Eigen::Matrix3Xd moved(3, tangents.cols());
  for (Eigen::Index i = 0; i < tangents.cols(); ++i) {
    moved.col(i) =
        fall_.states().position({tangents.col(i).data(), static_cast<std::size_t>(tangents.rows())});
  }
  return moved;
}

void Windows::add_residual(const Eigen::VectorXd& residual, const Eigen::MatrixXd& J, double weight,
                           Look& look) {
  const double square = weight * weight;
  look.cost += square * residual.squaredNorm();
  if (look.g.size() == 0) return;
  look.H += square * J.transpose() * J;
  look.g += square * J.transpose() * residual;
}

void Windows::add_path(double duration, Look& look) const {
  if (!fall_.plan().sketch) return;
  const Eigen::Vector3d place = fall_.states().position(motion_.state());
  Eigen::Matrix3Xd J(3, look.g.size());
  if (look.g.size() > 0) {
    J = moved_places();
    const Eigen::RowVectorXd falls = J.row(2);
    J -= fall_.plan().sketch->slope(place) * falls;
  }
  add_residual(fall_.deviation(motion_.time(), place), J, deviation_weight(fall_, duration, now_->end.t),
               look);
}

void Windows::add_turbulence(std::size_t first, std::size_t knot, double duration, Look& look) {
  if (!(fall_.turbulence_factor() > 0.0) || knot >= now_->at_knots.size()) return;
  const FallPoint& from = now_->at_knots[knot];
  const FallPoint& to = knot + 1 < now_->at_knots.size() ? now_->at_knots[knot + 1] : now_->end;
  const std::vector<double>& values = knots_[knot].values;
  const double t = motion_.time();
  Eigen::VectorXd residual;
  roaming_.at(t, motion_.state(), values, residual);
  Eigen::MatrixXd J(residual.size(), look.g.size());
  for (Eigen::Index i = 0; i < look.g.size(); ++i) {
    // Along the direction of the unknown, in state and coefficient at once.
    const std::size_t at_knot = first + static_cast<std::size_t>(i) / count_;
    const std::size_t j = static_cast<std::size_t>(i) % count_;
    const double e = 1e-4 * (fall_.plan().box[j].upper - fall_.plan().box[j].lower);
    Eigen::VectorXd ahead, behind;
    for (const double sign : {1.0, -1.0}) {
      std::vector<double> state = motion_.state(), coefficients = values;
      for (std::size_t k = 0; k < state.size(); ++k)
        state[k] += sign * e * motion_.tangents()(static_cast<Eigen::Index>(k), i);
      if (at_knot == knot) coefficients[j] += sign * e;
      roaming_.at(t, state, coefficients, sign > 0.0 ? ahead : behind);
    }
    J.col(i) = (ahead - behind) / (2.0 * e);
  }
  const double weight = turbulence_weight(fall_, duration, from.height - to.height);
  add_residual(residual, J, weight / std::sqrt(fallen()), look);
}

void Windows::add_landing(Look& look) const {
  const auto& landing = fall_.plan().landing;
  if (!landing || now_->end.height > fall_.plan().ground) return;
  const std::vector<double>& state = motion_.state();
  std::vector<double> rate(state.size()), coefficients(count_);
  motion_.read_coefficients(coefficients);
  auto workspace = fall_.model().make_workspace();
  fall_.model().rhs(motion_.time(), state, coefficients, rate, workspace);
  const Eigen::Vector3d place = fall_.states().position(state), velocity = fall_.states().position(rate);
  if (!(velocity.z() < 0.0)) return;
  const Eigen::Vector2d along = velocity.head<2>() / velocity.z();
  const Eigen::Vector2d off =
      place.head<2>() + along * (fall_.plan().ground - place.z()) - landing->head<2>();
  Eigen::Matrix2Xd J(2, look.g.size());
  if (look.g.size() > 0) {
    const Eigen::Matrix3Xd moved = moved_places();
    J = moved.topRows<2>() - along * moved.row(2);
  }
  add_residual(off, J, landing_weight(fall_), look);
}

Windows::Look Windows::look(std::size_t first, const ReplayedFall& now, bool derivatives) {
  now_ = &now;
  const FallPoint& from = now.at_knots[first];
  const double end = horizon(first);
  Look look;
  look.cost = 0.0;
  if (derivatives) {
    look.H.setZero(unknowns(first), unknowns(first));
    look.g.setZero(unknowns(first));
  }
  const bool finite = run(first, from, end, derivatives, [&](std::size_t knot, double duration) {
    add_path(duration, look);
    add_turbulence(first, knot, duration, look);
  });
  if (!finite) return {};
  if (end == now_->end.t) add_landing(look);
  add_changes(first, from, look);
  return look;
}

void Windows::put(std::size_t first, const Eigen::VectorXd& z) {
  for (Eigen::Index i = 0; i < z.size(); ++i)
    knots_[first + static_cast<std::size_t>(i) / count_].values[static_cast<std::size_t>(i) % count_] = z[i];
}

}  // namespace samara::motion
