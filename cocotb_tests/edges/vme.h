// SPDX-License-Identifier: Apache-2.0
// The backplane of a sweep: master, chain of IACK*, PC side, and what must hold at every edge.
#pragma once

#include <vector>

#include "Vbench_edges_vme.h"
#include "world.h"

struct Cycle {
  unsigned address;  // A15-A00
  bool write;
  unsigned data;
  bool ack = false;    // an acknowledge of level `address`
  unsigned ds = 0b10;  // DS1*, DS0*
  unsigned am = 0x29;

  bool ours() const {
    return !ack && (address >> 11) == 0x0C && !(ds & 1) && (am == 0x29 || am == 0x2D);
  }
};

constexpr unsigned kCard = 0x6000, kPit = 0x6401, kPccsr = 0x6409, kVector = 0x6441;
constexpr unsigned kOther = 0x2001;
constexpr unsigned kBase = 0x18, kArmed = 0x80, kSclockIrq = 0x20, kPanicIrq = 0x40;
constexpr unsigned kMyVector = 0xC5;

class Backplane : public World<Vbench_edges_vme> {
 public:
  Backplane();
  void reset() override;

  // The parts of a cycle, at this instant. Minima as a slave sees them: docs/hardware/timing.md.
  void put(const Cycle &cycle);          // address, modifier, IACK*, WRITE*, data
  void put_address(const Cycle &cycle);  // without WRITE* and data: address pipelining
  void as(bool low);
  void ds(unsigned levels);
  void strobe(const Cycle &cycle);  // those that the cycle wants fall
  // A whole cycle of a mannered master from both strobes high; false: bus time-out.
  bool run(const Cycle &cycle, unsigned *data = nullptr);
  // From strobes that have just fallen to DTACK*, and from there to the end.
  bool answered(const Cycle &cycle, unsigned *data = nullptr);
  void release();
  bool write(unsigned address, unsigned value);
  unsigned read(unsigned address);
  void request(bool on);  // our interrupt request, by PCCSR and the timers
  // Everything rests, and a write and a read do what they say.
  void check_health();

  struct Access {
    unsigned address, data;
  };
  std::vector<Access> written;       // on the PC bus since clear
  long chain_delay = 1;              // steps from IACKOUT* to the next board's IACKIN*
  unsigned passed = 0, answers = 0;  // of the present acknowledge, one bit per board
  bool fast = false;  // the board behind us is a quick one: it answers what reaches it
  bool dtack() const { return dut.dtack_o != 0 || fast_dtack_; }
  const Cycle *on_bus = nullptr;  // whose strobes are low now

 protected:
  void clocks(long phase) override;
  bool clock_moves(long phase) override;
  void look() override;

 private:
  unsigned dtack_was_ = 0, out_was_ = 0xF;
  bool iow_was_ = true, fast_dtack_ = false;
  unsigned toggle_ = 0;
};
