// SPDX-License-Identifier: Apache-2.0
// Recursive Newton-Euler and composite rigid bodies, see arm.h.
#include "arm.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

namespace mmcs {

namespace {

template <class T>
Vec3<T> operator+(const Vec3<T> &a, const Vec3<T> &b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class K, class T>
Vec3<T> operator*(K k, const Vec3<T> &a) {
  return {k * a.x, k * a.y, k * a.z};
}
template <class T>
T dot(const Vec3<T> &a, const Vec3<T> &b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Vec3<T> cross(const Vec3<T> &a, const Vec3<T> &b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
[[gnu::always_inline]] inline Vec3<T> operator*(const Sym3<T> &s, const Vec3<T> &a) {
  return {s.xx * a.x + s.xy * a.y + s.xz * a.z, s.xy * a.x + s.yy * a.y + s.yz * a.z,
          s.xz * a.x + s.yz * a.y + s.zz * a.z};
}

template <class T>
T dot(const Spatial<T> &a, const Spatial<T> &b) {
  return dot(a.w, b.w) + dot(a.v, b.v);
}
template <class T>
Spatial<T> operator+(const Spatial<T> &a, const Spatial<T> &b) {
  return {a.w + b.w, a.v + b.v};
}
BodyInertia<double> operator+(const BodyInertia<double> &a, const BodyInertia<double> &b) {
  return {a.m + b.m,
          a.h + b.h,
          {a.i.xx + b.i.xx, a.i.yy + b.i.yy, a.i.zz + b.i.zz, a.i.xy + b.i.xy, a.i.yz + b.i.yz,
           a.i.xz + b.i.xz}};
}

uint64_t bits(double value) {
  uint64_t b;
  std::memcpy(&b, &value, sizeof b);
  return b;
}

// One link of two.
Vec3<double> get(const Vec3<Two> &v, size_t n) {
  return {v.x[n], v.y[n], v.z[n]};
}
Spatial<double> get(const Spatial<Two> &s, size_t n) {
  return {get(s.w, n), get(s.v, n)};
}
BodyInertia<double> get(const BodyInertia<Two> &b, size_t n) {
  return {b.m[n], get(b.h, n), {b.i.xx[n], b.i.yy[n], b.i.zz[n], b.i.xy[n], b.i.yz[n], b.i.xz[n]}};
}
void set(Vec3<Two> &to, size_t n, const Vec3<double> &v) {
  to.x[n] = v.x, to.y[n] = v.y, to.z[n] = v.z;
}
void set(Sym3<Two> &to, size_t n, const Sym3<double> &s) {
  to.xx[n] = s.xx, to.yy[n] = s.yy, to.zz[n] = s.zz;
  to.xy[n] = s.xy, to.yz[n] = s.yz, to.xz[n] = s.xz;
}
void set(Spatial<Two> &to, size_t n, const Spatial<double> &s) {
  set(to.w, n, s.w), set(to.v, n, s.v);
}
// The same for both.
Vec3<Two> both(const Vec3<double> &v) {
  return {Two{v.x, v.x}, Two{v.y, v.y}, Two{v.z, v.z}};
}
Spatial<Two> both(const Spatial<double> &s) {
  return {both(s.w), both(s.v)};
}
Vec3<Two> both(const Vec3<double> &a, const Vec3<double> &b) {
  return {Two{a.x, b.x}, Two{a.y, b.y}, Two{a.z, b.z}};
}
BodyInertia<Two> both(const BodyInertia<double> &a, const BodyInertia<double> &b) {
  return {Two{a.m, b.m},
          both(a.h, b.h),
          {Two{a.i.xx, b.i.xx}, Two{a.i.yy, b.i.yy}, Two{a.i.zz, b.i.zz}, Two{a.i.xy, b.i.xy},
           Two{a.i.yz, b.i.yz}, Two{a.i.xz, b.i.xz}}};
}
// The sum on from link to link.
Two running(double &sum, Two step) {
  const double first = sum + step[0];
  sum = first + step[1];
  return Two{first, sum};
}
Vec3<Two> running(Vec3<double> &sum, const Vec3<Two> &step) {
  return {running(sum.x, step.x), running(sum.y, step.y), running(sum.z, step.z)};
}
Spatial<Two> running(Spatial<double> &sum, const Spatial<Two> &step) {
  return {running(sum.w, step.w), running(sum.v, step.v)};
}

// Momentum of a body that moves with this twist (or force, if it is an acceleration).
template <class T>
[[gnu::always_inline]] inline Spatial<T> times(const BodyInertia<T> &b, const Spatial<T> &t) {
  return {b.i * t.w + cross(b.h, t.v), b.m * t.v + cross(t.w, b.h)};
}

// R J R' for R with columns x, y, z, about the base's origin for mass m at c.
template <class T>
BodyInertia<T> place(T m, const Vec3<T> &c, const Sym3<T> &j, const Vec3<T> &x, const Vec3<T> &y,
                     const Vec3<T> &z) {
  // The columns of R J; the outer products with R follow.
  const Vec3<T> u = j.xx * x + (j.xy * y + j.xz * z);
  const Vec3<T> v = j.xy * x + (j.yy * y + j.yz * z);
  const Vec3<T> w = j.xz * x + (j.yz * y + j.zz * z);
  const Vec3<T> h = m * c;
  const T cc = dot(h, c);
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
    : angles_(static_cast<size_t>(count), std::numeric_limits<double>::quiet_NaN()),
      pairs_((static_cast<size_t>(count) + 1) / 2),
      gravity_{gravity[0], gravity[1], gravity[2]} {
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const mmcs_link &l = links[i];
    Link link = {0, 0, l.a, l.d, l.theta0};
    sin_cos(l.alpha, link.sin_alpha, link.cos_alpha);
    links_.push_back(link);
    Pair &pair = pairs_[i / 2];
    pair.mass[i % 2] = l.mass;
    set(pair.com, i % 2, {l.com[0], l.com[1], l.com[2]});
    set(pair.inertia, i % 2,
        {l.inertia[0], l.inertia[1], l.inertia[2], l.inertia[3], l.inertia[4], l.inertia[5]});
  }
}

bool Arm::pose(const double *q) {
  const size_t n = links_.size();
  size_t first = 0;  // the links before it stand where they stood, to the bit
  while (first < n && bits(q[first]) == bits(angles_[first])) ++first;
  if (first == n) return false;
  std::copy(q, q + n, angles_.data());
  Vec3<double> x = {1, 0, 0};
  Vec3<double> y = {0, 1, 0};
  Vec3<double> z = {0, 0, 1};
  Vec3<double> p = {0, 0, 0};
  if (first > 0) {
    const Pair &before = pairs_[(first - 1) / 2];
    const size_t side = (first - 1) % 2;
    x = get(before.x, side), y = get(before.y, side), z = get(before.z, side);
    p = get(before.origin, side);
  }
  for (size_t i = first; i < n; ++i) {
    const Link &l = links_[i];
    Pair &pair = pairs_[i / 2];
    set(pair.up, i % 2, z);
    set(pair.base, i % 2, p);
    double s;
    double c;
    sin_cos(q[i] + l.theta0, s, c);
    const Vec3<double> turned = c * y + (-s) * x;
    x = c * x + s * y;
    y = l.cos_alpha * turned + l.sin_alpha * z;
    const Vec3<double> up = z;
    z = l.cos_alpha * z + (-l.sin_alpha) * turned;
    p = p + (l.d * up + l.a * x);
    set(pair.x, i % 2, x);
    set(pair.y, i % 2, y);
    set(pair.z, i % 2, z);
    set(pair.origin, i % 2, p);
  }
  for (size_t i = first / 2; i < pairs_.size(); ++i) {
    Pair &pair = pairs_[i];
    pair.axis = {pair.up, cross(pair.base, pair.up)};
    const Vec3<Two> com =
        pair.origin + (pair.com.x * pair.x + (pair.com.y * pair.y + pair.com.z * pair.z));
    pair.body = place(pair.mass, com, pair.inertia, pair.x, pair.y, pair.z);
  }
  tip_ = p;
  return true;
}

void Arm::inverse_dynamics(const double *qd, const double *qdd, double *tau) {
  const size_t n = links_.size();
  Spatial<double> vel = {{0, 0, 0}, {0, 0, 0}};
  // A base that accelerates upward feels like gravity.
  Spatial<double> acc = {{0, 0, 0}, -1.0 * gravity_};
  for (size_t i = 0; i < n; i += 2) {
    Pair &pair = pairs_[i / 2];
    const Two rate = {qd[i], i + 1 < n ? qd[i + 1] : 0.0};
    const Spatial<Two> turn = {rate * pair.axis.w, rate * pair.axis.v};
    const Spatial<Two> v = running(vel, turn);
    // The joint's axis is carried along by the link: its rate of change is vel x axis.
    const Spatial<Two> carried = {cross(v.w, turn.w), cross(v.w, turn.v) + cross(v.v, turn.w)};
    Spatial<Two> a;
    if (qdd == nullptr) {
      a = running(acc, carried);
    } else {
      for (size_t side = 0; side < 2 && i + side < n; ++side) {
        const Spatial<double> s = get(pair.axis, side);
        acc = acc + get(carried, side) + Spatial<double>{qdd[i + side] * s.w, qdd[i + side] * s.v};
        set(a, side, acc);
      }
    }
    const Spatial<Two> momentum = times(pair.body, v);
    pair.force = times(pair.body, a) + Spatial<Two>{cross(v.w, momentum.w) + cross(v.v, momentum.v),
                                                    cross(v.w, momentum.v)};
  }
  Spatial<double> force = get(pairs_[(n - 1) / 2].force, (n - 1) % 2);
  for (size_t i = n - 1; i-- > 0;) {
    force = get(pairs_[i / 2].force, i % 2) + force;
    set(pairs_[i / 2].force, i % 2, force);
  }
  for (size_t i = 0; i < n; i += 2) {
    const Two torques = dot(pairs_[i / 2].axis, pairs_[i / 2].force);
    tau[i] = torques[0];
    if (i + 1 < n) tau[i + 1] = torques[1];
  }
}

void Arm::mass_matrix(double *m) {
  const size_t n = links_.size();
  BodyInertia<double> sum = {0, {0, 0, 0}, {0, 0, 0, 0, 0, 0}};
  for (size_t p = pairs_.size(); p-- > 0;) {
    const size_t i = 2 * p;
    const BodyInertia<double> second = sum + get(pairs_[p].body, 1);
    sum = second + get(pairs_[p].body, 0);
    const Spatial<Two> forces = times(both(sum, second), pairs_[p].axis);
    const Spatial<Two> first_force = both(get(forces, 0)), second_force = both(get(forces, 1));
    double *const row = m + i * n, *const next = row + n;
    for (size_t j = 0; j < i; j += 2) {
      const Two first = dot(pairs_[j / 2].axis, first_force);
      row[j] = m[j * n + i] = first[0];
      row[j + 1] = m[(j + 1) * n + i] = first[1];
      if (i + 1 == n) continue;
      const Two other = dot(pairs_[j / 2].axis, second_force);
      next[j] = m[j * n + i + 1] = other[0];
      next[j + 1] = m[(j + 1) * n + i + 1] = other[1];
    }
    row[i] = dot(pairs_[p].axis, first_force)[0];
    if (i + 1 == n) continue;
    const Two last = dot(pairs_[p].axis, second_force);
    next[i] = row[i + 1] = last[0];
    next[i + 1] = last[1];
  }
}

}  // namespace mmcs
