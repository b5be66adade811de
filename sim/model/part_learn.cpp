// SPDX-License-Identifier: Apache-2.0
// See part.h: what the Verilated model of a part is evaluated for.

#include <algorithm>

#include "part.h"

namespace mmcs {

void Part::evaluate(bool clock) {
  if (clock) {
    model.clock();
  } else {
    model.put_inputs(fields_, now_.inputs);
  }
}

void Part::load() {
  if (!model_current_ && now_.state)
    model.write(now_.state->registers(), fields_, now_.state->inputs);
  model_current_ = true;
}

void Part::store() {
  uint8_t registers[kMostBytes] = {};
  uint32_t before[kMostFields];
  std::memcpy(before, fields_, sizeof before);
  now_.outputs = model.read(registers, fields_);
  const auto &fields = model.fields();
  for (size_t f = 0; f < fields.size(); ++f) {
    if (fields[f].output && fields_[f] != before[f]) now_.pending |= 1u << f;
  }
  model_current_ = true;
  now_.state = cache->make(registers, cache->counters(fields_), model.inputs(), now_.outputs);
}

// The state with these registers and the inputs and data fields as they are; is_case: its outputs
// may depend on the values of fields.
State *Part::state_of(const uint8_t *registers, bool is_case) {
  const uint64_t counters = cache->counters(fields_);
  State *known = is_case ? nullptr : cache->find(registers, counters, now_.inputs, nullptr);
  if (known) return known;
  model.write(registers, fields_, now_.inputs);
  uint8_t unused[kMostBytes];
  uint32_t fields[kMostFields];
  return cache->make(registers, counters, now_.inputs, model.read(unused, fields));
}

// Makes a step of the model with one set of patterns. valued: the fields that decide, by bit, which
// have their values; fixed: these, and others without a pattern. True: data decide.
bool Part::observe_step(int set, bool clock, uint32_t fixed, uint32_t valued, Observation *seen) {
  State *from = now_.state;
  const auto &fields = cache->fields();
  for (size_t f = 0; f < fields.size(); ++f) {
    if (!(fixed >> f & 1))
      fields_[f] = cache->pattern(set, f);
    else if (fields[f].input && !(valued >> f & 1))
      fields_[f] = fields[f].mask;
  }
  model.hold_fields(fields_);
  std::memcpy(seen->before, fields_, sizeof seen->before);
  std::memcpy(seen->after, fields_, sizeof seen->after);
  model.write(from->registers(), fields_, from->inputs);
  if (!clock) {  // data inputs had other values before
    uint32_t old[kMostFields];
    for (size_t f = 0; f < fields.size(); ++f) {
      const bool ones = fields[f].driven && !(from->inputs & fields[f].driven);
      old[f] = !fields[f].input || valued >> f & 1 ? fields_[f]
               : ones                              ? fields[f].mask
                                                   : ~cache->pattern(set, f) & fields[f].mask;
    }
    model.read_outputs(seen->data);
    model.write(from->registers(), old, from->inputs);
  }
  model.read_outputs(seen->before);
  const bool before = model.data_decide();
  evaluate(clock);
  return before || model.data_decide();
}

// A transition of the state, by its inputs or, where data decide, by the values of the fields.
Transition *Part::learn(bool clock, uint64_t key, bool is_case) {
  State *from = now_.state;
  uint32_t valued = 0;
  if (is_case) {
    for (size_t f : cache->deciding()) valued |= 1u << f;
  }
  const uint32_t fixed = cache->fixed(from->counters, now_.inputs) | valued;
  std::vector<Observation> seen(kPatterns);
  uint8_t registers[kMostBytes] = {}, others[kMostBytes] = {};
  uint64_t outputs = 0;
  bool same = true;  // of all sets: the key of the next state
  uint32_t actual[kMostFields];
  std::memcpy(actual, fields_, sizeof actual);
  for (int set = 0; set < kPatterns && same; ++set) {
    Observation &s = seen[static_cast<size_t>(set)];
    same = !observe_step(set, clock, fixed, valued, &s) || is_case;
    const uint64_t now = model.read(set ? others : registers, s.after);
    if (set) {
      same = same && now == outputs && !std::memcmp(registers, others, model.register_bytes());
    }
    outputs = now;
  }
  std::memcpy(fields_, actual, sizeof actual);
  model_current_ = false;
  Draft draft;
  const bool found = same && cache->derive(seen, fixed, clock, &draft);
  Transition *t = cache->add(found ? draft : Draft{}, key);
  t->is_case = is_case;
  if (!found) {
    t->decided = !is_case && !draft.computed && !cache->deciding().empty();
    return t;
  }
  const uint32_t pending = now_.pending;
  apply(*t);  // feedthroughs do not change the key
  t->to = state_of(registers, is_case);
  std::memcpy(fields_, actual, sizeof actual);
  now_.pending = pending;
  t->idle = t->idle && t->to == from;
  t->observed = ((t->to->outputs ^ from->outputs) & observed_) != 0;
  const uint32_t sampled = model.not_ignored(observed_fields_, from->outputs) |
                           model.not_ignored(observed_fields_, t->to->outputs);
  for (const Copy &c : draft.copies) t->observed = t->observed || sampled >> c.to & 1;
  return t;
}

Transition *Part::learn_from(State *state, uint64_t inputs, const uint32_t *fields, bool clock,
                             uint64_t key, bool is_case) {
  const Now now = now_;
  uint32_t own[kMostFields];
  std::memcpy(own, fields_, sizeof own);
  std::memcpy(fields_, fields, sizeof own);
  now_.state = state;
  now_.inputs = inputs;
  Transition *t = learn(clock, key, is_case);
  go_back(now, own);
  return t;
}

void Part::written(int64_t t) {
  model.registers_written();
  store();
  now_.last = t;
  now_.due = t + 1;
  now_.idle = false;
}

}  // namespace mmcs
