// SPDX-License-Identifier: Apache-2.0
// See part.h.

#include "part.h"

#include <algorithm>
#include <stdexcept>

namespace mmcs {
namespace {

constexpr int kLongest = 64;  // clocks that are put off, unless it rests then

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
           std::shared_ptr<Cache> *known, VerilatedContext &context)
    : model(std::move(m)) {
  if (const Net clk = model->port("clk_i")) clk.put(1);
  const PartRow &own = table.parts[n];
  const std::string scope = model->name() + "." + own.module;
  std::vector<Cell> cells;
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
      decides_.emplace_back(find(row.path, row.name), row.level);
    }
  }
  places_by_row_.resize(table.registers.size());
  for (size_t r = 0; r < table.registers.size(); ++r) {
    const RegisterRow &row = table.registers[r];
    if (static_cast<size_t>(row.part) != n) continue;
    Place place{find(row.path, row.name), -1, 0};
    place.net.width = row.width;
    if (row.kind == Kind::kControl) {
      place.at = static_cast<int>(register_bytes_);
      register_bytes_ += static_cast<size_t>(place.net.bytes);
    } else {
      place.cell = static_cast<int>(cells.size());
      const bool counter = row.kind == Kind::kCounter;
      cells.push_back({mask_of(row.width), counter ? row.margin : -1, counter, false, false,
                       row.kind == Kind::kDecides, 0});
      cell_ports_.push_back(nullptr);
    }
    places_.push_back(std::make_unique<Place>(place));
    places_by_row_[r] = places_.back().get();
  }
  for (const SliceRow &row : table.slices) {
    const Place *place = places_by_row_[static_cast<size_t>(row.reg)];
    if (!place) continue;
    slices_.push_back({static_cast<int>(cells.size()), row.lsb, place});
    cells.push_back({mask_of(row.width), -1, false, false, false, row.kind == Kind::kDecides, 0});
    cell_ports_.push_back(nullptr);
  }
  if (register_bytes_ > kMostBytes) throw std::logic_error("a part with too many registers");
  int ins = 0;
  for (const PortRow &row : own.ports) {
    auto port = std::make_unique<PartPort>();
    port->row = &row;
    port->net =
        *row.path ? find_net(context, scope + "." + row.path, row.name) : model->port(row.name);
    if (!port->net) throw std::runtime_error(scope + " has no port " + row.name);
    port->net.width = 8 * port->net.bytes;
    port->width = row.width;
    port->out = row.out;
    port->data = row.kind != Kind::kControl;
    port->whole = std::none_of(own.ports.begin(), own.ports.end(), [&row](const PortRow &r) {
      return &r != &row && std::strcmp(r.name, row.name) == 0 && std::strcmp(r.path, row.path) == 0;
    });
    if (port->data) {
      port->at = static_cast<int>(cells.size());
      cells.push_back(
          {mask_of(row.width), -1, false, !row.out, row.out, row.kind == Kind::kDecides, 0});
      cell_ports_.push_back(port.get());
    } else {
      port->at = row.out ? static_cast<int>(out_ports_.size()) : ins;
      port->mask = bits(row.width, port->at);
      if (row.out) {
        out_ports_.insert(out_ports_.end(), static_cast<size_t>(row.width), port.get());
      } else {
        ins += row.width;
      }
    }
    ports_.push_back(std::move(port));
  }
  for (const auto &port : ports_) {
    if (port->row->driven < 0) continue;
    const PartPort &tells = *ports_[static_cast<size_t>(port->row->driven)];
    cells[static_cast<size_t>(port->at)].driven = tells.mask;
  }
  if (!*known) *known = std::make_shared<Cache>(cells, register_bytes_);
  cache = free_ = *known;
  put_inputs(cells_, 0);
}

void Part::wired() {
  seen_out_ = line_mask;
  for (const auto &port : ports_) {
    if (!port->out || (!port->wire && port->links.empty())) continue;
    if (port->data) {
      seen_cells_ |= 1u << port->at;
    } else {
      seen_out_ |= port->mask;
    }
  }
  shown_out_ |= seen_out_;
  shown_cells_ |= seen_cells_;
}

// --- with the cache --------------------------------------------------------------------------

// Counters have come to their margin, or have left it.
void Part::near(const Transition &t) {
  const uint64_t near = cache->near(cells_);
  if (near == state_->near) return;
  Transition &known = const_cast<Transition &>(t);
  if (!known.other || known.other->near != near)
    known.other = state_of(state_->registers(), t.is_case);
  state_ = known.other;
}

// A step that is not learned yet, that data decide, or that the model is asked about, too.
void Part::ask(Transition **at, bool clock) {
  bool known = *at;
  if (!known) *at = learn(clock, in_, false);
  if ((*at)->decided) {
    const uint64_t values = cache->values(cells_);
    at = &(*at)->cases;
    while (*at && (*at)->in != values) at = &(*at)->next;
    known = *at;
    if (!known) *at = learn(clock, values, true);
  }
  Transition *t = *at;
  if (!t->to) {
    ++misses;
    run(clock);
    return;
  }
  ++(known ? hits : misses);
  if (check && ++asked_ % static_cast<unsigned>(check) == 0) {
    load();
    op(clock);
    uint8_t registers[kMostBytes] = {};
    uint32_t cells[kMostCells] = {};
    const uint64_t out = look(registers, cells);
    perform(*t);
    bool same = out == out_ && !std::memcmp(registers, state_->registers(), register_bytes_);
    for (size_t c = 0; c < cache->cells().size(); ++c) {
      same = same && (cache->cells()[c].in || cells[c] == cells_[c]);
    }
    if (!same) throw std::logic_error(model->name() + ": the cache differs from the model");
    return;
  }
  perform(*t);
}

// The cache does not know its state.
bool Part::follow_slowly(int64_t t) {
  catch_up(t);
  if (cached_) {
    store();
    return follow(last_);
  }
  op(false);
  data_ = 0;
  store();
  plan();
  return true;
}

void Part::clock_slowly() {
  if (cached_) {
    store();
    step(&state_->clock, true);
  } else {
    op(true);
    store();
  }
  plan();
}

void Part::slow_clock(int64_t t) {
  for (uint64_t level = 0; level < 2; ++level) {
    if (const Net clk = model->port("clk_i")) clk.put(level);
    model->eval();
  }
  poke();
  store();
  last_ = t;
  plan();
}

void Part::catch_up_slowly(int64_t t) {
  while (last_ < t) {
    const Transition *ahead = state_ ? state_->ahead : nullptr;
    const Transition *next = state_ ? state_->clock : nullptr;
    if (ahead && state_->quiet <= t - last_) {
      hits += static_cast<uint64_t>(state_->quiet);
      last_ += state_->quiet;
      perform(*ahead);
    } else if (!next || !next->to) {  // the model's own clock is none that is put off
      last_ = t;
    } else if (next->rests && holds(*next)) {
      count(*next, t - last_);
      last_ = t;
    } else {
      perform(*next);
      ++hits;
      ++last_;
    }
  }
}

// A clock leaves the cells as they are, but for what counts.
bool Part::holds(const Transition &t) const {
  for (const Copy &c : t.copies()) {
    if (c.apply(cells_[c.to], cells_[c.from]) != cells_[c.to]) return false;
  }
  return true;
}

// When it is due by its cells, or for the first time.
void Part::plan_slowly() {
  const Transition *t = state_->clock;
  if (!t) return;
  if (t->rests && (t->near || t->copy_count != 0)) {
    state_->rests = t->copy_count == 0;
    rests_ = holds(*t);
    if (rests_) due_ = t->near ? room(*t) : kNever;
    return;
  }
  look_ahead(state_);
  if (state_->quiet >= 0) plan();
}

// How many clocks of a state tell nothing, if all of them are known.
void Part::look_ahead(State *s) {
  std::vector<const Transition *> clocks;
  const Transition *t = s->clock;
  for (;; t = t->to->clock) {
    if (!t) return;
    if (clocks.size() == kLongest || !t->to || t->near || t->tells) break;
    if (t->rests) {
      if (t->count_count != 0 && !clocks.empty()) break;
      s->ends = t->copy_count == 0;
      break;
    }
    clocks.push_back(t);
  }
  s->quiet = static_cast<int16_t>(clocks.size());
  s->rests = s->ends && clocks.empty();
  s->still = s->rests && s->clock->count_count == 0;
  if (clocks.size() > 1) s->ahead = join(s, clocks);
  if (clocks.empty() || s->ends || !t->to || t->near) return;
  clocks.push_back(t);
  s->told = join(s, clocks);
}

// Transitions one after the other as one, by the marks that they carry on; null: what one has
// counted, another copies.
Transition *Part::join(const State *from, const std::vector<const Transition *> &clocks) {
  const auto &cells = cache->cells();
  const uint32_t fixed = cache->fixed(from->near, from->in), moved = moved_;
  uint32_t actual[kMostCells];
  std::memcpy(actual, cells_, sizeof actual);
  std::vector<Cache::Seen> seen(kMarks);
  for (int set = 0; set < kMarks; ++set) {
    for (size_t c = 0; c < cells.size(); ++c) {
      if (cells[c].out) {
        cells_[c] = set & 1 ? cells[c].mask : 0;
      } else if (!(fixed >> c & 1)) {
        cells_[c] = cache->mark(set, c);
      } else if (cells[c].in) {
        cells_[c] = cells[c].mask;
      }
    }
    Cache::Seen &s = seen[static_cast<size_t>(set)];
    std::memcpy(s.before, cells_, sizeof s.before);
    for (const Transition *t : clocks) apply(*t);
    std::memcpy(s.after, cells_, sizeof s.after);
    std::memcpy(cells_, actual, sizeof actual);
  }
  moved_ = moved;
  Draft draft;
  if (!cache->explain(seen, fixed, true, &draft) || draft.near) return nullptr;
  draft.rests = false;
  return cache->add(draft, from->in, clocks.back()->to);
}

// The edge at which a part at rest has a counter at its margin.
int64_t Part::room(const Transition &t) const {
  int64_t room = kNever;
  for (const Count &c : t.counts()) {
    if (c.margin < 0) continue;
    const uint32_t down = (0 - c.by) & c.mask, now = cells_[c.cell];
    int64_t left = int64_t{now} - c.margin - 1;
    if (down > c.mask / 2 + 1)
      left = (int64_t{c.mask} - now) / c.by;
    else if (down != 1)
      left /= down;
    room = std::min(room, left);
  }
  return room == kNever ? kNever : last_ + room + 1;
}

}  // namespace mmcs
