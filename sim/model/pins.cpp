// SPDX-License-Identifier: Apache-2.0
// See pins.h.

#include "pins.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "model.h"

namespace mmcs {

const char *const kPortNames[kPorts] = {
    "vme_a_i",        "vme_am_i",      "vme_as_ni",   "vme_ds_ni",     "vme_write_ni",
    "vme_lword_ni",   "vme_d_i",       "vme_iack_ni", "vme_iackin_ni", "vme_sysreset_ni",
    "estop_closed_i", "cable_ok_i",    "pc_power_i",  "enc_a_i",       "enc_b_i",
    "enc_i_i",        "axis_enable_i", "dip_i",       "adc_v_i"};

namespace {

constexpr auto kFaultPins = static_cast<size_t>(Pin::kCount);
constexpr uint64_t kCodeMask = 0xFFF;
constexpr size_t kChangeWords = 5;  // of a change in a snapshot

// Pins with a port of their own, which has as many bits for each index.
struct OwnPort {
  Pin pin;
  Port port;
  bool low;  // at 1 the port is 0
};
constexpr OwnPort kOwnPorts[] = {{Pin::kSysreset, kVmeSysreset, true},
                                 {Pin::kEstop, kEstopClosed, true},
                                 {Pin::kCable, kCableOk, false},
                                 {Pin::kPcPower, kPcPower, false},
                                 {Pin::kAxisEnable, kAxisEnable, false}};

// Lines of a bus that can be held: by the pin that holds bits of them at 0, and the one behind it
// in the table of inputs, that holds them at 1. Those held at 0 win.
template <class Wire>
struct HeldLine {
  Pin zeros;
  int bit;  // of the pin's value: the lowest of the line
  Wire wire;
  bool is_of(Pin pin) const { return pin == zeros || pin == ones(); }
  Pin ones() const { return static_cast<Pin>(static_cast<int>(zeros) + 1); }
};
constexpr HeldLine<Port> kVmeLines[] = {
    {Pin::kVmeA0, 0, kVmeA},           {Pin::kVmeAm0, 0, kVmeAm},
    {Pin::kVmeD0, 0, kVmeD},           {Pin::kVmeControl0, 0, kVmeAs},
    {Pin::kVmeControl0, 1, kVmeDs},    {Pin::kVmeControl0, 3, kVmeWrite},
    {Pin::kVmeControl0, 4, kVmeLword}, {Pin::kVmeControl0, 5, kVmeIack},
    {Pin::kVmeControl0, 6, kVmeIackin}};
// Lines of the ribbon cable, at the adaptor: ports that it drives and receives.
constexpr HeldLine<const char *> kRibbonLines[] = {{Pin::kPcA0, 0, "pc_a_o"},
                                                   {Pin::kPcD0, 0, "pc_d_o"},
                                                   {Pin::kPcD0, 0, "pc_d_i"},
                                                   {Pin::kPcControl0, 0, "pc_ior_no"},
                                                   {Pin::kPcControl0, 1, "pc_iow_no"}};

}  // namespace

bool pin_is_port(Pin pin) {
  const auto is = [pin](const OwnPort &own) { return own.pin == pin; };
  return std::any_of(std::begin(kOwnPorts), std::end(kOwnPorts), is) || pin == Pin::kDipXor ||
         (pin >= Pin::kVmeA0 && pin <= Pin::kVmeControl1);
}

Pins::Pins(Ports &ports, int cards) : ports_(ports), cards_(cards) {
  for (int port = 0; port < kPorts; ++port) {
    levels_[port].resize(static_cast<size_t>(port == kAdc ? (cards + 1) / 2 : 1));
  }
  const auto axes = 2 * static_cast<size_t>(cards);
  faults_.resize(kFaultPins * axes);
  codes_.resize(axes);
  encoders_.resize(axes);
}

uint64_t &Pins::standing(Pin pin, int index) {
  const auto axes = 2 * static_cast<size_t>(cards_);
  return faults_[static_cast<size_t>(pin) * axes + static_cast<size_t>(index)];
}

void Pins::set(Pin pin, int index, unsigned value) {
  for (const OwnPort &own : kOwnPorts) {
    if (own.pin == pin) return later(own.port, index, 1, (value & 1) != own.low);
  }
  if (pin == Pin::kDipXor)  // a switch that is right has the number of its card
    return later(kDip, 4 * index, 4, (static_cast<unsigned>(index) ^ value) & 15);
  later({pin, kPorts, index, 0, value});
}

void Pins::had_cycle(unsigned address, unsigned am, unsigned data) {
  driven_[kVmeA] = levels_[kVmeA][0] = address >> 1 & 0x7FFF;
  driven_[kVmeAm] = levels_[kVmeAm][0] = am & 63;
  driven_[kVmeD] = levels_[kVmeD][0] = data & 0xFFFF;
}

// Lines of the VME bus.
void Pins::hold(Port port, uint64_t low, uint64_t high) {
  low_[port] = low;
  high_[port] = high & ~low;
  if (low | high) ports_.disturb();
  ports_.put(port, 0, kPortFields[port], through(port, levels_[port][0]));
}

void Pins::put(int port, int lsb, int width, uint64_t value) {
  const int field = kPortFields[port];
  for (; 0 < field && field < width; lsb += field, width -= field, value >>= field) {
    put(port, lsb, field, value);
  }
  uint64_t &word = levels_[port][static_cast<size_t>(lsb / 64)];
  const uint64_t mask = ((uint64_t{1} << width) - 1) << lsb % 64;
  const uint64_t after = (word & ~mask) | (value << lsb % 64 & mask);
  if (after == word) return;
  word = after;
  ports_.put(static_cast<Port>(port), lsb, width, through(port, value));
}

void Pins::fault(Pin pin, int index, uint64_t value) {
  standing(pin, index) = value;
  if (pin == Pin::kAdcStuck && value)
    codes_[static_cast<size_t>(index)] = ports_.read_register(axis_path(index) + ".u_adc.code_q");
  apply_fault(pin, index);
}

// A card that is pulled receives no command, and drives nothing but the 1 of a free line. A jumper
// that is open: the line is 0 on its far side.
void Pins::apply_fault(Pin pin, int index) {
  faulty_ = std::any_of(faults_.begin(), faults_.end(), [](uint64_t f) { return f != 0; });
  for (const auto &line : kVmeLines) {
    if (!line.is_of(pin)) continue;
    const uint64_t mask = (uint64_t{1} << kPortFields[line.wire]) - 1;
    hold(line.wire, standing(line.zeros) >> line.bit & mask,
         standing(line.ones()) >> line.bit & mask);
  }
  for (const auto &line : kRibbonLines) {
    if (!line.is_of(pin)) continue;
    const uint64_t zeros = standing(line.zeros), ones = standing(line.ones()) & ~zeros;
    if (zeros | ones) ports_.disturb();
    ports_.cut("u_adaptor", line.wire, (zeros | ones) >> line.bit, ones >> line.bit);
  }
  const bool on = standing(pin, index) != 0;
  const uint64_t all = on ? ~uint64_t{0} : 0;
  switch (pin) {
    case Pin::kCardAbsent:
      ports_.cut(card_path(index), "pc_ior_ni", all, 1);
      ports_.cut(card_path(index), "pc_iow_ni", all, 1);
      ports_.cut(card_path(index), "drive_v_o", all, 0);
      ports_.cut(card_path(index), "leds_o", all, 0);
      [[fallthrough]];
    case Pin::kPanicOpen: {
      const bool either = standing(Pin::kCardAbsent, index) || standing(Pin::kPanicOpen, index);
      return ports_.cut(card_path(index), "pc_irq_o", either ? ~uint64_t{0} : 0, 0);
    }
    case Pin::kSclockOpen:
      return ports_.cut(card_path(index), "pc_drq_i", all, 0);
    case Pin::kDacStuck1:
    case Pin::kDacStuck0:
      return ports_.stick(
          axis_path(index) + ".u_dac.rank2_q", standing(Pin::kDacStuck0, index) & kCodeMask,
          standing(Pin::kDacStuck1, index) & kCodeMask & ~standing(Pin::kDacStuck0, index));
    case Pin::kAdcStuck: {
      const uint64_t code = codes_[static_cast<size_t>(index)];
      return ports_.stick(axis_path(index) + ".u_adc.code_q", on ? ~code & kCodeMask : 0,
                          on ? code : 0);
    }
    case Pin::kIrqLost:  // its edge detector takes SCLOCK for high all the time
      return ports_.stick("u_adaptor.u_core.u_pccsr.sclock_q", 0, on);
    case Pin::kClockStop:
      if (on) ports_.disturb();
      return ports_.stop_clock(on);
    default:
      return;
  }
}

void Pins::apply() {
  for (size_t n = 0; n < changes_.size(); ++n) {
    const Change c = changes_[n];
    if (c.port != kPorts) {
      put(c.port, c.at, c.width, c.value);
    } else {
      fault(c.pin, c.at, c.value);
    }
  }
  changes_.clear();
}

void Pins::power_on() {
  vme_idle();
  apply();
  for (auto port : {kEstopClosed, kCableOk, kPcPower}) {
    put(port, 0, 1, 1);
  }
  for (int card = 0; card < cards_; ++card) {
    put(kDip, 4 * card, 4, static_cast<unsigned>(card));
    put(kAxisEnable, 2 * card, 2, 3);
  }
}

std::vector<uint64_t> Pins::save() const {
  std::vector<uint64_t> out;
  for (const auto &levels : levels_) out.insert(out.end(), levels.begin(), levels.end());
  out.insert(out.end(), std::begin(driven_), std::end(driven_));
  for (const auto *values : {&encoders_, &codes_, &faults_})
    out.insert(out.end(), values->begin(), values->end());
  for (const Change &c : changes_) {
    for (int n : {static_cast<int>(c.pin), static_cast<int>(c.port), c.at, c.width})
      out.push_back(static_cast<uint64_t>(n));
    out.push_back(c.value);
  }
  return out;
}

void Pins::restore(const std::vector<uint64_t> &state) {
  size_t fixed = std::size(driven_) + encoders_.size() + codes_.size() + faults_.size();
  for (const auto &level : levels_) fixed += level.size();
  if (state.size() < fixed || (state.size() - fixed) % kChangeWords != 0) {
    throw std::invalid_argument("a snapshot of another machine");
  }
  auto at = state.begin();
  for (int port = 0; port < kPorts; ++port) {
    const int width = port < kVmeSysreset ? kPortFields[port] : 64;
    for (size_t word = 0; word < levels_[port].size(); ++word)
      put(port, static_cast<int>(64 * word), width, *at++);
  }
  for (uint64_t &value : driven_) value = *at++;
  const std::vector<uint64_t> before = faults_;
  for (auto *values : {&encoders_, &codes_, &faults_}) {
    for (uint64_t &value : *values) value = *at++;
  }
  changes_.clear();
  for (; at != state.end(); at += kChangeWords) {
    changes_.push_back({static_cast<Pin>(at[0]), static_cast<Port>(at[1]), static_cast<int>(at[2]),
                        static_cast<int>(at[3]), at[4]});
  }
  for (size_t n = 0; n < faults_.size(); ++n) {
    const int pin = static_cast<int>(n) / (2 * cards_), index = static_cast<int>(n) % (2 * cards_);
    if (before[n] || faults_[n]) apply_fault(static_cast<Pin>(pin), index);
  }
}

}  // namespace mmcs
