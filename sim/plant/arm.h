// SPDX-License-Identifier: Apache-2.0
// Rigid-body dynamics of a serial arm with revolute joints, standard Denavit-Hartenberg.
//
// All vectors are written in the base frame about the base's origin: there the inertias of links
// simply add up, so that the composite bodies of the mass matrix need no transformations.
#pragma once

#include <vector>

#include "mmcs_sim.h"

namespace mmcs {

struct Vec3 {
  double x, y, z;
};

// Symmetric 3x3: xx yy zz xy yz xz.
struct Sym3 {
  double xx, yy, zz, xy, yz, xz;
};

// Mass, first moment and second moment about the base's origin.
struct BodyInertia {
  double m;
  Vec3 h;
  Sym3 i;
};

// A spatial vector: angular part, linear part at the base's origin.
struct Spatial {
  Vec3 w, v;
};

class Arm {
 public:
  Arm(const mmcs_link *links, int count, const double gravity[3]);

  int joints() const { return static_cast<int>(links_.size()); }
  // Places the links for the joint angles q; the two functions below refer to this pose.
  void pose(const double *q);
  // Joint torques for these speeds and accelerations, gravity included (qdd null: zero).
  void inverse_dynamics(const double *qd, const double *qdd, double *tau) const;
  // Mass matrix, row-major.
  void mass_matrix(double *m) const;
  // Origin of the last frame.
  Vec3 tip() const { return tip_; }

 private:
  struct Link {
    double sin_alpha, cos_alpha, a, d, theta0, mass;
    Vec3 com;
    Sym3 inertia;
  };

  std::vector<Link> links_;
  std::vector<Spatial> axis_;      // unit twist of each joint
  std::vector<BodyInertia> body_;  // each link in the pose
  mutable std::vector<Spatial> force_;
  Vec3 gravity_;
  Vec3 tip_ = {0, 0, 0};
};

}  // namespace mmcs
