// SPDX-License-Identifier: Apache-2.0
// See part.h.

#include "part.h"

#include <algorithm>
#include <stdexcept>

namespace mmcs {

// Clocks that are postponed at once, unless the part is idle then.
static constexpr int kLongest = 64;

Part::Part(const BoardTable &table, size_t n, std::unique_ptr<Board> board,
           std::shared_ptr<Cache> *known, VerilatedContext &context, uint32_t *fields)
    : model(table, n, std::move(board), context), fields_(fields) {
  if (!*known) *known = std::make_shared<Cache>(model.fields(), model.register_bytes());
  cache = *known;
}

void Part::choose_cache(const std::shared_ptr<Cache> &of_module) {
  cache =
      model.faulty() ? std::make_shared<Cache>(model.fields(), model.register_bytes()) : of_module;
}

// --- with the cache --------------------------------------------------------------------------

// Counters may have come to their margin, or have left it: then the state is another one.
void Part::enter_margin(const Transition &t) {
  const uint64_t counters = cache->counters(fields_);
  if (counters == now_.state->counters) return;
  Transition &known = const_cast<Transition &>(t);
  if (!known.at_margin || known.at_margin->counters != counters)
    known.at_margin = state_of(now_.state->registers(), t.is_case);
  now_.state = known.at_margin;
}

// A step that is not learned yet, that data decide, or that is compared with the model.
void Part::step_slowly(Transition **at, bool clock) {
  bool known = *at;
  if (!known) *at = learn(clock, now_.inputs, false);
  if ((*at)->decided) {
    const uint64_t values = cache->values(fields_);
    at = &(*at)->cases;
    while (*at && (*at)->key != values) at = &(*at)->next;
    known = *at;
    if (!known) *at = learn(clock, values, true);
  }
  Transition *t = *at;
  if (!t->to) {
    ++now_.misses;
    load();
    evaluate(clock);
    return store();
  }
  ++(known ? now_.hits : now_.misses);
  if (check && (now_.hits + now_.misses) % static_cast<unsigned>(check) == 0)
    return compare_with_model(*t, clock);
  perform(*t);
}

// Makes a step of the cache and of the model.
void Part::compare_with_model(const Transition &t, bool clock) {
  load();
  evaluate(clock);
  uint8_t registers[kMostBytes] = {};
  uint32_t fields[kMostFields] = {};
  const uint64_t outputs = model.read(registers, fields);
  perform(t);
  bool same = outputs == now_.outputs &&
              !std::memcmp(registers, now_.state->registers(), model.register_bytes());
  for (size_t f = 0; f < model.fields().size(); ++f)
    same = same && (model.fields()[f].input || fields[f] == fields_[f]);
  if (!same) throw std::logic_error(model.board->name() + ": the cache differs from the model");
}

void Part::catch_up_slowly(int64_t t) {
  while (now_.last < t) {
    const Transition *next = now_.state->on_clock;
    if (!next || !next->to) {  // a clock that the model computes is not postponed
      now_.last = t;
    } else if (next->idle && changes_nothing(*next)) {
      count(*next, t - now_.last);
      now_.last = t;
    } else {
      perform(*next);
      ++now_.hits;
      ++now_.last;
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
  const Transition *t = now_.state->on_clock;
  if (!t) return;
  if (t->idle && (t->near_margin || t->copy_count != 0)) {
    now_.state->idle = t->copy_count == 0;
    now_.idle = changes_nothing(*t);
    if (now_.idle) now_.due = t->near_margin ? margin_edge(*t) : kNever;
    return;
  }
  look_ahead(now_.state);
  if (now_.state->silent_clocks >= 0) plan();
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
  return clocks == kNever ? kNever : now_.last + clocks + 1;
}

// --- for cycles as one step --------------------------------------------------------------------

void Part::go_back(const Now &now, const uint32_t *fields) {
  now_ = now;
  std::memcpy(fields_, fields, kMostFields * sizeof *fields_);
  model_current_ = false;
}

void Part::go_to(State *state, uint32_t pending, int64_t t, size_t transitions) {
  now_.hits += transitions;
  now_.state = state;
  now_.inputs = state->inputs;
  now_.outputs = now_.taken = state->outputs;
  now_.pending = pending;
  now_.last = t;
  model_current_ = false;
  plan();
}

}  // namespace mmcs
