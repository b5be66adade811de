// SPDX-License-Identifier: Apache-2.0
// The Verilated machine as a plain C++ object: pins in, clocks, lines out.
//
// Knows nothing of plant, firmware or time in seconds. Create, run clocks, destroy; several may
// exist at once. After a pin or a hand moves, the next clock stands for itself (no skipping).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace mmcs {

// Bits of Model::lines().
inline constexpr unsigned kLineIrq = 0xFE;  // bit n = IRQn* requesting
inline constexpr unsigned kLinePanic = 1u << 8;
inline constexpr unsigned kLineBrakeRelease = 1u << 9;
inline constexpr unsigned kLineSclock = 1u << 10;

// Inputs of the machine. Vectors hold one bit or field per axis or card.
enum class Pin {
  kSysreset,
  kEstop,
  kCableCut,
  kPcOff,
  kIrqLost,  // 1 bit
  kIrqOpen,  // 1 bit; the SoC's processor sees no interrupt
  kAxisEnable,
  kAdcStuck,  // 1 bit per axis
  kCardAbsent,
  kSclockOpen,
  kPanicOpen,  // 1 bit per card
  kDipXor,     // 4 bits per card
  kDacStuck1,
  kDacStuck0,  // 12 bits per axis
  kAdcV,       // 16 bits per axis
  kCount
};

// Registers that a particle may hit: of an axis, then of the adaptor.
enum class Register {
  kEncoder,
  kDacRank1,
  kDacRank2,
  kIndexLatch,
  kHeartbeat,
  kPccsr,
  kVector,
  kNone
};

// What the SoC's processor just did: it took the adaptor's interrupt, or an access to the adaptor
// begins, or has read or written.
enum class SocStep { kInterrupt, kAccess, kRead, kWrite };

enum class Stop { kDone, kLines, kDtack, kReport, kFailed };

class Model {
 public:
  // two_evals: evaluate both clock edges. skip: let one evaluation stand for all clocks in which
  // nothing but counting happens, if the build can.
  static std::unique_ptr<Model> create(bool two_evals, bool skip, uint64_t seed);
  virtual ~Model() = default;

  static int cards();
  static int clk_hz();
  static bool skip();
  static bool traced();
  static bool soc();  // the machine has its own processor, and no VME bus

  // Advances up to n clocks. Stops after the clock in which a line changed, or, if dtack is 0 or
  // 1, in which DTACK* has that level. *ran: clocks that passed.
  virtual Stop run(int64_t n, int dtack, int64_t *ran) = 0;
  virtual int64_t clock() const = 0;
  virtual uint64_t evals() const = 0;
  virtual unsigned lines() const = 0;
  virtual bool dtack() const = 0;  // DTACK* is low

  virtual void set(Pin pin, int index, unsigned value) = 0;
  // The three wires of an encoder at once: bit 0 A, bit 1 B, bit 2 index.
  virtual void set_encoder(int axis, unsigned pins) = 0;
  virtual int16_t drive(int axis) const = 0;
  virtual unsigned leds(int card) const = 0;

  // The VME bus master's hands; see mmcs_sim_top.sv.
  virtual void vme_address(unsigned address, unsigned am, bool write, bool lword,
                           unsigned data) = 0;
  virtual void vme_strobe(unsigned ds, bool iack) = 0;
  virtual void vme_iackin(bool low) = 0;
  virtual void vme_release() = 0;
  virtual unsigned vme_sample() = 0;

  // What a processor outside is doing, for the waveform only.
  virtual void host_phase(unsigned, uint32_t) {}

  // The SoC's processor; see mmcs_soc_sim_top.sv. Memory by words; without a SoC nothing happens.
  virtual void soc_run(bool on) = 0;
  virtual void soc_ring() = 0;
  virtual void soc_errors(unsigned accesses) = 0;
  // Called within run(), with the offset of an access that has ended; clock() is the clock.
  virtual void watch_soc(const std::function<void(SocStep, unsigned)> &) {}
  virtual uint32_t soc_read(unsigned word) const = 0;
  virtual void soc_write(unsigned word, uint32_t value) = 0;
  // What it reported, or 0: run() ends with it, and it waits until the next run().
  virtual unsigned report() const = 0;
  virtual void take_report() = 0;
  // Offset of the last access that failed by soc_errors(), or 0; asking forgets it.
  virtual unsigned take_bus_error() = 0;

  // Registers inside, read without disturbing them.
  virtual uint16_t encoder_register(int axis) = 0;
  virtual uint64_t digest() = 0;
  // Flips these bits, as a particle would; everything behind the register follows at once.
  virtual void upset(Register reg, int axis, unsigned bits) = 0;

  // Everything that changes in the RTL, as bytes; for the same build only.
  virtual std::vector<uint8_t> save() = 0;
  virtual void restore(const std::vector<uint8_t> &state) = 0;

  // Starts a trace now, ends one that runs; "" only ends it.
  virtual bool trace(const std::string &path) = 0;
  // The sentence of the first assertion that failed, or empty.
  virtual const std::string &failure() const = 0;
};

}  // namespace mmcs
