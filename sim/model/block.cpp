// SPDX-License-Identifier: Apache-2.0
// See block.h.

#include "block.h"

#include <cstring>
#include <stdexcept>

namespace mmcs {

std::unique_ptr<Board> create_Vmark1(VerilatedContext &, const std::string &);
std::unique_ptr<Board> create_Vi8254(VerilatedContext &, const std::string &);
std::unique_ptr<Board> create_Vthct2000(VerilatedContext &, const std::string &);

#if MMCS_SOC
std::unique_ptr<Board> create_Vadaptor_core(VerilatedContext &, const std::string &);
std::unique_ptr<Board> create_Vsoc_host(VerilatedContext &, const std::string &);
#else
std::unique_ptr<Board> create_Vadaptor_vme(VerilatedContext &, const std::string &);
#endif

std::unique_ptr<Board> Board::create(const std::string &module, VerilatedContext &context,
                                     const std::string &name) {
  if (module == "mark1") return create_Vmark1(context, name);
  if (module == "i8254") return create_Vi8254(context, name);
  if (module == "thct2000") return create_Vthct2000(context, name);
#if MMCS_SOC
  if (module == "adaptor_core") return create_Vadaptor_core(context, name);
  if (module == "soc_host") return create_Vsoc_host(context, name);
#else
  if (module == "adaptor_vme") return create_Vadaptor_vme(context, name);
#endif
  throw std::runtime_error("no model of the board " + module);
}

void Copies::add(const char *base, Net from, Net to, bool wakes) {
  if (from.bytes != to.bytes) throw std::logic_error("ports of different sizes");
  const size_t size = static_cast<size_t>(from.bytes);
  (size == 1 ? bytes_ : longer_).push_back({from.at, to.at, size});
  all_.add(base, from);
  if (wakes) waking_.add(base, from);
}

Block::Block(const std::string &module, VerilatedContext &c, const std::string &n)
    : table(board_table(module)), context(c), name(n) {
  units.reserve(table.unit_count);
  for (size_t u = 0; u < table.unit_count; ++u) {
    units.emplace_back(Board::create(table.units[u].module, c, n + "_" + std::to_string(u)));
  }
  for (size_t r = 0; r < table.register_count; ++r) {
    const RegisterRow &row = table.registers[r];
    const Net net = find(row);
    Unit &unit = units[static_cast<size_t>(row.unit)];
    if (row.awake) unit.awake.add(unit.base, net);
    if (row.strides[0] == 0) {
      unit.registers.add(unit.base, net);
      continue;
    }
    Counter counter;
    counter.net = net;
    counter.strides[0] = static_cast<unsigned>(row.strides[0]);
    counter.strides[1] = static_cast<unsigned>(row.strides[1]);
    counter.margin = static_cast<uint64_t>(row.margin);
    if (*row.unless) counter.unless = find(row.path, row.unless);
    unit.counters.push_back(counter);
  }
  for (size_t u = 1; u < units.size(); ++u) {
    const UnitRow &row = table.units[u];
    Chip chip{&units[u], {}, {}, {}};
    for (size_t l = 0; l < row.link_count; ++l) {
      const char *port = row.links[l].name;
      const std::string scope = board().model->name() + "." + module + "." + row.path;
      const Net outer = find_net(context, scope, port), inner = chip.unit->model->port(port);
      if (!outer || !inner) throw std::runtime_error(scope + " has no port " + port);
      if (row.links[l].out) {
        chip.out.add(chip.unit->base, inner, outer, row_of(row.path, port, 0) != nullptr);
      } else {
        const NetRow *net = row_of(row.path, port, u);
        const bool wakes = !net || !net->quiet;  // none: a reset
        chip.in.add(board().base, outer, inner, wakes);
        chip_words_.add(board().base, outer);
        if (wakes) waking_words_.add(board().base, outer);
      }
    }
    chips.push_back(std::move(chip));
  }
  for (size_t g = 0; g < table.guard_count; ++g) {
    const GuardRow &row = table.guards[g];
    if (row.unit < 0) continue;
    Guard &guard = row.unit == 0 ? quiet : chips[static_cast<size_t>(row.unit) - 1].quiet;
    const Net net = row.unit == 0 ? board().model->port(row.name)
                                  : units[static_cast<size_t>(row.unit)].model->port(row.name);
    guard.nets.emplace_back(net, static_cast<uint64_t>(row.value));
  }
}

const NetRow *Block::row_of(const char *path, const char *port, size_t unit) const {
  for (size_t i = 0; i < table.net_count; ++i) {
    const NetRow &row = table.nets[i];
    if (static_cast<size_t>(row.unit) == unit && std::strcmp(row.path, path) == 0 &&
        std::strcmp(row.name, port) == 0) {
      return &row;
    }
  }
  return nullptr;
}

void Block::look_of(Slot &slot) const {
  const NetRow *row = row_of("", slot.row->name, 0);
  slot.late = !row && !slot.row->out;
  if (!row || (row->quiet && !row->guard)) return;
  slot.wakes = true;
  if (row->quiet) slot.quiet = &quiet;
}

Net Block::find(const std::string &path, const std::string &n) const {
  size_t unit = 0;
  std::string inner = path;
  for (size_t u = 1; u < units.size(); ++u) {
    const std::string chip = table.units[u].path;
    if (path != chip && path.compare(0, chip.size() + 1, chip + ".") != 0) continue;
    unit = u;
    inner = path.size() > chip.size() ? path.substr(chip.size() + 1) : "";
  }
  const Board &model = *units[unit].model;
  const std::string scope = model.name() + "." + table.units[unit].module;
  Net net = find_net(context, inner.empty() ? scope : scope + "." + inner, n);
  if (!net && inner.empty()) net = units[unit].model->port(n);
  if (!net) throw std::runtime_error("the model of " + scope + " has no " + path + "." + n);
  return net;
}

void Block::edge(int64_t t) {
  bool stale = board().stale;
  for (Unit &u : units) {
    if (u.due > t) continue;
    u.catch_up(t - 1);
    stale = stale || u.stale;
  }
  if (stale) look(t - 1);
  for (Unit &u : units) {
    if (u.due <= t) u.clock(t);
  }
}

int64_t Block::edges(int64_t t, int64_t end) {
  Unit &own = board();
  waking_words_.moved(own.base);
  edge(t);
  for (const Chip &chip : chips) {
    if (chip.unit->fresh || !chip.quiet.holds()) return t;
    end = chip.unit->due < end ? chip.unit->due : end;
  }
  while (own.due == t + 1 && own.due < end && !waking_words_.moved(own.base) &&
         !(outs_moved = out_words.moved(own.base))) {
    ++t;
    own.model->clock();
    own.judge(t);
  }
  return t;
}

void Block::whole_edge(int64_t t) {
  for (uint64_t level = 0; level < 2; ++level) {
    for (Unit &u : units) {
      u.model->port("clk_i").put(level);
      u.model->eval();
    }
  }
  for (Unit &u : units) {
    u.poke();
    u.stale = false;
    u.fresh = true;
    u.renew(t);
  }
}

void Block::look(int64_t t) {
  Unit &own = board();
  do {
    if (own.stale) own.follow(t);
    const bool told = own.fresh && chip_words_.moved(own.base);
    own.fresh = false;
    for (Chip &chip : chips) {
      Unit &unit = *chip.unit;
      bool woken;
      if (told && chip.in.take(own.base, &woken)) {
        unit.stale = true;
        if (woken || !chip.quiet.holds()) unit.wake(t);
      }
      if (unit.stale && unit.due <= t + 1) unit.follow(t);  // else no output would move
      if (!unit.fresh) continue;
      unit.fresh = false;
      if (chip.out.take(unit.base, &woken)) {
        own.stale = true;
        if (woken) own.wake(t);
      }
    }
  } while (own.stale);
}

void Block::renew(int64_t t) {
  for (Unit &u : units) u.renew(t);
}

// Clocks of chips up to edge t, of which nothing is to be seen outside.
void Block::run(int64_t t) {
  for (Chip &chip : chips) {
    Unit &unit = *chip.unit;
    while (unit.due <= t) {
      const int64_t at = unit.due;
      unit.catch_up(at - 1);
      if (unit.stale) unit.follow(at - 1);
      unit.clock(at);
    }
    bool woken;
    if (unit.fresh && chip.out.take(unit.base, &woken)) {
      throw std::logic_error(name + "." + unit.model->name() + " moved an output late");
    }
    unit.fresh = false;
  }
}

void Block::catch_up(int64_t t) {
  for (size_t n = 0; n < deferred_.size(); ++n) {
    const Change change = deferred_[n];
    run(change.t);
    change.port.put(change.value);
    board().stale = true;
    look(change.t);
  }
  if (!deferred_.empty()) {
    deferred_.clear();
    run(t);
  }
  for (Unit &u : units) u.catch_up(t);
}

void Block::written(int64_t t) {
  for (Unit &u : units) u.written(t);
}

}  // namespace mmcs
