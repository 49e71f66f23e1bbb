#include "samara/codebooks/composition/reduced_attitude.h"

namespace samara::codebooks {

ReducedAttitude::ReducedAttitude(const models::ModelInfo& info, int quaternion, double scale,
                                 bool without_yaw, bool is_upside_down)
    : quaternion_(quaternion), scale_(scale), without_yaw_(without_yaw), is_upside_down_(is_upside_down) {
  if (!without_yaw) return;
  for (const models::StateGroup& group : info.groups) {
    if (group.kind != models::StateGroupKind::quaternion) vectors_.push_back(group.first);
  }
}

ReducedAttitude::Turn ReducedAttitude::turn(const Eigen::VectorXd& x) const {
  const double w = x[quaternion_], z = x[quaternion_ + 3];
  const double n2 = w * w + z * z;
  const double n4 = n2 * n2;
  // The yaw is twice the angle of (w, z).
  Turn turn;
  turn.c = (w * w - z * z) / n2;
  turn.s = 2.0 * w * z / n2;
  turn.dc = Eigen::Vector2d(4.0 * w * z * z, -4.0 * w * w * z) / n4;
  turn.ds = Eigen::Vector2d(2.0 * z * (z * z - w * w), 2.0 * w * (w * w - z * z)) / n4;
  return turn;
}

Eigen::VectorXd ReducedAttitude::reduced_upright(const Eigen::VectorXd& x, Eigen::MatrixXd* by_x) const {
  const int q = quaternion_;
  const double w = x[q], a = x[q + 1], b = x[q + 2], z = without_yaw_ ? x[q + 3] : 0.0;
  const double share = scale_ / (w * w + z * z);
  Eigen::VectorXd r = x;
  r[q] = scale_;
  r[q + 1] = share * (w * a + z * b);
  r[q + 2] = share * (w * b - z * a);
  r[q + 3] = without_yaw_ ? 0.0 : share * w * x[q + 3];
  if (by_x != nullptr) {
    by_x->setIdentity(x.size(), x.size());
    auto D = by_x->block<4, 4>(q, q);
    // Of the numerators, and of 1/(w^2 + z^2).
    D << 0.0, 0.0, 0.0, 0.0,  //
        a, w, z, b,           //
        b, -z, w, -a,         //
        0.0, 0.0, 0.0, 0.0;
    D *= share;
    const double by_w = -2.0 * w / (w * w + z * z), by_z = -2.0 * z / (w * w + z * z);
    D.col(0).segment<2>(1) += by_w * r.segment<2>(q + 1);
    D.col(3).segment<2>(1) += by_z * r.segment<2>(q + 1);
    if (!without_yaw_) {
      D.col(3).setZero();
      D(3, 0) = -r[q + 3] / w;
      D(3, 3) = share * w;
    }
  }
  const Turn back = vectors_.empty() ? Turn() : turn(x);
  for (const int v : vectors_) {
    r[v] = back.c * x[v] + back.s * x[v + 1];
    r[v + 1] = back.c * x[v + 1] - back.s * x[v];
    if (by_x == nullptr) continue;
    by_x->block<2, 2>(v, v) << back.c, back.s, -back.s, back.c;
    for (int k = 0; k < 2; ++k) {
      (*by_x)(v, q + 3 * k) = back.dc[k] * x[v] + back.ds[k] * x[v + 1];
      (*by_x)(v + 1, q + 3 * k) = back.dc[k] * x[v + 1] - back.ds[k] * x[v];
    }
  }
  return r;
}

Eigen::VectorXd ReducedAttitude::restored_upright(const Eigen::VectorXd& y, const Eigen::VectorXd& x,
                                                  Eigen::MatrixXd* by_y, Eigen::MatrixXd* by_x) const {
  const int q = quaternion_;
  const double w = x[q] / scale_, z = without_yaw_ ? x[q + 3] / scale_ : 0.0;
  const Eigen::Vector4d p = y.segment<4>(q);
  Eigen::Matrix4d product;     // (w, 0, 0, z) times a quaternion
  product << w, 0.0, 0.0, -z,  //
      0.0, w, -z, 0.0,         //
      0.0, z, w, 0.0,          //
      z, 0.0, 0.0, w;
  Eigen::VectorXd result = y;
  result.segment<4>(q) = product * p;
  if (by_y != nullptr) {
    by_y->setIdentity(y.size(), y.size());
    by_y->block<4, 4>(q, q) = product;
    by_x->setZero(y.size(), y.size());
    by_x->block<4, 1>(q, q) = p / scale_;
    if (without_yaw_) by_x->block<4, 1>(q, q + 3) = Eigen::Vector4d(-p[3], -p[2], p[1], p[0]) / scale_;
  }
  const Turn ahead = vectors_.empty() ? Turn() : turn(x);
  for (const int v : vectors_) {
    result[v] = ahead.c * y[v] - ahead.s * y[v + 1];
    result[v + 1] = ahead.s * y[v] + ahead.c * y[v + 1];
    if (by_y == nullptr) continue;
    by_y->block<2, 2>(v, v) << ahead.c, -ahead.s, ahead.s, ahead.c;
    for (int k = 0; k < 2; ++k) {
      (*by_x)(v, q + 3 * k) = ahead.dc[k] * y[v] - ahead.ds[k] * y[v + 1];
      (*by_x)(v + 1, q + 3 * k) = ahead.ds[k] * y[v] + ahead.dc[k] * y[v + 1];
    }
  }
  return result;
}

Eigen::VectorXd ReducedAttitude::turned_over(Eigen::VectorXd x) const {
  const Eigen::Vector4d q = x.segment<4>(quaternion_);
  x.segment<4>(quaternion_) << q[1], -q[0], -q[3], q[2];
  return x;
}

Eigen::VectorXd ReducedAttitude::turned_back(Eigen::VectorXd x) const {
  const Eigen::Vector4d q = x.segment<4>(quaternion_);
  x.segment<4>(quaternion_) << -q[1], q[0], q[3], -q[2];
  return x;
}

void ReducedAttitude::turn_back(Eigen::MatrixXd* slopes) const {
  if (slopes == nullptr) return;
  // Columns by what goes in, rows by what comes out: both are turned by an orthogonal matrix.
  for (auto column : slopes->colwise()) column = turned_back(column);
  for (auto row : slopes->rowwise()) row = turned_back(row.transpose()).transpose();
}

Eigen::VectorXd ReducedAttitude::reduced(const Eigen::VectorXd& x, Eigen::MatrixXd* by_x) const {
  if (!is_upside_down_) return reduced_upright(x, by_x);
  const Eigen::VectorXd r = reduced_upright(turned_over(x), by_x);
  turn_back(by_x);
  return turned_back(r);
}

Eigen::VectorXd ReducedAttitude::restored(const Eigen::VectorXd& y, const Eigen::VectorXd& x,
                                          Eigen::MatrixXd* by_y, Eigen::MatrixXd* by_x) const {
  if (!is_upside_down_) return restored_upright(y, x, by_y, by_x);
  const Eigen::VectorXd result = restored_upright(turned_over(y), turned_over(x), by_y, by_x);
  turn_back(by_y);
  turn_back(by_x);
  return turned_back(result);
}

}  // namespace samara::codebooks
