// SPDX-License-Identifier: Apache-2.0
// Control design, §2.5: gains to D(z) by each method, and D(z) to the integers of the driver.

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "json.h"
#include "mmcs_service.h"

namespace {
namespace design {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLargest = 2147483647;
constexpr double kSmallestIntegral = 20;  // S*I*T below this rounds the integral away
constexpr double kGoodRounding = 1e-3;    // of the gain, up to half the Nyquist frequency
constexpr double kKick = 1024;
constexpr int kFrequencies = 60, kMostBits = 30;

using List = std::vector<double>;  // coefficients in powers of q = 1/z
struct Discrete {
  List num, den;
};
struct Gains {
  double p, i, d, tau;
};
struct Impossible : std::runtime_error {
  using std::runtime_error::runtime_error;
};
constexpr const char *kNoNumber = "a number is out of all proportion";

List sum(List a, const List &b) {
  a.resize(std::max(a.size(), b.size()));
  for (size_t n = 0; n < b.size(); ++n) a[n] += b[n];
  return a;
}
double total(const List &list) {
  return std::accumulate(list.begin(), list.end(), 0.);
}
List product(const List &a, const List &b) {
  List made(a.size() + b.size() - 1);
  for (size_t n = 0; n < a.size(); ++n)
    for (size_t k = 0; k < b.size(); ++k) made[n + k] += a[n] * b[k];
  return made;
}
Discrete sum(const Discrete &a, const Discrete &b) {
  if (a.den == b.den) return {sum(a.num, b.num), a.den};
  return {sum(product(a.num, b.den), product(b.num, a.den)), product(a.den, b.den)};
}
Discrete monic(List num, List den) {
  const double first = den[0];
  for (List *list : {&num, &den})
    for (double &v : *list) v /= first;
  while (den.back() == 0) den.pop_back();
  return {num, den};
}

// --- continuous to discrete ---

// s = k (1 - q)/(1 + m q), term by term, so that an absent term leaves no factor behind.
Discrete substituted(const Gains &c, double k, double m) {
  Discrete made{{c.p}, {1}};
  if (c.i != 0) made = sum(made, monic({c.i, c.i * m}, {k, -k}));
  if (c.d != 0) made = sum(made, monic({c.d * k, -c.d * k}, {c.tau * k + 1, -c.tau * k + m}));
  return made;
}

// Zeros and poles to exp(sT); gain by the slowest term (DC, or the integral).
Discrete matched(const Gains &c, double t) {
  const double pole = c.d != 0 && c.tau != 0 ? std::exp(-t / c.tau) : 0;
  const List filter = pole != 0 ? List{1, -pole} : List{1};
  if (c.i != 0 && c.d != 0) {
    const double two = c.p * c.tau + c.d, one = c.p + c.i * c.tau;
    const std::complex<double> root = std::sqrt(std::complex<double>(one * one - 4 * two * c.i));
    const std::complex<double> far = -0.5 * (one < 0 ? one - root : one + root);
    const std::complex<double> z = std::exp(c.i / far * t);
    const std::complex<double> other = two != 0 ? std::exp(far / two * t) : 0;
    const double gain = c.i * t * (1 - pole) / ((1. - z) * (1. - other)).real();
    List num = {gain, -gain * (z + other).real(), gain * (z * other).real()};
    if (two == 0) num.pop_back();
    return {num, product({1, -1}, filter)};
  }
  if (c.i != 0) {
    if (c.p == 0) return {{c.i * t}, {1, -1}};
    const double zero = std::exp(-c.i * t / c.p), gain = c.i * t / (1 - zero);
    return {{gain, -gain * zero}, {1, -1}};
  }
  if (c.d == 0) return {{c.p}, {1}};
  if (c.p == 0) throw Impossible{"matched: a pure D has no gain at DC to match; take backward"};
  const double zero = std::exp(-c.p * t / (c.d + c.p * c.tau)),
               gain = c.p * (1 - pole) / (1 - zero);
  return {{gain, -gain * zero}, filter};
}

// The step's response, or for ztransform the impulse's, is kept.
Discrete sampled(const Gains &c, double t, const std::string &method) {
  if (c.d != 0 && c.tau == 0)
    throw Impossible{method + ": P" + (c.i != 0 ? "I" : "") +
                     "D is improper (more zeros than poles), so the transform does not exist; give "
                     "a derivative filter, or take backward or matched"};
  const bool impulse = method == "ztransform";
  if (impulse && c.d != 0)
    throw Impossible{
        "ztransform: sampling the impulse response of a derivative filter gives a wrong DC gain "
        "(even its sign); take backward or matched"};
  Discrete made{{c.p}, {1}};
  if (c.i != 0) made = sum(made, {impulse ? List{c.i * t} : List{0, c.i * t}, {1, -1}});
  if (c.d != 0) made = sum(made, {{c.d / c.tau, -c.d / c.tau}, {1, -std::exp(-t / c.tau)}});
  return made;
}

Discrete discrete(const Gains &c, const std::string &method, double t, double prewarp) {
  const std::string all = "backward, bilinear, prewarp, matched, ztransform, zoh";
  if ((", " + all + ",").find(", " + method + ",") == std::string::npos)
    throw Impossible{"no such method '" + method + "'; allowed: " + all};
  if (t <= 0) throw Impossible{"the interval " + printed("%g", t) + " s must be positive"};
  if (c.tau < 0)
    throw Impossible{"tau = " + printed("%g", c.tau) + ": a filter time constant is not negative"};
  if (method == "backward") return substituted(c, 1 / t, 0);
  if (method == "bilinear") return substituted(c, 2 / t, 1);
  if (method == "matched") return matched(c, t);
  if (method != "prewarp") return sampled(c, t, method);
  if (!(prewarp * t > 0 && prewarp * t < kPi))
    throw Impossible{"prewarp = " + printed("%g", prewarp) + " rad/s: take one between 0 and " +
                     printed("%.6g", kPi / t)};
  return substituted(c, prewarp / std::tan(prewarp * t / 2), 1);
}

// --- integers ---

struct Integers {
  std::vector<int> a, b;
  double gain_error;
  std::vector<std::string> warnings;
};

std::complex<double> at(const Discrete &d, std::complex<double> q) {
  std::complex<double> num = 0, den = 0;
  for (size_t n = d.num.size(); n-- > 0;) num = num * q + d.num[n];
  for (size_t n = d.den.size(); n-- > 0;) den = den * q + d.den[n];
  return num / den;
}

// Largest |made/d - 1| below half the Nyquist frequency.
double gain_error(const Discrete &d, const Discrete &made) {
  double most = 0;
  for (int n = 0; n < kFrequencies; ++n) {
    const auto q = std::polar(1., -kPi * 1e-3 * std::pow(500, n / (kFrequencies - 1.)));
    const std::complex<double> wanted = at(d, q);
    if (wanted != 0.) most = std::max(most, std::abs(at(made, q) - wanted) / std::abs(wanted));
  }
  return most;
}

Integers scaled(const Discrete &d, double s) {
  List num = d.num, den = d.den, a, b;
  for (auto [from, to] : {std::pair(&num, &a), std::pair(&den, &b)}) {
    from->resize(3);
    for (double &v : *from) to->push_back(std::nearbyint(v *= s));
    if (!std::isfinite(total(*from))) throw Impossible{kNoNumber};
  }
  const double sum = total(num);
  std::vector<std::string> warnings;
  if (std::fabs(total(den)) < 1e-9 * s) {  // a pole at z = 1: it must stay there, with its gain
    b[1] = -b[0] - b[2];
    a[1] = std::nearbyint(sum) - a[0] - a[2];
    if (std::fabs(sum) < kSmallestIntegral)
      warnings.push_back("S*I*T = " + printed("%.3g", sum) + " rounds the integral to " +
                         whole(std::nearbyint(sum) + 0.) + "; take a larger scale");
  }
  double all = 0;
  for (size_t n = 0; n < 3; all += std::fabs(a[n++]))
    if (std::max(std::fabs(a[n]), std::fabs(b[n])) > kLargest)
      throw Impossible{"scale = " + whole(s) + ": a coefficient exceeds 32 bits; take " +
                       (s > 1 ? "a smaller scale" : "smaller gains")};
  if (all * 65535 > kLargest)
    warnings.push_back(
        "a full-range error overflows 32-bit sums (a host of 1989); ours are 64-bit");
  const double error = gain_error(d, {a, b});
  if (error >= kGoodRounding)
    warnings.push_back("rounding changes the gain by up to " + printed("%.2g", 100 * error) + " %");
  const double square = den[1] * den[1] - 4 * den[0] * den[2];
  for (const double sign : {1, -1}) {
    const double pole = (-den[1] + sign * std::sqrt(std::max(square, 0.))) / (2 * den[0]);
    if (square >= -4e-18 * s * s && pole < -0.9)
      warnings.push_back(
          "pole at z = " + printed("%.3g", pole) +
          ": the loop rings with double-buffered D/As; take the backward difference");
  }
  return {{a.begin(), a.end()}, {b.begin(), b.end()}, error, warnings};
}

// At this scale b0; or at the smallest power of two that keeps the gain error under 0.1 %, else the
// best one. An integral stays one, with its gain exact to rounding.
Integers integers(const Discrete &d, const int64_t *scale) {
  if (d.num.size() > 3 || d.den.size() > 3) throw Impossible{"the compensator has order 2 at most"};
  if (d.num.empty() || d.den.empty() || d.den[0] != 1) throw Impossible{"D(z): den begins with 1"};
  if (scale && (*scale < 1 || *scale > int64_t{1} << kMostBits))
    throw Impossible{"scale = " + std::to_string(*scale) +
                     ": take 1 to 1073741824, best a power of two"};
  if (scale) return scaled(d, static_cast<double>(*scale));
  Integers best = scaled(d, 1);
  try {
    for (int bits = 0; bits <= kMostBits; ++bits) {
      Integers found = scaled(d, std::ldexp(1, bits));
      const auto weak = [](const std::string &one) { return one[0] == 'S'; };  // the integral
      if (found.gain_error < kGoodRounding &&
          std::none_of(found.warnings.begin(), found.warnings.end(), weak))
        return found;
      if (found.gain_error < best.gain_error) best = found;
    }
  } catch (const Impossible &) {
    return best;
  }
  return best;
}

template <class F>
const char *told(F make) {
  static thread_local std::string said;
  try {
    said = object(make());
  } catch (const Impossible &no) {
    said = object(fields("error", no.what()));
  }
  return said.c_str();
}

}  // namespace design
}  // namespace

extern "C" {

const char *mmcs_design_discrete(const double *g, const char *method, double t, double prewarp) {
  return design::told([&] {
    const auto [num, den] = design::discrete({g[0], g[1], g[2], g[3]}, method, t, prewarp);
    if (!std::isfinite(design::total(num) + design::total(den)))
      throw design::Impossible{design::kNoNumber};
    return fields("num", num, "den", den);
  });
}

const char *mmcs_design_integers(const double *num, int32_t nums, const double *den, int32_t dens,
                                 const int64_t *scale) {
  return design::told([&] {
    const auto made = design::integers({{num, num + nums}, {den, den + dens}}, scale);
    return fields("a", made.a, "b", made.b, "gain_error", made.gain_error, "warnings",
                  made.warnings);
  });
}

const char *mmcs_design_answer(const double *g, double t) {
  return design::told([&] {
    const auto wanted = design::discrete({g[0], g[1], g[2], g[3]}, "backward", t, 0);
    auto made = design::integers(wanted, nullptr);
    const double kick = std::fabs(1. * made.a[0] / made.b[0]);
    if (kick > design::kKick)
      made.warnings.push_back("one count commands " + whole(kick) +
                              " D/A units: a tick of noise is a blow");
    const std::vector<int> &a = made.a, &b = made.b;
    const Made named = {
        object(fields("a0", a[0], "a1", a[1], "a2", a[2], "b0", b[0], "b1", b[1], "b2", b[2]))};
    return fields("coefficients", named, "warnings", made.warnings, "gain_error", made.gain_error);
  });
}

}  // extern "C"
