// SPDX-License-Identifier: Apache-2.0
// Rigid-body dynamics of a serial arm with revolute joints, standard Denavit-Hartenberg.
//
// All vectors are written in the base frame about the base's origin: there the inertias of links
// simply add up, so that the composite bodies of the mass matrix need no transformations.
#pragma once

#include <vector>

#include "maths.h"
#include "mmcs_sim.h"

namespace mmcs {

template <class T>
struct Vec3 {
  T x, y, z;
};

// Symmetric 3x3: xx yy zz xy yz xz.
template <class T>
struct Sym3 {
  T xx, yy, zz, xy, yz, xz;
};

// Mass, first moment and second moment about the base's origin.
template <class T>
struct BodyInertia {
  T m;
  Vec3<T> h;
  Sym3<T> i;
};

// A spatial vector: angular part, linear part at the base's origin.
template <class T>
struct Spatial {
  Vec3<T> w, v;
};

// Links are calculated two by two, the even one first, in all that does not go from link to link.
class Arm {
 public:
  Arm(const mmcs_link *links, int count, const double gravity[3]);

  int joints() const { return static_cast<int>(links_.size()); }
  // Places the links for the joint angles q; the two functions below refer to this pose. False: it
  // is the pose of before.
  bool pose(const double *q);
  // Joint torques for these speeds and accelerations, gravity included (qdd null: zero).
  void inverse_dynamics(const double *qd, const double *qdd, double *tau);
  // Mass matrix, row-major.
  void mass_matrix(double *m);
  // Origin of the last frame.
  Vec3<double> tip() const { return tip_; }

 private:
  struct Link {
    double sin_alpha, cos_alpha, a, d, theta0;
  };
  struct Pair {
    Two mass;
    Vec3<Two> com;
    Sym3<Two> inertia;
    // in the pose: axis of the joint and a point of it, the frame behind it, its unit twist, the
    // link
    Vec3<Two> up, base, x, y, z, origin;
    Spatial<Two> axis;
    BodyInertia<Two> body;
    Spatial<Two> force;  // of the last inverse_dynamics()
  };

  std::vector<Link> links_;
  std::vector<double> angles_;  // in the pose
  std::vector<Pair> pairs_;
  Vec3<double> gravity_;
  Vec3<double> tip_ = {0, 0, 0};
};

}  // namespace mmcs
