// SPDX-License-Identifier: Apache-2.0
// See part.h: a part and its Verilated model, which is run where the cache does not know.

#include <algorithm>

#include "part.h"

namespace mmcs {
namespace {

// Most registers are one byte, and a call for each costs more than the copy.
inline void copy_bytes(void *to, const void *from, int bytes) {
  switch (bytes) {
    case 1:
      std::memcpy(to, from, 1);
      break;
    case 2:
      std::memcpy(to, from, 2);
      break;
    case 4:
      std::memcpy(to, from, 4);
      break;
    default:
      std::memcpy(to, from, static_cast<size_t>(bytes));
  }
}

}  // namespace

void Part::put_inputs(const uint32_t *cells, uint64_t in) {
  for (const auto &port : ports_) {
    if (port->out) continue;
    const uint64_t value = port->data ? cells[port->at] : (in & port->mask) >> port->at;
    if (port->whole) {
      port->net.put(value);
      continue;
    }
    const uint64_t bits = ((uint64_t{1} << port->width) - 1) << port->row->lsb;
    port->net.put((port->net.get() & ~bits) | value << port->row->lsb);
  }
  model_in_ = in;
}

// The model has these registers and inputs, and all that follows from them.
void Part::put_state(const uint8_t *registers, const uint32_t *cells, uint64_t in) {
  for (const auto &place : places_) {
    if (place->cell >= 0) {
      place->net.put(cells[place->cell]);
    } else {
      copy_bytes(place->net.at, registers + place->at, place->net.bytes);
    }
  }
  for (const Slice &s : slices_) {
    const Net &net = s.within->net;
    net.put(net.get() | static_cast<uint64_t>(cells[s.cell]) << s.lsb);
  }
  put_inputs(cells, in);
  model->settle();
  model->sync();
}

// Registers and data outputs of the model; control outputs.
uint64_t Part::look(uint8_t *registers, uint32_t *cells) const {
  for (const auto &place : places_) {
    if (place->cell >= 0) {
      cells[place->cell] = static_cast<uint32_t>(place->net.get());
    } else {
      copy_bytes(registers + place->at, place->net.at, place->net.bytes);
    }
  }
  for (const Slice &s : slices_) {
    const uint64_t mask = cache->cells()[static_cast<size_t>(s.cell)].mask;
    uint64_t own = 0;
    copy_bytes(&own, registers + s.within->at, s.within->net.bytes);
    cells[s.cell] = static_cast<uint32_t>(own >> s.lsb & mask);
    own &= ~(mask << s.lsb);
    copy_bytes(registers + s.within->at, &own, s.within->net.bytes);
  }
  return look_at_outputs(cells);
}

uint64_t Part::look_at_outputs(uint32_t *cells) const {
  uint64_t out = 0;
  for (const auto &port : ports_) {
    if (!port->out) continue;
    if (port->data) {
      cells[port->at] = static_cast<uint32_t>(port->net.get());
    } else {
      out |= port->net.get() << port->at & port->mask;
    }
  }
  return out;
}

// Data decide what the model does now.
bool Part::decided() const {
  bool found = false;
  for (const auto &[net, level] : decides_) found = found || (net.get() != 0) == level;
  return found;
}

void Part::op(bool clock) {
  if (clock) {
    model->clock();
  } else {
    put_inputs(cells_, in_);
    model->inputs();
  }
  poke();
}

void Part::load() {
  if (!live_ && state_) put_state(state_->registers(), cells_, state_->in);
  live_ = true;
}

void Part::run(bool clock) {
  load();
  op(clock);
  store();
}

// The state and the cells are what the model has.
void Part::store() {
  uint8_t registers[kMostBytes] = {};
  uint32_t before[kMostCells];
  std::memcpy(before, cells_, sizeof before);
  out_ = look(registers, cells_);
  const auto &cells = cache->cells();
  for (size_t c = 0; c < cells.size(); ++c) {
    if (cells[c].out && cells_[c] != before[c]) moved_ |= 1u << c;
  }
  live_ = true;
  state_ = nullptr;
  if (cached_) state_ = cache->make(registers, cache->near(cells_), model_in_, out_);
}

// The state with these registers, the cells and inputs as they are; is_case: its outputs may be by
// the values of cells.
State *Part::state_of(const uint8_t *registers, bool is_case) {
  const uint64_t near = cache->near(cells_);
  State *known = is_case ? nullptr : cache->find(registers, near, in_, nullptr);
  if (known) return known;
  put_state(registers, cells_, in_);
  uint8_t unused[kMostBytes];
  uint32_t cells[kMostCells];
  return cache->make(registers, near, in_, look(unused, cells));
}

// A transition of the state, by its inputs or, where data decide, by the values of the cells.
Transition *Part::learn(bool clock, uint64_t in, bool is_case) {
  State *from = state_;
  const auto &cells = cache->cells();
  uint32_t fixed = cache->fixed(from->near, in_), valued = 0;
  if (is_case) {
    for (size_t c : cache->deciding()) valued |= 1u << c;
  }
  fixed |= valued;
  std::vector<Cache::Seen> seen(kMarks);
  uint8_t registers[kMostBytes] = {}, others[kMostBytes] = {};
  uint64_t out = 0;
  bool same = true;
  uint32_t actual[kMostCells];
  std::memcpy(actual, cells_, sizeof actual);
  for (int set = 0; set < kMarks && same; ++set) {
    Cache::Seen &s = seen[static_cast<size_t>(set)];
    for (size_t c = 0; c < cells.size(); ++c) {
      if (!(fixed >> c & 1))
        cells_[c] = cache->mark(set, c);
      else if (cells[c].in && !(valued >> c & 1))
        cells_[c] = cells[c].mask;
    }
    for (const Poke &p : pokes_) {
      if (p.place->cell < 0) continue;
      uint32_t &cell = cells_[p.place->cell];
      cell = static_cast<uint32_t>((cell & ~p.clear) | p.set);
    }
    std::memcpy(s.before, cells_, sizeof s.before);
    std::memcpy(s.after, cells_, sizeof s.after);
    if (!clock) {  // inputs that are data come from other values
      uint32_t old[kMostCells];
      for (size_t c = 0; c < cells.size(); ++c) {
        const bool ones = cells[c].driven && !(from->in & cells[c].driven);
        old[c] = !cells[c].in || valued >> c & 1 ? cells_[c]
                 : ones                          ? cells[c].mask
                                                 : ~cache->mark(set, c) & cells[c].mask;
      }
      put_state(from->registers(), cells_, from->in);
      look_at_outputs(s.data);
      put_state(from->registers(), old, from->in);
    } else {
      put_state(from->registers(), cells_, from->in);
    }
    look_at_outputs(s.before);
    const bool before = decided();
    op(clock);
    if ((before || decided()) && !is_case) same = false;
    const uint64_t outs = look(set ? others : registers, s.after);
    if (set) same = same && outs == out && !std::memcmp(registers, others, register_bytes_);
    out = outs;
  }
  std::memcpy(cells_, actual, sizeof actual);
  live_ = false;
  Draft draft;
  const bool found = same && cache->explain(seen, fixed, clock, &draft);
  Transition *t = cache->add(found ? draft : Draft{}, in, nullptr);
  t->is_case = is_case;
  if (found) {
    const uint32_t moved = moved_;
    apply(*t);  // what is shown does not matter
    t->to = state_of(registers, is_case);
    t->rests = t->rests && t->to == from;
    t->tells = ((t->to->out ^ from->out) & shown_out_) != 0;
    const uint32_t shown = selected(shown_cells_, from->out) | selected(shown_cells_, t->to->out);
    for (const Copy &c : draft.copies) t->tells = t->tells || shown >> c.to & 1;
    std::memcpy(cells_, actual, sizeof actual);
    moved_ = moved;
  } else {
    t->decided = !is_case && !draft.computed && !cache->deciding().empty();
  }
  return t;
}

void Part::written(int64_t t) {
  model->settle();
  model->inputs();
  poke();
  store();
  last_ = t;
  due_ = t + 1;
  rests_ = false;
}

// With held bits its transitions are others than those of its module: it has a cache of its own.
void Part::hold(const Poke &poke) {
  pokes_.erase(std::remove_if(pokes_.begin(), pokes_.end(),
                              [&poke](const Poke &p) { return p.place == poke.place; }),
               pokes_.end());
  if (poke.clear || poke.set) pokes_.push_back(poke);
  own_cache(!pokes_.empty() || always_selected_);
}

void Part::select_always(bool always) {
  if (always == always_selected_) return;
  always_selected_ = always;
  own_cache(!pokes_.empty() || always_selected_);
}

void Part::own_cache(bool own) {
  cache = own ? std::make_shared<Cache>(free_->cells(), register_bytes_) : free_;
  state_ = nullptr;
}

void Part::poke() {
  bool changed = false;
  for (const Poke &p : pokes_) {
    const Net &net = p.place->net;
    const uint64_t before = net.get(), after = (before & ~p.clear) | p.set;
    changed = changed || before != after;
    net.put(after);
  }
  if (changed) model->settle();
}

uint64_t Part::read(const Place &place) const {
  if (live_) return place.net.get();
  if (place.cell >= 0) return cells_[place.cell];
  uint64_t value = 0;
  std::memcpy(&value, state_->registers() + place.at, static_cast<size_t>(place.net.bytes));
  for (const Slice &s : slices_) {
    if (s.within == &place) value |= static_cast<uint64_t>(cells_[s.cell]) << s.lsb;
  }
  return value;
}

void Part::forget() {
  load();
  state_ = nullptr;
}

}  // namespace mmcs
