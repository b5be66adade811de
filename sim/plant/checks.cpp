// SPDX-License-Identifier: Apache-2.0
// Parameter checks, see checks.h.
#include "checks.h"

#include <stdexcept>
#include <string>

#include "axis.h"
#include "maths.h"
#include "stiff.h"

namespace mmcs {

namespace {

constexpr int kMaxAxes = 32;

[[noreturn]] void refuse(const std::string &text) {
  throw std::invalid_argument(text);
}

std::string shown(double value) {
  std::string text = std::to_string(value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

bool finite(double x) {
  return __builtin_isfinite(x);
}

struct Field {
  const char *name;
  double mmcs_motor::*member;
};

constexpr Field kNotNegative[] = {{"viscous", &mmcs_motor::viscous},
                                  {"coulomb_pos", &mmcs_motor::coulomb_pos},
                                  {"coulomb_neg", &mmcs_motor::coulomb_neg},
                                  {"v_supply", &mmcs_motor::v_supply},
                                  {"amp_max", &mmcs_motor::amp_max},
                                  {"amp_tau", &mmcs_motor::amp_tau},
                                  {"brake_torque", &mmcs_motor::brake_torque},
                                  {"brake_delay", &mmcs_motor::brake_delay},
                                  {"brake_release_delay", &mmcs_motor::brake_release_delay},
                                  {"stiffness", &mmcs_motor::stiffness},
                                  {"damping", &mmcs_motor::damping},
                                  {"backlash", &mmcs_motor::backlash}};
constexpr Field kPositive[] = {{"inertia", &mmcs_motor::inertia},
                               {"km", &mmcs_motor::km},
                               {"resistance", &mmcs_motor::resistance}};
constexpr Field kAnyNumber[] = {{"amp_gain", &mmcs_motor::amp_gain},
                                {"gear", &mmcs_motor::gear},
                                {"stop_lo", &mmcs_motor::stop_lo},
                                {"stop_hi", &mmcs_motor::stop_hi},
                                {"pot_v_per_rad", &mmcs_motor::pot_v_per_rad},
                                {"pot_offset", &mmcs_motor::pot_offset},
                                {"angle0", &mmcs_motor::angle0},
                                {"gravity", &mmcs_motor::gravity},
                                {"load_inertia", &mmcs_motor::load_inertia},
                                {"encoder_offset", &mmcs_motor::encoder_offset}};

void check_values(const std::string &axis, const mmcs_motor &m) {
  for (const Field &f : kNotNegative) {
    if (!(m.*f.member >= 0.0) || !finite(m.*f.member)) {
      refuse(axis + f.name + " must be 0 or more, not " + shown(m.*f.member));
    }
  }
  for (const Field &f : kPositive) {
    if (!(m.*f.member > 0.0) || !finite(m.*f.member)) {
      refuse(axis + f.name + " must be more than 0, not " + shown(m.*f.member));
    }
  }
  for (const Field &f : kAnyNumber) {
    if (!finite(m.*f.member)) refuse(axis + f.name + " must be a finite number");
  }
  if (m.gear == 0.0) refuse(axis + "gear must not be 0");
  if (!(m.stiction_pos >= m.coulomb_pos) || !(m.stiction_neg >= m.coulomb_neg)) {
    refuse(axis + "stiction must be at least the Coulomb friction");
  }
  if (m.stop_lo < m.stop_hi && (m.angle0 < m.stop_lo || m.angle0 > m.stop_hi)) {
    refuse(axis + "angle0 = " + shown(m.angle0) + " lies outside the stops " + shown(m.stop_lo) +
           " to " + shown(m.stop_hi));
  }
  if (m.counts_per_rev < 4 || m.counts_per_rev % 4 != 0) {
    refuse(axis + "counts_per_rev must be a positive multiple of 4, not " +
           std::to_string(m.counts_per_rev));
  }
  if (m.index_per_rev != 0 && m.index_per_rev != 1) refuse(axis + "index_per_rev must be 0 or 1");
}

// The coupling is integrated explicitly: it must be slow against the step.
void check_coupling(const std::string &axis, const mmcs_motor &m) {
  if (m.stiffness == 0.0) return;
  const double load = m.load_inertia;
  if (!(load > 0.0)) refuse(axis + "a flexible axis needs a load_inertia of more than 0");
  const double softness = 1.0 / load + 1.0 / (m.inertia * m.gear * m.gear);
  if (m.stiffness * softness * kStep * kStep > 0.25 || m.damping * softness * kStep > 0.5) {
    refuse(axis + "the coupling is faster than the 50 us step: make it rigid (stiffness = 0), " +
           "softer or less damped");
  }
}

// Back-EMF over the winding brakes with km^2 / resistance: within a step it must not overshoot.
void check_winding(const std::string &axis, const mmcs_motor &m) {
  const double brake = m.km * m.km / m.resistance - m.viscous;
  if (m.v_supply > 0.0 && m.inertia < brake * kStep) {
    refuse(axis + "the winding brakes faster than the 50 us step: inertia must be larger, or the " +
           "resistance (v_supply = 0 leaves it out)");
  }
}

void check_link(const std::string &link, const mmcs_link &l) {
  if (!(l.mass >= 0.0)) refuse(link + "mass must be 0 or more, not " + shown(l.mass));
  const double all[] = {l.alpha,      l.a,          l.d,          l.theta0,     l.mass,
                        l.com[0],     l.com[1],     l.com[2],     l.inertia[0], l.inertia[1],
                        l.inertia[2], l.inertia[3], l.inertia[4], l.inertia[5]};
  for (double value : all) {
    if (!finite(value)) refuse(link + "all parameters must be finite numbers");
  }
  for (int i = 0; i < 3; ++i) {
    if (l.inertia[i] < 0.0) refuse(link + "inertia: xx, yy and zz must be 0 or more");
  }
}

}  // namespace

void check_parameters(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links,
                      int clks_per_step, int min_gap) {
  if (config.axes < 1 || config.axes > kMaxAxes) {
    refuse("axes must be 1 to 32, not " + std::to_string(config.axes));
  }
  if (config.links != 0 && config.links != config.axes) {
    refuse("an arm needs one link per axis: " + std::to_string(config.axes) + " axes, " +
           std::to_string(config.links) + " links");
  }
  if (motors == nullptr || (config.links != 0 && links == nullptr)) refuse("no parameters given");
  if (clks_per_step < 1 || min_gap < 1 || min_gap > clks_per_step) {
    refuse("min_gap must be 1 to clks_per_step clocks");
  }
  for (int i = 0; i < config.axes; ++i) {
    const std::string axis = "axis " + std::to_string(i) + ": ";
    check_values(axis, motors[i]);
    // In an arm the load is the arm: check_arm() looks at that.
    if (config.links == 0) check_coupling(axis, motors[i]);
    if (motors[i].backlash > 0.0 && motors[i].stiffness == 0.0) {
      refuse(axis + "backlash needs a stiffness of the coupling");
    }
    check_winding(axis, motors[i]);
  }
  for (int i = 0; i < config.links; ++i) {
    check_link("link " + std::to_string(i) + ": ", links[i]);
  }
  check_arm(config, motors, links);
}

}  // namespace mmcs
