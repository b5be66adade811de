// SPDX-License-Identifier: Apache-2.0
// Flexible joints against the step, see stiff.h.
//
// With the motors' own inertias B, the springs K and the joint side's mass matrix M (rotors of
// rigid joints included), the couplings swing with the eigenvalues of K (1/B + M^-1), and their
// damping D decays with those of D (1/B + M^-1). Both are taken over many poses within the stops.
#include "stiff.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "arm.h"
#include "axis.h"
#include "maths.h"

namespace mmcs {

namespace {

constexpr int kPoses = 200;

using Matrix = std::vector<double>;

// Lower Cholesky factor in place; false: not positive definite.
bool factor(Matrix &m, size_t n) {
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j <= i; ++j) {
      double sum = m[i * n + j];
      for (size_t k = 0; k < j; ++k) sum -= m[i * n + k] * m[j * n + k];
      if (i != j) {
        m[i * n + j] = sum / m[j * n + j];
      } else if (!(sum > 1e-12 * m[i * n + i])) {
        return false;
      } else {
        m[i * n + i] = std::sqrt(sum);
      }
    }
  }
  return true;
}

// Element (i, j) of the inverse, of the matrix with this factor.
double inverse(const Matrix &l, size_t n, size_t i, size_t j) {
  std::vector<double> x(n), y(n);
  const auto half = [&](size_t column, std::vector<double> &out) {
    for (size_t r = 0; r < n; ++r) {
      double sum = r == column ? 1.0 : 0.0;
      for (size_t k = 0; k < r; ++k) sum -= l[r * n + k] * out[k];
      out[r] = sum / l[r * n + r];
    }
  };
  half(i, x);
  half(j, y);
  double dot = 0.0;
  for (size_t k = 0; k < n; ++k) dot += x[k] * y[k];
  return dot;
}

// No less than the largest eigenvalue of a symmetric matrix with none below 0, and no more than
// 1.25 times as much for six joints: the eighth root of the trace of its eighth power.
double largest(Matrix a, size_t n) {
  double scale = 0.0;
  for (size_t i = 0; i < n; ++i) scale += a[i * n + i];
  if (!(scale > 0.0)) return scale;
  for (double &x : a) x /= scale;
  for (int power = 0; power < 3; ++power) {
    Matrix square(n * n);
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = 0; j < n; ++j) {
        for (size_t k = 0; k < n; ++k) square[i * n + j] += a[i * n + k] * a[k * n + j];
      }
    }
    a = square;
  }
  double trace = 0.0;
  for (size_t i = 0; i < n; ++i) trace += a[i * n + i];
  return scale * std::sqrt(std::sqrt(std::sqrt(trace)));
}

void check_pose(Arm &arm, const mmcs_motor *motors, const std::vector<size_t> &flexible) {
  const size_t n = static_cast<size_t>(arm.joints()), f = flexible.size();
  Matrix mass(n * n), spring(f * f), damper(f * f);
  arm.mass_matrix(mass.data());
  for (size_t i = 0; i < n; ++i) {
    const mmcs_motor &m = motors[i];
    if (m.stiffness == 0.0) mass[i * n + i] += m.gear * m.gear * m.inertia;
  }
  if (!factor(mass, n)) {
    throw std::invalid_argument(
        "the arm has a pose in which a flexible joint moves nothing: give its links mass");
  }
  for (size_t a = 0; a < f; ++a) {
    for (size_t b = 0; b < f; ++b) {
      const mmcs_motor &m = motors[flexible[a]], &o = motors[flexible[b]];
      double soft = inverse(mass, n, flexible[a], flexible[b]);
      if (a == b) soft += 1.0 / (m.inertia * m.gear * m.gear);
      spring[a * f + b] = std::sqrt(m.stiffness * o.stiffness) * soft;
      damper[a * f + b] = std::sqrt(m.damping * o.damping) * soft;
    }
  }
  const double swing = largest(spring, f) * kStep * kStep, decay = largest(damper, f) * kStep;
  if (swing <= 0.25 && decay <= 0.5) return;
  size_t worst = 0;
  const Matrix &guilty = swing > 0.25 ? spring : damper;
  for (size_t a = 0; a < f; ++a) {
    if (guilty[a * f + a] > guilty[worst * f + worst]) worst = a;
  }
  throw std::invalid_argument(
      "axis " + std::to_string(flexible[worst]) + ": with its load the flexible joint is faster " +
      "than the 50 us step: make it " +
      (swing > 0.25 ? "rigid (stiffness = 0), softer or its links heavier" : "less damped"));
}

// Whether no axis has less than none of it, to rounding: xx yy zz xy yz xz.
bool semidefinite(const double *i) {
  const double size = i[0] + i[1] + i[2], least = -1e-9;
  if (size == 0.0) return i[3] == 0.0 && i[4] == 0.0 && i[5] == 0.0;
  const double xx = i[0] / size, yy = i[1] / size, zz = i[2] / size;
  const double xy = i[3] / size, yz = i[4] / size, xz = i[5] / size;
  const double determinant =
      xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  return xx * yy - xy * xy >= least && yy * zz - yz * yz >= least && xx * zz - xz * xz >= least &&
         determinant >= least;
}

void check_body(size_t link, const mmcs_link &l) {
  if (!semidefinite(l.inertia)) {
    throw std::invalid_argument("link " + std::to_string(link) +
                                ": inertia is that of no body: it must be positive definite");
  }
}

// Where the mass lies: its second moments, which no body has less than none of either. They are
// what makes the greatest moment of inertia at most the sum of the other two.
bool has_mass_distribution(const mmcs_link &l) {
  const double *i = l.inertia, half = (i[0] + i[1] + i[2]) / 2;
  const double moments[6] = {half - i[0], half - i[1], half - i[2], -i[3], -i[4], -i[5]};
  return semidefinite(moments);
}

}  // namespace

std::string arm_caution(const mmcs_link *links, int count) {
  for (int i = 1; i < count; ++i) {  // the first turns about one axis, of which alone it tells
    if (!has_mass_distribution(links[i])) {
      return "link " + std::to_string(i) +
             ": its greatest principal inertia is more than the sum of the other two, which no "
             "body has";
    }
  }
  return "";
}

void check_arm(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links) {
  std::vector<size_t> flexible;
  const size_t n = static_cast<size_t>(config.links);
  for (size_t i = 0; i < n; ++i) {
    check_body(i, links[i]);
    if (motors[i].stiffness > 0.0) flexible.push_back(i);
  }
  if (flexible.empty()) return;
  Arm arm(links, config.links, config.gravity);
  std::vector<double> q(n);
  uint64_t seed = 1989;
  for (int pose = 0; pose < kPoses; ++pose) {
    for (size_t i = 0; i < n; ++i) {
      const mmcs_motor &m = motors[i];
      const bool stops = m.stop_lo < m.stop_hi;
      const double lo = stops ? m.stop_lo : -kPi, hi = stops ? m.stop_hi : kPi;
      const double share = random_unit(seed);
      q[i] = pose == 0 ? m.angle0 : lo + share * (hi - lo);
    }
    arm.pose(q.data());
    check_pose(arm, motors, flexible);
  }
}

}  // namespace mmcs
