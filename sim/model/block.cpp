// SPDX-License-Identifier: Apache-2.0
// See block.h.

#include "block.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace mmcs {

std::unique_ptr<Board> create_Vadaptor_vme(VerilatedContext &, const std::string &);
std::unique_ptr<Board> create_Vmark1(VerilatedContext &, const std::string &);

std::unique_ptr<Board> Board::create(const std::string &module, VerilatedContext &context,
                                     const std::string &name) {
  if (module == "adaptor_vme") return create_Vadaptor_vme(context, name);
  if (module == "mark1") return create_Vmark1(context, name);
  throw std::runtime_error("no model of the board " + module);
}

Block::Block(const std::string &module, VerilatedContext &c, const std::string &n)
    : table(board_table(module)), context(c), name(n), board(Board::create(module, c, n)) {
  base = board->base();
  units.resize(table.unit_count);
  for (size_t u = 0; u < units.size(); ++u) {
    const std::string path = table.units[u];
    const std::string clock = path.empty() ? "clk_i" : module + "." + path + ".clk_i";
    units[u].trigger = board->trigger(clock);
    if (!units[u].trigger) throw std::runtime_error(module + " has no clock " + clock);
  }
  for (size_t r = 0; r < table.register_count; ++r) {
    const RegisterRow &row = table.registers[r];
    Net net = find(row.path, row.name);
    net.width = row.width;
    Unit &unit = units[static_cast<size_t>(row.unit)];
    if (row.awake) unit.awake.push_back(net);
    if (row.strides[0] == 0) {
      unit.registers.add(base, net);
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
  for (size_t i = 0; i < table.net_count; ++i) {
    const NetRow &row = table.nets[i];
    if (!*row.path) continue;  // a port: look_of()
    Unit &unit = units[static_cast<size_t>(row.unit)];
    const Net net = find(row.path, row.name);
    if (!row.quiet) unit.inputs.add(base, net);
    if (row.quiet && row.guard) unit.quiet_inputs.add(base, net);
  }
  for (size_t g = 0; g < table.guard_count; ++g) {
    const GuardRow &row = table.guards[g];
    if (row.unit < 0) continue;
    units[static_cast<size_t>(row.unit)].quiet.nets.emplace_back(find(row.path, row.name),
                                                                 static_cast<uint64_t>(row.value));
  }
}

Look Block::look_of(const char *port) {
  Look found{nullptr, nullptr};
  for (size_t i = 0; i < table.net_count; ++i) {
    const NetRow &row = table.nets[i];
    if (*row.path || std::strcmp(row.name, port) != 0 || (row.quiet && !row.guard)) continue;
    Unit &unit = units[static_cast<size_t>(row.unit)];
    found = {&unit, row.quiet ? &unit.quiet : nullptr};
  }
  return found;
}

Net Block::find(const std::string &path, const std::string &n) const {
  const std::string module = table.module;
  const std::string scope = name + "." + module + (path.empty() ? "" : "." + path);
  Net net = find_net(context, scope, n);
  if (!net && path.empty()) net = board->port(n);
  if (!net) throw std::runtime_error("the model of " + module + " has no " + path + "." + n);
  return net;
}

void Block::edge(int64_t t) {
  uint64_t triggers = 0;
  for (Unit &u : units) {
    if (u.due > t) continue;
    triggers |= u.trigger;
    if (u.catch_up(t - 1)) stale = true;
  }
  if (!triggers) return;
  if (stale) {
    board->inputs();
    stale = false;
  }
  board->registers(triggers);
  if (!pokes.empty()) poke();
  for (Unit &u : units) {
    if (u.due <= t) u.clocked(base, t);
  }
}

void Block::whole_edge(int64_t t) {
  const Net clk = board->port("clk_i");
  clk.put(0);
  board->eval();
  clk.put(1);
  board->eval();
  stale = false;
  poke();
  wake(t);
}

void Block::poke() {
  bool changed = false;
  for (const Poke &p : pokes) {
    const uint64_t before = p.net.get(), after = (before & ~p.clear) | p.set;
    changed = changed || before != after;
    p.net.put(after);
  }
  if (changed) board->settle();
}

void Block::look(int64_t t) {
  if (stale) {
    if (reset) {
      catch_up(t);
      board->eval();
      wake(t);
      reset = false;
    }
    board->inputs();
    stale = false;
  }
  for (int round = 0; round < 3; ++round) {
    for (Unit &u : units) {
      if (u.look(base, t)) stale = true;
    }
    if (!stale) break;
    board->inputs();
    stale = false;
  }
  next = due();
}

void Block::wake(int64_t t) {
  for (Unit &u : units) u.renew(t);
  next = t + 1;
}

void Block::catch_up(int64_t t) {
  for (Unit &u : units) {
    if (u.catch_up(t)) stale = true;
  }
}

}  // namespace mmcs
