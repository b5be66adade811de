// SPDX-License-Identifier: Apache-2.0
// See part_model.h.

#include "part_model.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace mmcs {
namespace {

uint32_t mask_of(int width) {
  if (width > 32) throw std::logic_error("data of more than 32 bits");
  return width == 32 ? ~0u : (1u << width) - 1;
}

uint64_t bits(int width, int at) {
  if (at + width > 64) throw std::logic_error("a part with too many control ports");
  return (width == 64 ? ~uint64_t{0} : (uint64_t{1} << width) - 1) << at;
}

// Most registers are one byte, and a call for each costs more than the copy.
inline void copy_bytes(void *to, const void *from, int bytes) {
  if (bytes == 1)
    std::memcpy(to, from, 1);
  else
    std::memcpy(to, from, static_cast<size_t>(bytes));
}

}  // namespace

PartModel::PartModel(const BoardTable &table, size_t n, std::unique_ptr<Board> model,
                     VerilatedContext &context)
    : board(std::move(model)), module_(table.parts[n].module) {
  if (const Net clk = board->port("clk_i")) clk.put(1);
  const PartRow &own = table.parts[n];
  const std::string scope = board->name() + "." + own.module;
  // A net by the path of its instance on the board.
  const auto find = [&](std::string path, const char *name) {
    if (const size_t outer = std::strlen(own.path)) {
      path = path.size() > outer ? path.substr(outer + 1) : "";
    }
    Net net = find_net(context, path.empty() ? scope : scope + "." + path, name);
    if (!net && path.empty()) net = board->port(name);
    if (!net) throw std::runtime_error("the model of " + scope + " has no " + name);
    return net;
  };
  for (const DecideRow &row : table.decides) {
    if (static_cast<size_t>(row.part) == n)
      deciding_.emplace_back(find(row.path, row.name), row.level);
  }
  by_row_.resize(table.registers.size());
  for (size_t r = 0; r < table.registers.size(); ++r) {
    const RegisterRow &row = table.registers[r];
    if (static_cast<size_t>(row.part) == n) add_register(r, row, find(row.path, row.name));
  }
  for (const SliceRow &row : table.slices) {
    const RegisterPlace *place = by_row_[static_cast<size_t>(row.reg)];
    if (!place) continue;
    const bool decides = row.kind == Kind::kDecides;
    slices_.push_back(
        {add_field({mask_of(row.width), -1, false, false, false, decides, 0}), row.lsb, place});
  }
  if (register_bytes_ > kMostBytes) throw std::logic_error("a part with too many registers");
  for (const PortRow &row : own.ports) {
    const Net net =
        *row.path ? find_net(context, scope + "." + row.path, row.name) : board->port(row.name);
    if (!net) throw std::runtime_error(scope + " has no port " + row.name);
    add_port(own, row, net);
  }
  by_field_.resize(fields_.size());
  for (const auto &port : ports_) {
    if (!port->data) continue;
    const auto field = static_cast<size_t>(port->field);
    by_field_[field] = port.get();
    if (port->row->driven >= 0)
      fields_[field].driven = ports_[static_cast<size_t>(port->row->driven)]->mask;
  }
}

int PartModel::add_field(const DataField &field) {
  fields_.push_back(field);
  return static_cast<int>(fields_.size()) - 1;
}

void PartModel::add_register(size_t row_number, const RegisterRow &row, Net net) {
  net.width = row.width;
  auto place = std::make_unique<RegisterPlace>(RegisterPlace{net, kNoField, 0});
  if (row.kind == Kind::kControl) {
    place->at = static_cast<int>(register_bytes_);
    register_bytes_ += static_cast<size_t>(net.bytes);
  } else {
    const bool counter = row.kind == Kind::kCounter, decides = row.kind == Kind::kDecides;
    place->field = add_field(
        {mask_of(row.width), counter ? row.margin : -1, counter, false, false, decides, 0});
  }
  by_row_[row_number] = place.get();
  places_.push_back(std::move(place));
}

void PartModel::add_port(const PartRow &own, const PortRow &row, Net net) {
  net.width = 8 * net.bytes;
  const bool data = row.kind != Kind::kControl;
  const bool whole = std::none_of(own.ports.begin(), own.ports.end(), [&row](const PortRow &r) {
    return &r != &row && std::strcmp(r.name, row.name) == 0 && std::strcmp(r.path, row.path) == 0;
  });
  auto port = std::make_unique<PartPort>(PartPort{&row, net, row.width, row.out, data, whole});
  if (data) {
    const bool decides = row.kind == Kind::kDecides;
    port->field = add_field({mask_of(row.width), -1, false, !row.out, row.out, decides, 0});
  } else if (row.out) {
    port->shift = static_cast<int>(by_output_bit_.size());
    by_output_bit_.insert(by_output_bit_.end(), static_cast<size_t>(row.width), port.get());
  } else {
    for (const auto &other : ports_) {
      if (!other->data && !other->output) port->shift += other->width;
    }
  }
  port->mask = bits(row.width, port->shift);
  ports_.push_back(std::move(port));
}

void PartModel::write_inputs(const uint32_t *fields, uint64_t inputs) {
  for (const auto &port : ports_) {
    if (port->output) continue;
    const uint64_t value = port->data ? fields[port->field] : (inputs & port->mask) >> port->shift;
    if (port->whole) {
      port->net.put(value);
      continue;
    }
    const uint64_t own = ((uint64_t{1} << port->width) - 1) << port->row->lsb;
    port->net.put((port->net.get() & ~own) | value << port->row->lsb);
  }
  inputs_ = inputs;
}

void PartModel::write(const uint8_t *registers, const uint32_t *fields, uint64_t inputs) {
  for (const auto &place : places_) {
    if (place->field != kNoField) {
      place->net.put(fields[place->field]);
    } else {
      copy_bytes(place->net.at, registers + place->at, place->net.bytes);
    }
  }
  for (const Slice &s : slices_) {
    const Net &net = s.within->net;
    net.put(net.get() | static_cast<uint64_t>(fields[s.field]) << s.lsb);
  }
  write_inputs(fields, inputs);
  board->settle();
  board->sync();
}

uint64_t PartModel::read(uint8_t *registers, uint32_t *fields) const {
  for (const auto &place : places_) {
    if (place->field != kNoField) {
      fields[place->field] = static_cast<uint32_t>(place->net.get());
    } else {
      copy_bytes(registers + place->at, place->net.at, place->net.bytes);
    }
  }
  for (const Slice &s : slices_) {
    const uint64_t mask = fields_[static_cast<size_t>(s.field)].mask;
    uint64_t own = 0;
    copy_bytes(&own, registers + s.within->at, s.within->net.bytes);
    fields[s.field] = static_cast<uint32_t>(own >> s.lsb & mask);
    own &= ~(mask << s.lsb);
    copy_bytes(registers + s.within->at, &own, s.within->net.bytes);
  }
  return read_outputs(fields);
}

uint64_t PartModel::read_outputs(uint32_t *fields) const {
  uint64_t outputs = 0;
  for (const auto &port : ports_) {
    if (!port->output) continue;
    if (port->data) {
      fields[port->field] = static_cast<uint32_t>(port->net.get());
    } else {
      outputs |= port->net.get() << port->shift & port->mask;
    }
  }
  return outputs;
}

bool PartModel::data_decide() const {
  bool found = false;
  for (const auto &[net, level] : deciding_) found = found || (net.get() != 0) == level;
  return found;
}

void PartModel::clock() {
  board->clock();
  apply_held_bits();
}

void PartModel::put_inputs(const uint32_t *fields, uint64_t inputs) {
  write_inputs(fields, inputs);
  board->inputs();
  apply_held_bits();
}

void PartModel::registers_written() {
  board->settle();
  board->inputs();
  apply_held_bits();
}

void PartModel::hold_fields(uint32_t *fields) const {
  if (!held_.any()) return;
  for (const bool back : {false, true}) {
    for (const auto &place : places_) {
      if (place->field == kNoField) continue;
      if (back)
        fields[place->field] = static_cast<uint32_t>(place->net.get());
      else
        place->net.put(fields[place->field]);
    }
    held_.apply();
  }
}

}  // namespace mmcs
