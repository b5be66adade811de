// SPDX-License-Identifier: Apache-2.0
// See pins.h.

#include "pins.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

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

// The board at whose pins the ribbon begins.
const char *const kAdaptor = "u_adaptor";

}  // namespace

// Moved at a port of its own.
static bool has_port(Pin pin) {
  switch (pin) {
    case Pin::kSysreset:
    case Pin::kEstop:
    case Pin::kCable:
    case Pin::kPcPower:
    case Pin::kAxisEnable:
    case Pin::kDipXor:
      return true;
    default:
      return false;
  }
}

bool pin_is_port(Pin pin) {
  return has_port(pin) || (pin >= Pin::kVmeA0 && pin <= Pin::kVmeControl1);
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

uint64_t Pins::standing(Pin pin) const {
  return faults_[static_cast<size_t>(pin) * 2 * static_cast<size_t>(cards_)];
}

uint64_t &Pins::standing(Pin pin, int index) {
  const auto axes = 2 * static_cast<size_t>(cards_);
  return faults_[static_cast<size_t>(pin) * axes + static_cast<size_t>(index)];
}

void Pins::set(Pin pin, int index, unsigned value) {
  const uint64_t on = value & 1;
  switch (pin) {
    case Pin::kSysreset:
      return later(kVmeSysreset, 0, 1, !on);
    case Pin::kEstop:
      return later(kEstopClosed, 0, 1, !on);
    case Pin::kCable:
      return later(kCableOk, 0, 1, on);
    case Pin::kPcPower:
      return later(kPcPower, 0, 1, on);
    case Pin::kAxisEnable:
      return later(kAxisEnable, index, 1, on);
    case Pin::kDipXor:  // a switch that is right has the number of its card
      return later(kDip, 4 * index, 4, (static_cast<unsigned>(index) ^ value) & 15);
    default:
      later(FaultChange{pin, index, value});
  }
}

void Pins::had_cycle(unsigned address, unsigned am, unsigned data) {
  driven_[kVmeA] = free_[kVmeA] = levels_[kVmeA][0] = address >> 1 & 0x7FFF;
  driven_[kVmeAm] = free_[kVmeAm] = levels_[kVmeAm][0] = am & 63;
  driven_[kVmeD] = free_[kVmeD] = levels_[kVmeD][0] = data & 0xFFFF;
}

// Lines of the VME bus: those held low win.
void Pins::hold(Port port, uint64_t low, uint64_t high) {
  low_[port] = low;
  high_[port] = high & ~low;
  if (low | high) ports_.disturb();
  put(port, 0, kPortFields[port], free_[port]);
}

// AS*, DS0*, DS1*, WRITE*, LWORD*, IACK*, IACKIN*.
void Pins::hold_control() {
  const uint64_t low = standing(Pin::kVmeControl0), high = standing(Pin::kVmeControl1);
  int bit = 0;
  for (Port port : {kVmeAs, kVmeDs, kVmeWrite, kVmeLword, kVmeIack, kVmeIackin}) {
    const uint64_t mask = (uint64_t{1} << kPortFields[port]) - 1;
    hold(port, low >> bit & mask, high >> bit & mask);
    bit += kPortFields[port];
  }
}

// Lines of the ribbon: what the adaptor drives, and what it receives.
void Pins::hold_pc(Pin low, const char *out, const char *in) {
  const uint64_t zeros = standing(low);
  const uint64_t ones = standing(static_cast<Pin>(static_cast<int>(low) + 1)) & ~zeros;
  if (zeros | ones) ports_.disturb();
  ports_.cut(kAdaptor, out, zeros | ones, ones);
  if (in) ports_.cut(kAdaptor, in, zeros | ones, ones);
}

// IOR# and IOW#.
void Pins::hold_pc_control() {
  const uint64_t zeros = standing(Pin::kPcControl0), ones = standing(Pin::kPcControl1) & ~zeros;
  const uint64_t held = zeros | ones;
  if (held) ports_.disturb();
  ports_.cut(kAdaptor, "pc_ior_no", held & 1, ones & 1);
  ports_.cut(kAdaptor, "pc_iow_no", held >> 1 & 1, ones >> 1 & 1);
}

void Pins::put(int port, int lsb, int width, uint64_t value) {
  if (port < kVmeSysreset) {
    free_[port] = value;
    value = through(port, value);
  }
  uint64_t &word = levels_[port][static_cast<size_t>(lsb / 64)];
  const uint64_t mask = ((uint64_t{1} << width) - 1) << lsb % 64;
  const uint64_t after = (word & ~mask) | (value << lsb % 64 & mask);
  if (after == word) return;
  word = after;
  ports_.put(static_cast<Port>(port), lsb, width, value);
}

// A card that is pulled receives no command, and drives nothing but the 1 of a free line. A jumper
// that is open: the line is 0 on its far side.
void Pins::fault(Pin pin, int index, uint64_t value) {
  standing(pin, index) = value;
  faulty_ = std::any_of(faults_.begin(), faults_.end(), [](uint64_t f) { return f != 0; });
  const bool on = value != 0;
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
      const std::string code = axis_path(index) + ".u_adc.code_q";
      uint64_t &kept = codes_[static_cast<size_t>(index)];
      if (on) kept = ports_.read_register(code);
      return ports_.stick(code, on ? ~kept & kCodeMask : 0, on ? kept : 0);
    }
    case Pin::kIrqLost:  // its edge detector takes SCLOCK for high all the time
      return ports_.stick("u_adaptor.u_core.u_pccsr.sclock_q", 0, on);
    case Pin::kClockStop:
      if (on) ports_.disturb();
      return ports_.stop_clock(on);
    case Pin::kVmeA0:
    case Pin::kVmeA1:
      return hold(kVmeA, standing(Pin::kVmeA0), standing(Pin::kVmeA1));
    case Pin::kVmeAm0:
    case Pin::kVmeAm1:
      return hold(kVmeAm, standing(Pin::kVmeAm0), standing(Pin::kVmeAm1));
    case Pin::kVmeD0:
    case Pin::kVmeD1:
      return hold(kVmeD, standing(Pin::kVmeD0), standing(Pin::kVmeD1));
    case Pin::kVmeControl0:
    case Pin::kVmeControl1:
      return hold_control();
    case Pin::kPcA0:
    case Pin::kPcA1:
      return hold_pc(Pin::kPcA0, "pc_a_o", nullptr);
    case Pin::kPcD0:
    case Pin::kPcD1:
      return hold_pc(Pin::kPcD0, "pc_d_o", "pc_d_i");
    case Pin::kPcControl0:
    case Pin::kPcControl1:
      return hold_pc_control();
    default:
      return;
  }
}

void Pins::apply() {
  std::vector<Change> now;
  now.swap(changes_);
  for (const Change &c : now) {
    if (const auto *p = std::get_if<PortChange>(&c)) {
      put(p->port, p->lsb, p->width, p->value);
    } else {
      const auto &f = std::get<FaultChange>(c);
      fault(f.pin, f.index, f.value);
    }
  }
  now.clear();
  if (changes_.empty()) changes_.swap(now);  // its memory is used again
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
  for (int port = 0; port < kPorts; ++port) {
    if (port < kVmeSysreset) {
      out.push_back(free_[port]);
    } else {
      out.insert(out.end(), levels_[port].begin(), levels_[port].end());
    }
  }
  out.insert(out.end(), faults_.begin(), faults_.end());
  out.insert(out.end(), codes_.begin(), codes_.end());
  for (const Change &c : changes_) {
    const auto *p = std::get_if<PortChange>(&c);
    const auto *f = std::get_if<FaultChange>(&c);
    const int head[] = {f != nullptr, p ? p->port : static_cast<int>(f->pin), p ? p->lsb : f->index,
                        p ? p->width : 0};
    for (int n : head) out.push_back(static_cast<uint64_t>(n));
    out.push_back(p ? p->value : f->value);
  }
  return out;
}

void Pins::restore(const std::vector<uint64_t> &state) {
  size_t at = faults_.size() + codes_.size();
  for (const auto &level : levels_) at += level.size();
  if (state.size() < at || (state.size() - at) % kChangeWords != 0) {
    throw std::invalid_argument("a snapshot of another machine");
  }
  at = 0;
  for (int port = 0; port < kPorts; ++port) {
    for (size_t word = 0; word < levels_[port].size(); ++word) {
      const uint64_t value = state[at++];
      if (port < kVmeSysreset) {
        put(port, 0, kPortFields[port], value);
        continue;
      }
      for (int half = 0; half < 2; ++half) {
        put(port, static_cast<int>(64 * word) + 32 * half, 32, value >> 32 * half & 0xFFFFFFFF);
      }
    }
  }
  const size_t faults = at;
  at += faults_.size();
  for (uint64_t &code : codes_) code = state[at++];
  changes_.clear();
  for (; at + kChangeWords <= state.size(); at += kChangeWords) {
    const int what = static_cast<int>(state[at + 1]), index = static_cast<int>(state[at + 2]);
    const uint64_t value = state[at + 4];
    if (state[at]) {
      changes_.emplace_back(FaultChange{static_cast<Pin>(what), index, value});
    } else {
      changes_.emplace_back(
          PortChange{static_cast<Port>(what), index, static_cast<int>(state[at + 3]), value});
    }
  }
  for (int port = 0; port < kVmeSysreset; ++port) driven_[port] = free_[port];
  for (int n = 0; n < 3; ++n) {
    for (size_t axis = 0; axis < encoders_.size(); ++axis) {
      const unsigned level = levels_[kEncA + n][0] >> axis & 1;
      encoders_[axis] = (encoders_[axis] & ~(1u << n)) | level << n;
    }
  }
  for (const Change &c : changes_) {
    const auto *p = std::get_if<PortChange>(&c);
    if (p && p->port < kVmeSysreset) driven_[p->port] = p->value;
    if (!p || p->port < kEncA || p->port > kEncI) continue;
    unsigned &encoder = encoders_[static_cast<size_t>(p->lsb)];
    const unsigned bit = 1u << (p->port - kEncA);
    encoder = p->value ? encoder | bit : encoder & ~bit;
  }
  const std::vector<uint64_t> codes = codes_;
  for (size_t n = 0; n < faults_.size(); ++n) {
    if (faults_[n] == 0 && state[faults + n] == 0) continue;
    const int pin = static_cast<int>(n) / (2 * cards_), index = static_cast<int>(n) % (2 * cards_);
    fault(static_cast<Pin>(pin), index, state[faults + n]);
    if (static_cast<Pin>(pin) != Pin::kAdcStuck || state[faults + n] == 0) continue;
    // the code of then, not of now
    const uint64_t kept = codes[static_cast<size_t>(index)];
    codes_[static_cast<size_t>(index)] = kept;
    ports_.stick(axis_path(index) + ".u_adc.code_q", ~kept & kCodeMask, kept);
  }
}

}  // namespace mmcs
