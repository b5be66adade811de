// SPDX-License-Identifier: Apache-2.0
// Joint speeds after one step of coupled masses under dry friction and stops.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mmcs {

// One joint's dry friction and stops, as impulses (N m s at the joint) and speeds (rad/s).
struct JointBounds {
  double stick[2];  // impulse that holds it: [0] against positive turning, [1] against negative
  double slide[2];  // impulse that brakes it while it moves
  double speed_lo;  // speeds that would take it exactly to its stops in this step
  double speed_hi;
};

// Solves a v = b + friction, where each joint's friction impulse brings it to rest if it can and
// otherwise brakes with its bound. `v` holds the speeds before the step, then those after it.
// Joints that rest have speed 0 exactly. a: row-major, symmetric, positive definite.
class ContactSolver {
 public:
  explicit ContactSolver(int n);
  void solve(const double *a, const double *b, const JointBounds *bounds, double *v);
  int64_t rounds() const { return rounds_; }  // linear solutions so far, for measurement

 private:
  enum class Mode : uint8_t { kPlus, kMinus, kRest, kUpperStop, kLowerStop };

  void solve_free(const double *a, const double *b, const JointBounds *bounds, double *v);
  Mode revised_free(size_t i, const JointBounds &bound, double v) const;
  Mode revised_held(size_t i, const double *a, const double *b, const JointBounds &bound,
                    const double *v) const;
  static bool is_held(Mode mode) { return mode >= Mode::kRest; }

  size_t n_;
  int64_t rounds_ = 0;
  std::vector<Mode> mode_;
  std::vector<uint8_t> rested_;      // at rest before the step
  std::vector<size_t> free_, held_;  // joints that move, and those that are held
  std::vector<double> l_;  // factor of the free joints' part, and its diagonal and right side
  std::vector<double> d_;
  std::vector<double> x_;
};

}  // namespace mmcs
