// SPDX-License-Identifier: Apache-2.0
// See part.h: a part and its Verilated model, which is evaluated where the cache does not know.

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

void Part::write_model_inputs(const uint32_t *fields, uint64_t inputs) {
  for (const auto &port : ports_.all) {
    if (port->output) continue;
    const uint64_t value = port->data ? fields[port->field] : (inputs & port->mask) >> port->shift;
    if (port->whole) {
      port->net.put(value);
      continue;
    }
    const uint64_t bits = ((uint64_t{1} << port->width) - 1) << port->row->lsb;
    port->net.put((port->net.get() & ~bits) | value << port->row->lsb);
  }
  mode_.model_inputs = inputs;
}

// The model has these registers and inputs, and all that follows from them.
void Part::write_model(const uint8_t *registers, const uint32_t *fields, uint64_t inputs) {
  for (const auto &place : layout_.places) {
    if (place->field != kNoField) {
      place->net.put(fields[place->field]);
    } else {
      copy_bytes(place->net.at, registers + place->at, place->net.bytes);
    }
  }
  for (const Slice &s : layout_.slices) {
    const Net &net = s.within->net;
    net.put(net.get() | static_cast<uint64_t>(fields[s.field]) << s.lsb);
  }
  write_model_inputs(fields, inputs);
  model->settle();
  model->sync();
}

// Registers, data fields and control outputs of the model.
uint64_t Part::read_model(uint8_t *registers, uint32_t *fields) const {
  for (const auto &place : layout_.places) {
    if (place->field != kNoField) {
      fields[place->field] = static_cast<uint32_t>(place->net.get());
    } else {
      copy_bytes(registers + place->at, place->net.at, place->net.bytes);
    }
  }
  for (const Slice &s : layout_.slices) {
    const uint64_t mask = cache->fields()[static_cast<size_t>(s.field)].mask;
    uint64_t own = 0;
    copy_bytes(&own, registers + s.within->at, s.within->net.bytes);
    fields[s.field] = static_cast<uint32_t>(own >> s.lsb & mask);
    own &= ~(mask << s.lsb);
    copy_bytes(registers + s.within->at, &own, s.within->net.bytes);
  }
  return read_model_outputs(fields);
}

uint64_t Part::read_model_outputs(uint32_t *fields) const {
  uint64_t outputs = 0;
  for (const auto &port : ports_.all) {
    if (!port->output) continue;
    if (port->data) {
      fields[port->field] = static_cast<uint32_t>(port->net.get());
    } else {
      outputs |= port->net.get() << port->shift & port->mask;
    }
  }
  return outputs;
}

// Data decide what the model does now.
bool Part::data_decide() const {
  bool found = false;
  for (const auto &[net, level] : layout_.deciding) found = found || (net.get() != 0) == level;
  return found;
}

void Part::evaluate(bool clock) {
  if (clock) {
    model->clock();
  } else {
    write_model_inputs(fields_, in_.control);
    model->inputs();
  }
  apply_held_bits();
}

void Part::load() {
  if (!mode_.model_current && state_) write_model(state_->registers(), fields_, state_->inputs);
  mode_.model_current = true;
}

// Takes state and data fields from the model.
void Part::store() {
  uint8_t registers[kMostBytes] = {};
  uint32_t before[kMostFields];
  std::memcpy(before, fields_, sizeof before);
  out_.control = read_model(registers, fields_);
  const auto &fields = cache->fields();
  for (size_t f = 0; f < fields.size(); ++f) {
    if (fields[f].output && fields_[f] != before[f]) out_.pending_fields |= 1u << f;
  }
  mode_.model_current = true;
  state_ = nullptr;
  if (mode_.cached)
    state_ = cache->make(registers, cache->counters(fields_), mode_.model_inputs, out_.control);
}

// The state with these registers and the inputs and data fields as they are; is_case: its outputs
// may depend on the values of fields.
State *Part::state_of(const uint8_t *registers, bool is_case) {
  const uint64_t counters = cache->counters(fields_);
  State *known = is_case ? nullptr : cache->find(registers, counters, in_.control, nullptr);
  if (known) return known;
  write_model(registers, fields_, in_.control);
  uint8_t unused[kMostBytes];
  uint32_t fields[kMostFields];
  return cache->make(registers, counters, in_.control, read_model(unused, fields));
}

// Makes a step of the model with one set of patterns. valued: the fields that decide, by bit, which
// have their values; fixed: these, and others without a pattern. True: data decide.
bool Part::observe(int set, bool clock, uint32_t fixed, uint32_t valued, Observation *seen) {
  State *from = state_;
  const auto &fields = cache->fields();
  for (size_t f = 0; f < fields.size(); ++f) {
    if (!(fixed >> f & 1))
      fields_[f] = cache->pattern(set, f);
    else if (fields[f].input && !(valued >> f & 1))
      fields_[f] = fields[f].mask;
  }
  for (const HeldBits &h : held_) {
    if (h.place->field == kNoField) continue;
    uint32_t &field = fields_[h.place->field];
    field = static_cast<uint32_t>((field & ~h.clear) | h.set);
  }
  std::memcpy(seen->before, fields_, sizeof seen->before);
  std::memcpy(seen->after, fields_, sizeof seen->after);
  write_model(from->registers(), fields_, from->inputs);
  if (!clock) {  // data inputs had other values before
    uint32_t old[kMostFields];
    for (size_t f = 0; f < fields.size(); ++f) {
      const bool ones = fields[f].driven && !(from->inputs & fields[f].driven);
      old[f] = !fields[f].input || valued >> f & 1 ? fields_[f]
               : ones                              ? fields[f].mask
                                                   : ~cache->pattern(set, f) & fields[f].mask;
    }
    read_model_outputs(seen->data);
    write_model(from->registers(), old, from->inputs);
  }
  read_model_outputs(seen->before);
  const bool before = data_decide();
  evaluate(clock);
  return before || data_decide();
}

// A transition of the state, by its inputs or, where data decide, by the values of the fields.
Transition *Part::learn(bool clock, uint64_t key, bool is_case) {
  State *from = state_;
  uint32_t valued = 0;
  if (is_case) {
    for (size_t f : cache->deciding()) valued |= 1u << f;
  }
  const uint32_t fixed = cache->fixed(from->counters, in_.control) | valued;
  std::vector<Observation> seen(kPatterns);
  uint8_t registers[kMostBytes] = {}, others[kMostBytes] = {};
  uint64_t outputs = 0;
  bool same = true;  // of all sets: the key of the next state
  uint32_t actual[kMostFields];
  std::memcpy(actual, fields_, sizeof actual);
  for (int set = 0; set < kPatterns && same; ++set) {
    Observation &s = seen[static_cast<size_t>(set)];
    same = !observe(set, clock, fixed, valued, &s) || is_case;
    const uint64_t now = read_model(set ? others : registers, s.after);
    if (set) {
      same = same && now == outputs && !std::memcmp(registers, others, layout_.register_bytes);
    }
    outputs = now;
  }
  std::memcpy(fields_, actual, sizeof actual);
  mode_.model_current = false;
  Draft draft;
  const bool found = same && cache->derive(seen, fixed, clock, &draft);
  Transition *t = cache->add(found ? draft : Draft{}, key, nullptr);
  t->is_case = is_case;
  if (!found) {
    t->decided = !is_case && !draft.computed && !cache->deciding().empty();
    return t;
  }
  const uint32_t pending = out_.pending_fields;
  apply(*t);  // feedthroughs do not change the key
  t->to = state_of(registers, is_case);
  std::memcpy(fields_, actual, sizeof actual);
  out_.pending_fields = pending;
  t->idle = t->idle && t->to == from;
  t->observed = ((t->to->outputs ^ from->outputs) & out_.sampled) != 0;
  const uint32_t sampled = not_ignored(out_.sampled_fields, from->outputs) |
                           not_ignored(out_.sampled_fields, t->to->outputs);
  for (const Copy &c : draft.copies) t->observed = t->observed || sampled >> c.to & 1;
  return t;
}

Transition *Part::learn_from(State *state, uint64_t inputs, const uint32_t *fields, bool clock,
                             uint64_t key, bool is_case) {
  State *const own_state = state_;
  const uint64_t own_inputs = in_.control;
  uint32_t own[kMostFields];
  std::memcpy(own, fields_, sizeof own);
  std::memcpy(fields_, fields, sizeof own);
  state_ = state;
  in_.control = inputs;
  Transition *t = learn(clock, key, is_case);
  state_ = own_state;
  in_.control = own_inputs;
  std::memcpy(fields_, own, sizeof own);
  return t;
}

void Part::written(int64_t t) {
  model->settle();
  model->inputs();
  apply_held_bits();
  store();
  time_.last = t;
  time_.due = t + 1;
  time_.idle = false;
}

// With held bits its transitions are others than those of its module: it has a cache of its own.
void Part::hold(const HeldBits &bits) {
  held_.erase(std::remove_if(held_.begin(), held_.end(),
                             [&bits](const HeldBits &h) { return h.place == bits.place; }),
              held_.end());
  if (bits.clear || bits.set) held_.push_back(bits);
  own_cache(!held_.empty() || out_.never_ignored);
}

void Part::never_ignore(bool never) {
  if (never == out_.never_ignored) return;
  out_.never_ignored = never;
  own_cache(!held_.empty() || out_.never_ignored);
}

void Part::own_cache(bool own) {
  cache = own ? std::make_shared<Cache>(module_cache_->fields(), layout_.register_bytes)
              : module_cache_;
  state_ = nullptr;
}

void Part::apply_held_bits() {
  bool changed = false;
  for (const HeldBits &p : held_) {
    const Net &net = p.place->net;
    const uint64_t before = net.get(), after = (before & ~p.clear) | p.set;
    changed = changed || before != after;
    net.put(after);
  }
  if (changed) model->settle();
}

uint64_t Part::read(const RegisterPlace &place) const {
  if (mode_.model_current) return place.net.get();
  if (place.field != kNoField) return fields_[place.field];
  uint64_t value = 0;
  std::memcpy(&value, state_->registers() + place.at, static_cast<size_t>(place.net.bytes));
  for (const Slice &s : layout_.slices) {
    if (s.within == &place) value |= static_cast<uint64_t>(fields_[s.field]) << s.lsb;
  }
  return value;
}

void Part::forget() {
  load();
  state_ = nullptr;
}

}  // namespace mmcs
