// SPDX-License-Identifier: Apache-2.0
// The Verilated model of a part: where its registers and ports are. The data fields and the control
// state that Part has in its cache are written to it and read from it here.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "board.h"
#include "cache.h"
#include "tables.h"

namespace mmcs {

constexpr int kNoField = -1;  // a control input, output or register

class Part;
struct Wire;

// Bits of an input of a part, with all that a value needs to get there.
struct Link {
  Part *part;
  uint64_t mask;  // of the data field or among the control inputs
  int shift;      // rotation of the value
  int field;      // of data, else kNoField
};

struct PartPort {
  const PortRow *row;
  Net net;  // in the model
  int width;
  bool output, data;
  bool whole;                 // it is all of its variable
  int shift = 0;              // its lowest bit among the control inputs or outputs; of data 0
  uint64_t mask = 0;          // its bits there, or of the data field
  int field = kNoField;       // of data
  std::vector<Link> links{};  // of an output: inputs on the same board
  Wire *wire = nullptr;       // of an output: to a net that is read outside the board
};

// Where a register is: in the model, and in the state or the data fields.
struct RegisterPlace {
  Net net;    // in the model
  int field;  // of data, else kNoField
  int at;     // of control: its first byte in State::registers()
};

class PartModel {
 public:
  PartModel(const BoardTable &table, size_t n, std::unique_ptr<Board> model,
            VerilatedContext &context);

  // Registers and inputs, and all that follows from them.
  void write(const uint8_t *registers, const uint32_t *fields, uint64_t inputs);
  // Registers, data fields and control outputs.
  uint64_t read(uint8_t *registers, uint32_t *fields) const;
  uint64_t read_outputs(uint32_t *fields) const;
  // A clock, or these inputs.
  void clock();
  void put_inputs(const uint32_t *fields, uint64_t inputs);
  // Registers were written at their nets.
  void registers_written();
  // The control inputs that it has.
  uint64_t inputs() const { return inputs_; }
  // Data decide what it does now.
  bool data_decide() const;

  // A fault holds bits of a register; none: it is free.
  void hold(const RegisterPlace &place, uint64_t zeros, uint64_t ones) {
    held_.hold(place.net, zeros, ones);
  }
  // These values of data, with the bits of them that are held.
  void hold_fields(uint32_t *fields) const;

  // While all of these control outputs are 1, this data output is not observed.
  void ignore_while(uint64_t outputs, const PartPort &port) {
    ignored_.push_back({outputs, 1u << port.field});
  }
  // A fault holds such a control output: data outputs are observed always.
  void never_ignore(bool never) { never_ignored_ = never; }
  // Of these data outputs those that are observed while the control outputs are so.
  uint32_t not_ignored(uint32_t fields, uint64_t outputs) const {
    if (never_ignored_) return fields;
    for (const auto &[ones, ignored] : ignored_) {
      if ((outputs & ones) == ones) fields &= ~ignored;
    }
    return fields;
  }
  // A fault changes what its transitions are.
  bool faulty() const { return held_.any() || never_ignored_; }

  const std::vector<std::unique_ptr<PartPort>> &ports() const { return ports_; }
  const PartPort &port_at(int bit) const { return *by_output_bit_[bit]; }
  const PartPort *port_of(int field) const { return by_field_[field]; }
  RegisterPlace *place(size_t row) const { return by_row_[row]; }
  const std::vector<DataField> &fields() const { return fields_; }
  size_t register_bytes() const { return register_bytes_; }

  const std::string &module() const { return module_; }

  const std::unique_ptr<Board> board;

 private:
  struct Slice {  // a data field that is bits of a control register
    int field, lsb;
    const RegisterPlace *within;
  };
  int add_field(const DataField &field);
  void add_register(size_t row_number, const RegisterRow &row, Net net);
  void add_port(const PartRow &own, const PortRow &row, Net net);
  void write_inputs(const uint32_t *fields, uint64_t inputs);
  void apply_held_bits() {
    if (held_.apply()) board->settle();
  }

  const std::string module_;
  std::vector<DataField> fields_;
  std::vector<std::unique_ptr<PartPort>> ports_;
  std::vector<const PartPort *> by_output_bit_, by_field_;
  std::vector<std::unique_ptr<RegisterPlace>> places_;
  std::vector<RegisterPlace *> by_row_;  // of BoardTable::registers
  std::vector<Slice> slices_;
  std::vector<std::pair<Net, bool>> deciding_;  // nets at which data decide, and at which level
  HeldBits held_;
  std::vector<std::pair<uint64_t, uint32_t>> ignored_;  // control outputs; data outputs
  bool never_ignored_ = false;
  size_t register_bytes_ = 0;
  uint64_t inputs_ = 0;
};

}  // namespace mmcs
