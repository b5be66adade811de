// SPDX-License-Identifier: Apache-2.0
// Recursive Newton-Euler and composite rigid bodies, see arm.h.
#include "arm.h"

#include "maths.h"

namespace mmcs {

namespace {

Vec3 operator+(const Vec3 &a, const Vec3 &b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Vec3 operator*(double k, const Vec3 &a) {
  return {k * a.x, k * a.y, k * a.z};
}
double dot(const Vec3 &a, const Vec3 &b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vec3 cross(const Vec3 &a, const Vec3 &b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vec3 operator*(const Sym3 &s, const Vec3 &a) {
  return {s.xx * a.x + s.xy * a.y + s.xz * a.z, s.xy * a.x + s.yy * a.y + s.yz * a.z,
          s.xz * a.x + s.yz * a.y + s.zz * a.z};
}

double dot(const Spatial &a, const Spatial &b) {
  return dot(a.w, b.w) + dot(a.v, b.v);
}
void add(Spatial &a, const Spatial &b) {
  a.w = a.w + b.w;
  a.v = a.v + b.v;
}
void add(BodyInertia &a, const BodyInertia &b) {
  a.m += b.m;
  a.h = a.h + b.h;
  a.i = {a.i.xx + b.i.xx, a.i.yy + b.i.yy, a.i.zz + b.i.zz,
         a.i.xy + b.i.xy, a.i.yz + b.i.yz, a.i.xz + b.i.xz};
}

// Momentum of a body that moves with this twist (or force, if it is an acceleration).
Spatial times(const BodyInertia &b, const Spatial &t) {
  return {b.i * t.w + cross(b.h, t.v), b.m * t.v + cross(t.w, b.h)};
}

// R J R' for R with columns x, y, z, about the base's origin for mass m at c.
BodyInertia place(double m, const Vec3 &c, const Sym3 &j, const Vec3 &x, const Vec3 &y,
                  const Vec3 &z) {
  // The columns of R J; the outer products with R follow.
  const Vec3 u = j.xx * x + (j.xy * y + j.xz * z);
  const Vec3 v = j.xy * x + (j.yy * y + j.yz * z);
  const Vec3 w = j.xz * x + (j.yz * y + j.zz * z);
  const Vec3 h = m * c;
  const double cc = dot(h, c);
  return {
      m,
      h,
      {u.x * x.x + v.x * y.x + w.x * z.x + (cc - h.x * c.x),
       u.y * x.y + v.y * y.y + w.y * z.y + (cc - h.y * c.y),
       u.z * x.z + v.z * y.z + w.z * z.z + (cc - h.z * c.z),
       u.x * x.y + v.x * y.y + w.x * z.y - h.x * c.y, u.y * x.z + v.y * y.z + w.y * z.z - h.y * c.z,
       u.x * x.z + v.x * y.z + w.x * z.z - h.x * c.z}};
}

}  // namespace

Arm::Arm(const mmcs_link *links, int count, const double gravity[3])
    : axis_(count), body_(count), force_(count), gravity_{gravity[0], gravity[1], gravity[2]} {
  for (int i = 0; i < count; ++i) {
    const mmcs_link &l = links[i];
    Link link = {
        0,
        0,
        l.a,
        l.d,
        l.theta0,
        l.mass,
        {l.com[0], l.com[1], l.com[2]},
        {l.inertia[0], l.inertia[1], l.inertia[2], l.inertia[3], l.inertia[4], l.inertia[5]}};
    sin_cos(l.alpha, link.sin_alpha, link.cos_alpha);
    links_.push_back(link);
  }
}

void Arm::pose(const double *q) {
  Vec3 x = {1, 0, 0};
  Vec3 y = {0, 1, 0};
  Vec3 z = {0, 0, 1};
  Vec3 p = {0, 0, 0};
  for (size_t i = 0; i < links_.size(); ++i) {
    const Link &l = links_[i];
    axis_[i] = {z, cross(p, z)};
    double s;
    double c;
    sin_cos(q[i] + l.theta0, s, c);
    const Vec3 turned = c * y + (-s) * x;
    x = c * x + s * y;
    y = l.cos_alpha * turned + l.sin_alpha * z;
    const Vec3 up = z;
    z = l.cos_alpha * z + (-l.sin_alpha) * turned;
    p = p + (l.d * up + l.a * x);
    const Vec3 com = p + (l.com.x * x + (l.com.y * y + l.com.z * z));
    body_[i] = place(l.mass, com, l.inertia, x, y, z);
  }
  tip_ = p;
}

void Arm::inverse_dynamics(const double *qd, const double *qdd, double *tau) const {
  Spatial vel = {{0, 0, 0}, {0, 0, 0}};
  // A base that accelerates upward feels like gravity.
  Spatial acc = {{0, 0, 0}, -1.0 * gravity_};
  for (size_t i = 0; i < links_.size(); ++i) {
    const Spatial &s = axis_[i];
    const Spatial turn = {qd[i] * s.w, qd[i] * s.v};
    add(vel, turn);
    // The joint's axis is carried along by the link: its rate of change is vel x axis.
    add(acc, {cross(vel.w, turn.w), cross(vel.w, turn.v) + cross(vel.v, turn.w)});
    if (qdd != nullptr) add(acc, {qdd[i] * s.w, qdd[i] * s.v});
    const Spatial momentum = times(body_[i], vel);
    force_[i] = times(body_[i], acc);
    add(force_[i], {cross(vel.w, momentum.w) + cross(vel.v, momentum.v), cross(vel.w, momentum.v)});
  }
  for (size_t i = links_.size(); i-- > 0;) {
    tau[i] = dot(axis_[i], force_[i]);
    if (i > 0) add(force_[i - 1], force_[i]);
  }
}

void Arm::mass_matrix(double *m) const {
  const size_t n = links_.size();
  BodyInertia composite = {0, {0, 0, 0}, {0, 0, 0, 0, 0, 0}};
  for (size_t i = n; i-- > 0;) {
    add(composite, body_[i]);
    const Spatial f = times(composite, axis_[i]);
    for (size_t j = 0; j <= i; ++j) m[i * n + j] = m[j * n + i] = dot(axis_[j], f);
  }
}

}  // namespace mmcs
