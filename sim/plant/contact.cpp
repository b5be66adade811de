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
    : n_(n),
      mode_(static_cast<size_t>(n)),
      rested_(static_cast<size_t>(n)),
      free_(static_cast<size_t>(n)),
      l_(static_cast<size_t>(n) * static_cast<size_t>(n)),
      d_(static_cast<size_t>(n)),
      x_(static_cast<size_t>(n)) {}

// Speeds of the joints that move, given those that are held.
void ContactSolver::solve_free(const double *a, const double *b, const JointBounds *bounds,
                               double *v) {
  int count = 0;
  for (int i = 0; i < n_; ++i) {
    switch (mode_[i]) {
      case Mode::kRest:
        v[i] = 0.0;
        break;
      case Mode::kUpperStop:
        v[i] = bounds[i].speed_hi;
        break;
      case Mode::kLowerStop:
        v[i] = bounds[i].speed_lo;
        break;
      default:
        free_[count++] = i;
    }
  }
  for (int r = 0; r < count; ++r) {
    const int i = free_[r];
    double rest = b[i] + (mode_[i] == Mode::kPlus ? -bounds[i].slide[0] : bounds[i].slide[1]);
    for (int k = 0; k < n_; ++k) {
      if (held(mode_[k])) rest -= a[i * n_ + k] * v[k];
    }
    // Row r of the factor (l_ holds L D left of the diagonal until it is divided), then forward.
    double diagonal = a[i * n_ + i];
    for (int c = 0; c < r; ++c) {
      double value = a[i * n_ + free_[c]];
      for (int k = 0; k < c; ++k) value -= l_[r * n_ + k] * l_[c * n_ + k] * d_[k];
      l_[r * n_ + c] = value / d_[c];
      diagonal -= l_[r * n_ + c] * value;
      rest -= l_[r * n_ + c] * x_[c];
    }
    d_[r] = diagonal;
    x_[r] = rest;
  }
  for (int r = count; r-- > 0;) {
    double value = x_[r] / d_[r];
    for (int k = r + 1; k < count; ++k) value -= l_[k * n_ + r] * x_[k];
    x_[r] = value;
    v[free_[r]] = value;
  }
}

// Whether joint i contradicts its mode; then the mode is corrected.
bool ContactSolver::revise(int i, const double *a, const double *b, const JointBounds &bound,
                           const double *v) {
  const Mode before = mode_[i];
  if (!held(before)) {
    const bool plus = before == Mode::kPlus;
    if (plus ? v[i] < 0.0 : v[i] > 0.0) {
      mode_[i] = Mode::kRest;
    } else if (plus && v[i] > bound.speed_hi) {
      mode_[i] = Mode::kUpperStop;
    } else if (!plus && v[i] < bound.speed_lo) {
      mode_[i] = Mode::kLowerStop;
    }
    return mode_[i] != before;
  }
  // The impulse that holding takes; negative resists positive turning.
  double need = -b[i];
  for (int k = 0; k < n_; ++k) need += a[i * n_ + k] * v[k];
  const double *limit = rested_[i] != 0 ? bound.stick : bound.slide;
  switch (before) {
    case Mode::kRest:
      if (need < -limit[0]) mode_[i] = Mode::kPlus;
      if (need > limit[1]) mode_[i] = Mode::kMinus;
      break;
    case Mode::kUpperStop:  // a stop only pushes back
      if (v[i] > 0.0 && need > -bound.slide[0]) mode_[i] = Mode::kPlus;
      if (v[i] <= 0.0 && need > limit[1]) mode_[i] = Mode::kMinus;
      break;
    default:
      if (v[i] < 0.0 && need < bound.slide[1]) mode_[i] = Mode::kMinus;
      if (v[i] >= 0.0 && need < -limit[0]) mode_[i] = Mode::kPlus;
  }
  return mode_[i] != before;
}

void ContactSolver::solve(const double *a, const double *b, const JointBounds *bounds, double *v) {
  for (int i = 0; i < n_; ++i) {
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
    for (int i = 0; i < n_ && (settled || !single); ++i) {
      if (revise(i, a, b, bounds[i], v)) settled = false;
    }
  }
  for (int i = 0; i < n_; ++i) v[i] = std::clamp(v[i], bounds[i].speed_lo, bounds[i].speed_hi);
}

}  // namespace mmcs
