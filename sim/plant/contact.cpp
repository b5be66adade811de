// SPDX-License-Identifier: Apache-2.0
// Active sets: guess which joints rest, solve the others exactly (LDL'), correct the wrong guesses,
// repeat. For a positive definite matrix this ends; a step that continues the last one needs one
// round. Unlike sweeps over the joints it leaves no residue: rest is rest.
#include "contact.h"

#include <algorithm>

namespace mmcs {

namespace {
constexpr double kSeized = 1e100;
// All wrong guesses corrected at once, nearly always enough; then one by one, which must end.
constexpr int kBlockRounds = 10;
constexpr int kSingleRounds = 200;
}  // namespace

ContactSolver::ContactSolver(int n)
    : n_(static_cast<size_t>(n)),
      mode_(n_),
      rested_(n_),
      free_(n_),
      held_(n_),
      l_(n_ * n_),
      d_(n_),
      x_(n_) {}

// Speeds of the joints that move, given those that are held.
void ContactSolver::solve_free(const double *a, const double *b, const JointBounds *bounds,
                               double *v) {
  size_t count = 0, held = 0;
  for (size_t i = 0; i < n_; ++i) {
    if (!is_held(mode_[i])) {
      free_[count++] = i;
      continue;
    }
    held_[held++] = i;
    v[i] = mode_[i] == Mode::kRest        ? 0.0
           : mode_[i] == Mode::kUpperStop ? bounds[i].speed_hi
                                          : bounds[i].speed_lo;
  }
  double *const d = d_.data(), *const x = x_.data();
  for (size_t r = 0; r < count; ++r) {
    const size_t i = free_[r];
    const double *const row = a + i * n_;
    double rest = b[i] + (mode_[i] == Mode::kPlus ? -bounds[i].slide[0] : bounds[i].slide[1]);
    for (size_t k = 0; k < held; ++k) rest -= row[held_[k]] * v[held_[k]];
    // Row r of the factor (l_ holds L D left of the diagonal until it is divided), then forward.
    double diagonal = row[i];
    double *const l = l_.data() + r * n_;
    const double *other = l_.data();
    for (size_t c = 0; c < r; ++c, other += n_) {
      double value = row[free_[c]];
      for (size_t k = 0; k < c; ++k) value -= l[k] * other[k] * d[k];
      l[c] = value / d[c];
      diagonal -= l[c] * value;
      rest -= l[c] * x[c];
    }
    d[r] = diagonal;
    x[r] = rest;
  }
  for (size_t r = count; r-- > 0;) {
    double value = x[r] / d[r];
    const double *column = l_.data() + (r + 1) * n_ + r;
    for (size_t k = r + 1; k < count; ++k, column += n_) value -= *column * x[k];
    x[r] = value;
    v[free_[r]] = value;
  }
}

// The mode that a joint contradicts by its speed, or by the impulse that holding takes, corrected.
inline ContactSolver::Mode ContactSolver::revised_free(size_t i, const JointBounds &bound,
                                                       double v) const {
  if (mode_[i] == Mode::kPlus) {
    return v < 0.0 ? Mode::kRest : v > bound.speed_hi ? Mode::kUpperStop : Mode::kPlus;
  }
  return v > 0.0 ? Mode::kRest : v < bound.speed_lo ? Mode::kLowerStop : Mode::kMinus;
}

ContactSolver::Mode ContactSolver::revised_held(size_t i, const double *a, const double *b,
                                                const JointBounds &bound, const double *v) const {
  double need = -b[i];  // negative resists positive turning
  for (size_t k = 0; k < n_; ++k) need += a[i * n_ + k] * v[k];
  const double *limit = rested_[i] != 0 ? bound.stick : bound.slide;
  Mode mode = mode_[i];
  switch (mode_[i]) {
    case Mode::kRest:
      if (need < -limit[0]) mode = Mode::kPlus;
      if (need > limit[1]) mode = Mode::kMinus;
      break;
    case Mode::kUpperStop:  // a stop only pushes back
      if (v[i] > 0.0 && need > -bound.slide[0]) mode = Mode::kPlus;
      if (v[i] <= 0.0 && need > limit[1]) mode = Mode::kMinus;
      break;
    default:
      if (v[i] < 0.0 && need < bound.slide[1]) mode = Mode::kMinus;
      if (v[i] >= 0.0 && need < -limit[0]) mode = Mode::kPlus;
  }
  return mode;
}

void ContactSolver::solve(const double *a, const double *b, const JointBounds *bounds, double *v) {
  for (size_t i = 0; i < n_; ++i) {
    rested_[i] = v[i] == 0.0 ? 1 : 0;
    // A seized joint stops at once: its bound is too large to calculate with.
    const bool rest = rested_[i] != 0 || bounds[i].slide[0] > kSeized;
    mode_[i] = rest ? Mode::kRest : v[i] > 0.0 ? Mode::kPlus : Mode::kMinus;
    if (rest && bounds[i].speed_hi == 0.0) mode_[i] = Mode::kUpperStop;
    if (rest && bounds[i].speed_lo == 0.0) mode_[i] = Mode::kLowerStop;
  }
  bool settled = false;
  for (int round = 0; !settled && round < kBlockRounds + kSingleRounds; ++round) {
    const bool single = round >= kBlockRounds;
    // Break-away above sliding friction may have no solution by small steps: then it counts as
    // broken away.
    if (round == kBlockRounds) std::fill(rested_.begin(), rested_.end(), uint8_t{0});
    ++rounds_;
    solve_free(a, b, bounds, v);
    settled = true;
    for (size_t i = 0; i < n_ && (settled || !single); ++i) {
      const Mode mode = is_held(mode_[i]) ? revised_held(i, a, b, bounds[i], v)
                                          : revised_free(i, bounds[i], v[i]);
      if (mode != mode_[i]) settled = false;
      mode_[i] = mode;
    }
  }
  for (size_t i = 0; i < n_; ++i) v[i] = std::clamp(v[i], bounds[i].speed_lo, bounds[i].speed_hi);
}

}  // namespace mmcs
