// SPDX-License-Identifier: Apache-2.0
// The inputs of a machine by name, and the pins of its VME bus master: what is set is at the ports
// of rtl/mmcs.sv after the next edge. Faults for which the hardware has no input are made here: a
// port of a board that is cut off its wire, a register with bits that are held.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace mmcs {

// The instances of rtl/mmcs_cards.sv, as registers and nets are named by.
inline std::string card_path(int card) {
  return "g_card[" + std::to_string(card) + "].u_card";
}
inline std::string axis_path(int axis) {
  return card_path(axis / 2) + ".g_axis[" + std::to_string(axis % 2) + "].u_axis";
}

// Inputs of the machine: those of the table, and one that no event names. Vectors hold one bit or
// field per axis or card.
enum class Pin {
#define PIN(pin, ...) pin,
#include "inputs.def"
  kCount
};
enum class Scope { kMachine, kCard, kAxis };  // what an index of the table counts

// Ports of rtl/mmcs.sv that move during a run; kPortNames has their names, in this order.
enum Port {
  kVmeA,
  kVmeAm,
  kVmeAs,
  kVmeDs,
  kVmeWrite,
  kVmeLword,
  kVmeD,
  kVmeIack,
  kVmeIackin,
  kVmeSysreset,
  kEstopClosed,
  kCableOk,
  kPcPower,
  kEncA,
  kEncB,
  kEncI,
  kAxisEnable,
  kDip,
  kAdc,
  kPorts
};
extern const char *const kPortNames[kPorts];
// Bits of a port that move at once: all of it, of an axis or of a card.
constexpr int kPortFields[kPorts] = {15, 6, 1, 2, 1, 1, 16, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 4, 32};

// Whether it is moved from outside the machine: by a port, not by a fault within.
bool pin_is_port(Pin pin);

// What a machine lets be done to it, between clocks.
class Ports {
 public:
  virtual ~Ports() = default;
  // A field of a port (kPortFields).
  virtual void put(Port port, int lsb, int width, uint64_t value) = 0;
  // Bits of a port of a board (in kWires.boards) are held at those of a value; the others are free.
  virtual void cut(const std::string &board, const char *port, uint64_t mask, uint64_t value) = 0;
  // These bits of a register are held at 0, then those at 1; none: free again.
  virtual void stick(const std::string &reg, uint64_t clear, uint64_t set) = 0;
  virtual uint64_t read_register(const std::string &reg) = 0;
  // A line of a bus breaks its rules from now on: checkers have nothing to say any more.
  virtual void disturb() = 0;
  virtual void stop_clock(bool stopped) = 0;
};

// The bus master's ports in the steps of a cycle, by put(port, level). The address, modifier,
// direction and data, of an acknowledge IACK* with them; the strobes; idle.
template <class F>
void put_address(unsigned address, unsigned am, bool write, unsigned data, bool iack, F put) {
  put(kVmeA, address >> 1 & 0x7FFF);
  put(kVmeAm, am & 63);
  put(kVmeWrite, unsigned{!write});
  put(kVmeLword, 1u);
  put(kVmeD, data & 0xFFFF);
  put(kVmeIack, unsigned{!iack});
}
template <class F>
void put_strobes(unsigned ds, F put) {
  put(kVmeAs, 0u);
  put(kVmeDs, ~ds & 3);
}
template <class F>
void put_idle(F put) {
  put(kVmeDs, 3u);
  for (Port port : {kVmeAs, kVmeIack, kVmeIackin, kVmeWrite, kVmeLword}) put(port, 1u);
}

class Pins {
 public:
  Pins(Ports &ports, int cards);

  void set(Pin pin, int index, unsigned value);
  // The volts of a card's two A/Ds, 16 bits each.
  void set_volts(int card, uint32_t volts) { later(kAdc, 32 * card, 32, volts); }
  // The three wires of an encoder at once: bit 0 A, bit 1 B, bit 2 index.
  void set_encoder(int axis, unsigned pins) {
    for_moved(axis, pins,
              [&](int port, uint64_t on) { later(static_cast<Port>(port), axis, 1, on); });
  }
  // The same, at its clock.
  void move_encoder(int axis, unsigned pins) {
    for_moved(axis, pins, [&](int port, uint64_t on) { put(port, axis, 1, on); });
  }
  // The steps of a cycle of the bus master; the daisy chain.
  void vme_address(unsigned address, unsigned am, bool write, unsigned data, bool iack = false) {
    put_address(address, am, write, data, iack, Driver{*this});
  }
  void vme_strobes(unsigned ds) { put_strobes(ds, Driver{*this}); }
  void vme_iackin(bool low) { drive(kVmeIackin, !low); }
  void vme_idle() { put_idle(Driver{*this}); }

  // What the bus master reads of D15..D00 through lines that are held.
  unsigned vme_data(unsigned data) const { return static_cast<unsigned>(through(kVmeD, data)); }

  // A cycle of the bus master is over that was made as one step.
  void had_cycle(unsigned address, unsigned am, unsigned data);
  bool faulty() const { return faulty_; }  // a fault stands that is made here

  // Changes from now on go to these pins, too; null: to none.
  void also(Pins *other) { also_ = other; }

  bool waiting() const { return !changes_.empty(); }
  void apply();     // changes that wait are made
  void power_on();  // everything at its idle level, at once

  // All levels, and changes that are on their way, for a snapshot.
  std::vector<uint64_t> save() const;
  void restore(const std::vector<uint64_t> &state);

 private:
  struct Change {
    Pin pin;        // of a fault
    Port port;      // that changes; kPorts: a fault
    int at, width;  // bits of the port; of a fault its index
    uint64_t value;
  };
  void later(Port port, int lsb, int width, uint64_t value) {
    later({Pin::kCount, port, lsb, width, value});
  }
  void later(const Change &change) {
    changes_.push_back(change);
    if (also_) also_->changes_.push_back(change);
  }
  // Of the wires of an encoder those that move.
  template <class F>
  void for_moved(int axis, unsigned pins, F f) {
    uint64_t &before = encoders_[static_cast<size_t>(axis)];
    const uint64_t moved = before ^ pins;
    before = pins;
    for (unsigned n = 0; n < 3; ++n) {
      if (moved >> n & 1) f(kEncA + static_cast<int>(n), pins >> n & 1);
    }
  }
  struct Driver {
    Pins &pins;
    void operator()(Port port, unsigned value) const { pins.drive(port, value); }
  };
  // A port of the bus master, if it changes.
  void drive(Port port, unsigned value) {
    if (driven_[port] == value) return;
    driven_[port] = value;
    if (also_) also_->driven_[port] = value;
    later(port, 0, kPortFields[port], value);
  }
  void put(int port, int lsb, int width, uint64_t value);
  void fault(Pin pin, int index, uint64_t value);
  void apply_fault(Pin pin, int index);
  uint64_t &standing(Pin pin, int index = 0);
  void hold(Port port, uint64_t low, uint64_t high);
  uint64_t through(int port, uint64_t value) const {
    return port < kVmeSysreset ? (value & ~low_[port]) | high_[port] : value;
  }

  Ports &ports_;
  const int cards_;
  Pins *also_ = nullptr;
  std::vector<Change> changes_;
  uint64_t driven_[kVmeSysreset] = {};  // VME ports, with changes that are on their way
  uint64_t low_[kVmeSysreset] = {}, high_[kVmeSysreset] = {};  // lines that are held
  std::vector<uint64_t> encoders_;        // of each axis: as set_encoder() set them last
  std::vector<uint64_t> levels_[kPorts];  // as they are if no line is held, 64 bits a word
  std::vector<uint64_t> faults_;          // by pin, then index: as they are
  bool faulty_ = false;                   // any of them
  std::vector<uint64_t> codes_;           // of each axis: the code of its A/D when it stuck
};

}  // namespace mmcs
