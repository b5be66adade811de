// SPDX-License-Identifier: Apache-2.0
// See part.h.

#include "part.h"

#include <algorithm>
#include <stdexcept>

namespace mmcs {
namespace {

constexpr int kLongest = 64;  // clocks that are postponed at once, unless the part is idle then

uint32_t mask_of(int width) {
  if (width > 32) throw std::logic_error("data of more than 32 bits");
  return width == 32 ? ~0u : (1u << width) - 1;
}

uint64_t bits(int width, int at) {
  if (at + width > 64) throw std::logic_error("a part with too many control ports");
  return (width == 64 ? ~uint64_t{0} : (uint64_t{1} << width) - 1) << at;
}

}  // namespace

Part::Part(const BoardTable &table, size_t n, std::unique_ptr<Board> m,
           std::shared_ptr<Cache> *known, VerilatedContext &context,
           uint32_t (&fields_of_it)[kMostFields])
    : model(std::move(m)), fields_(fields_of_it) {
  if (const Net clk = model->port("clk_i")) clk.put(1);
  const PartRow &own = table.parts[n];
  const std::string scope = model->name() + "." + own.module;
  std::vector<DataField> fields;
  // A net by the path of its instance on the board.
  const auto find = [&](std::string path, const char *name) {
    if (const size_t outer = std::strlen(own.path)) {
      path = path.size() > outer ? path.substr(outer + 1) : "";
    }
    Net net = find_net(context, path.empty() ? scope : scope + "." + path, name);
    if (!net && path.empty()) net = model->port(name);
    if (!net) throw std::runtime_error("the model of " + scope + " has no " + name);
    return net;
  };
  for (const DecideRow &row : table.decides) {
    if (static_cast<size_t>(row.part) == n) {
      layout_.deciding.emplace_back(find(row.path, row.name), row.level);
    }
  }
  layout_.by_row.resize(table.registers.size());
  for (size_t r = 0; r < table.registers.size(); ++r) {
    const RegisterRow &row = table.registers[r];
    if (static_cast<size_t>(row.part) == n) add_register(r, row, find(row.path, row.name), &fields);
  }
  for (const SliceRow &row : table.slices) {
    const RegisterPlace *place = layout_.by_row[static_cast<size_t>(row.reg)];
    if (!place) continue;
    layout_.slices.push_back({static_cast<int>(fields.size()), row.lsb, place});
    fields.push_back({mask_of(row.width), -1, false, false, false, row.kind == Kind::kDecides, 0});
  }
  if (layout_.register_bytes > kMostBytes) throw std::logic_error("a part with too many registers");
  ports_.by_field.resize(fields.size());
  for (const PortRow &row : own.ports) {
    const Net net =
        *row.path ? find_net(context, scope + "." + row.path, row.name) : model->port(row.name);
    if (!net) throw std::runtime_error(scope + " has no port " + row.name);
    add_port(own, row, net, &fields);
  }
  for (const auto &port : ports_.all) {
    if (port->row->driven < 0) continue;
    fields[static_cast<size_t>(port->field)].driven =
        ports_.all[static_cast<size_t>(port->row->driven)]->mask;
  }
  if (!*known) *known = std::make_shared<Cache>(fields, layout_.register_bytes);
  cache = module_cache_ = *known;
  write_model_inputs(fields_, 0);
}

void Part::add_register(size_t row_number, const RegisterRow &row, Net net,
                        std::vector<DataField> *fields) {
  net.width = row.width;
  auto place = std::make_unique<RegisterPlace>(RegisterPlace{net, kNoField, 0});
  if (row.kind == Kind::kControl) {
    place->at = static_cast<int>(layout_.register_bytes);
    layout_.register_bytes += static_cast<size_t>(net.bytes);
  } else {
    place->field = static_cast<int>(fields->size());
    const bool counter = row.kind == Kind::kCounter;
    fields->push_back({mask_of(row.width), counter ? row.margin : -1, counter, false, false,
                       row.kind == Kind::kDecides, 0});
  }
  layout_.by_row[row_number] = place.get();
  layout_.places.push_back(std::move(place));
}

void Part::add_port(const PartRow &own, const PortRow &row, Net net,
                    std::vector<DataField> *fields) {
  net.width = 8 * net.bytes;
  const bool data = row.kind != Kind::kControl;
  const bool whole = std::none_of(own.ports.begin(), own.ports.end(), [&row](const PortRow &r) {
    return &r != &row && std::strcmp(r.name, row.name) == 0 && std::strcmp(r.path, row.path) == 0;
  });
  auto port = std::make_unique<PartPort>(PartPort{&row, net, row.width, row.out, data, whole});
  if (data) {
    port->field = static_cast<int>(fields->size());
    fields->push_back(
        {mask_of(row.width), -1, false, !row.out, row.out, row.kind == Kind::kDecides, 0});
    ports_.by_field.push_back(port.get());
  } else if (row.out) {
    port->shift = static_cast<int>(ports_.by_output_bit.size());
    ports_.by_output_bit.insert(ports_.by_output_bit.end(), static_cast<size_t>(row.width),
                                port.get());
  } else {
    for (const auto &other : ports_.all) {
      if (!other->data && !other->output) port->shift += other->width;
    }
  }
  if (!data) port->mask = bits(row.width, port->shift);
  ports_.all.push_back(std::move(port));
}

void Part::connected() {
  out_.observed = line_mask;
  for (const auto &port : ports_.all) {
    if (!port->output || (!port->wire && port->links.empty())) continue;
    if (port->data) {
      out_.observed_fields |= 1u << port->field;
    } else {
      out_.observed |= port->mask;
    }
  }
  out_.sampled |= out_.observed;
  out_.sampled_fields |= out_.observed_fields;
}

// --- with the cache --------------------------------------------------------------------------

// Counters may have come to their margin, or have left it: then the state is another one.
void Part::enter_margin(const Transition &t) {
  const uint64_t counters = cache->counters(fields_);
  if (counters == state_->counters) return;
  Transition &known = const_cast<Transition &>(t);
  if (!known.at_margin || known.at_margin->counters != counters)
    known.at_margin = state_of(state_->registers(), t.is_case);
  state_ = known.at_margin;
}

// A step that is not learned yet, that data decide, or that is compared with the model.
void Part::step_slowly(Transition **at, bool clock) {
  bool known = *at;
  if (!known) *at = learn(clock, in_.control, false);
  if ((*at)->decided) {
    const uint64_t values = cache->values(fields_);
    at = &(*at)->cases;
    while (*at && (*at)->key != values) at = &(*at)->next;
    known = *at;
    if (!known) *at = learn(clock, values, true);
  }
  Transition *t = *at;
  if (!t->to) {
    ++misses;
    load();
    evaluate(clock);
    return store();
  }
  ++(known ? hits : misses);
  if (check && ++mode_.steps % static_cast<unsigned>(check) == 0)
    return compare_with_model(*t, clock);
  perform(*t);
}

// Makes a step of the cache and of the model.
void Part::compare_with_model(const Transition &t, bool clock) {
  load();
  evaluate(clock);
  uint8_t registers[kMostBytes] = {};
  uint32_t fields[kMostFields] = {};
  const uint64_t outputs = read_model(registers, fields);
  perform(t);
  bool same = outputs == out_.control &&
              !std::memcmp(registers, state_->registers(), layout_.register_bytes);
  for (size_t f = 0; f < cache->fields().size(); ++f) {
    same = same && (cache->fields()[f].input || fields[f] == fields_[f]);
  }
  if (!same) throw std::logic_error(model->name() + ": the cache differs from the model");
}

// The cache does not know its state.
bool Part::inputs_changed_slowly(int64_t t) {
  catch_up(t);
  if (mode_.cached) {
    store();
    return inputs_changed(time_.last);
  }
  evaluate(false);
  in_.changed_fields = 0;
  store();
  plan();
  return true;
}

void Part::clock_slowly() {
  if (mode_.cached) {
    store();
    step(&state_->on_clock, true);
  } else {
    evaluate(true);
    store();
  }
  plan();
}

void Part::slow_clock(int64_t t) {
  for (uint64_t level = 0; level < 2; ++level) {
    if (const Net clk = model->port("clk_i")) clk.put(level);
    model->eval();
  }
  apply_held_bits();
  store();
  time_.last = t;
  plan();
}

void Part::catch_up_slowly(int64_t t) {
  while (time_.last < t) {
    const Transition *next = state_ ? state_->on_clock : nullptr;
    if (!next || !next->to) {  // a clock that the model computes is not postponed
      time_.last = t;
    } else if (next->idle && changes_nothing(*next)) {
      count(*next, t - time_.last);
      time_.last = t;
    } else {
      perform(*next);
      ++hits;
      ++time_.last;
    }
  }
}

// A clock leaves the data fields as they are, but for what counts.
bool Part::changes_nothing(const Transition &t) const {
  for (const Copy &c : t.copies()) {
    if (c.apply(fields_[c.to], fields_[c.from]) != fields_[c.to]) return false;
  }
  return true;
}

// Plans by the data fields, or in this state for the first time.
void Part::plan_slowly() {
  const Transition *t = state_->on_clock;
  if (!t) return;
  if (t->idle && (t->near_margin || t->copy_count != 0)) {
    state_->idle = t->copy_count == 0;
    time_.idle = changes_nothing(*t);
    if (time_.idle) time_.due = t->near_margin ? margin_edge(*t) : kNever;
    return;
  }
  look_ahead(state_);
  if (state_->silent_clocks >= 0) plan();
}

// Finds the silent clocks of a state, if the transitions of all of them are known.
void Part::look_ahead(State *s) {
  int16_t clocks = 0;
  for (const Transition *t = s->on_clock;; t = t->to->on_clock, ++clocks) {
    if (!t) return;
    if (clocks == kLongest || !t->to || t->near_margin || t->observed) break;
    if (t->idle) {
      if (t->count_count != 0 && clocks != 0) break;
      s->then_idle = t->copy_count == 0;
      break;
    }
  }
  s->silent_clocks = clocks;
  s->idle = s->then_idle && clocks == 0;
  s->constant = s->idle && s->on_clock->count_count == 0;
}

// The edge at which a counter of an idle part comes to its margin.
int64_t Part::margin_edge(const Transition &t) const {
  int64_t clocks = kNever;
  for (const Count &c : t.counts()) {
    if (c.margin < 0) continue;
    const uint32_t down = (0 - c.by) & c.mask, now = fields_[c.field];
    int64_t left = int64_t{now} - c.margin - 1;
    if (down > c.mask / 2 + 1)
      left = (int64_t{c.mask} - now) / c.by;
    else if (down != 1)
      left /= down;
    clocks = std::min(clocks, left);
  }
  return clocks == kNever ? kNever : time_.last + clocks + 1;
}

}  // namespace mmcs
