// SPDX-License-Identifier: Apache-2.0
// Time: see machine.h.

#include "machine.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace mmcs {
namespace {

constexpr size_t kMaxNotes = 10000;
// The charge pump holds the brakes open for so many steps after an edge of the sign of life: 10 ms.
constexpr int64_t kPumpSteps = 10000 / kStepUs;

// Volts to the 16-bit units of the pins, 32768 = 10 V.
int16_t to_pin(double volts) {
  const double units = volts * 3276.8;
  if (!(units < 32767.0)) return 32767;  // no number, either
  if (units <= -32768.0) return -32768;
  return static_cast<int16_t>(units < 0 ? units - 0.5 : units + 0.5);
}

}  // namespace

Machine::Machine(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links)
    : config_(config), axes_(config.axes), tap_(config.cards) {
  clks_per_step_ = static_cast<int>(int64_t{Model::clk_hz()} * kStepUs / 1000000);
  // Two clocks between edges of one axis: the counter's 4 million counts a second at 8 MHz.
  plant_ = Plant::create(config, motors, links, clks_per_step_, Model::clk_hz() / 4000000);
  model_ = Model::create(config.skip != 0, config.seed, config.card);
  lines_ = model_->lines();
  tap_.lines(0, lines_);
  drive_.resize(static_cast<size_t>(axes_));
  write_flips_.resize(2 * static_cast<size_t>(config.cards));
  step_angles_.resize(static_cast<size_t>(axes_));
  sample_angles_.resize(static_cast<size_t>(axes_));
  for (int axis = 0; axis < axes_; ++axis) {
    const unsigned pins = plant_->pins(axis);
    model_->pins().set_encoder(axis, pins);
    sample_angles_[static_cast<size_t>(axis)] = plant_->angle(axis);
  }
}

int64_t Machine::clocks(double seconds) {
  const double exact = seconds * Model::clk_hz();
  const int64_t whole = static_cast<int64_t>(exact);
  // A time given in decimals may sit a hair above the clock that it means.
  return exact - static_cast<double>(whole) > 1e-6 ? whole + 1 : whole;
}

// Of an upset "seu.<register>", its register; else -1.
static int register_of(int input) {
  const int reg = input - kInputCount;
  return reg < 0 || reg >= static_cast<int>(registers().size()) ? -1 : reg;
}

// Of an upset of an own card, whose registers have the numbers behind these; else -1.
int Machine::card_register_of(int input) const {
  const int reg = input - kInputCount - static_cast<int>(registers().size());
  const OwnCard *card = model_->own_card();
  return reg < 0 || !card || reg >= static_cast<int>(card->size()) ? -1 : reg;
}

const char *Machine::input_name(int input) {
  static const std::vector<std::string> upsets = [] {
    std::vector<std::string> names;
    for (const Register &r : registers()) names.push_back("seu." + r.name);
    return names;
  }();
  if (input < 0) return nullptr;
  if (input < kInputCount) return kInputs[input].about.name;
  const int reg = register_of(input);
  return reg >= 0 ? upsets[static_cast<size_t>(reg)].c_str() : nullptr;
}

// The register that an upset of this name hits.
static std::string upset_path(const Input &input, int index) {
  return (input.about.scope == MMCS_SCOPE_AXIS ? axis_path(index) + "." : "") + input.reg;
}

// One step of physics: the drive of this instant acts for the whole step, whose edges are then
// played back clock by clock.
void Machine::plant_step() {
  uint32_t volts = 0;
  for (int axis = 0; axis < axes_; ++axis) {
    step_angles_[static_cast<size_t>(axis)] = plant_->angle(axis);
    const int16_t drive = model_->drive(axis);
    drive_[static_cast<size_t>(axis)] = drive * (10.0 / 32768.0);
    trail_.add(static_cast<uint64_t>(static_cast<uint16_t>(drive)));
    volts |= uint32_t{static_cast<uint16_t>(to_pin(plant_->adc_volts(axis)))} << 16 * (axis & 1);
    if (axis & 1 || axis + 1 == axes_) {
      model_->pins().set_volts(axis / 2, volts);
      volts = 0;
    }
  }
  const unsigned lines = model_->lines();
  const bool amp_enable = !(config_.amp_panic_cut && (lines & kLinePanic));
  if (tap_.on()) tap_.lights(time(), *model_);
  pump_ = model_->alive() != (alive_ != 0) ? kPumpSteps : std::max<int64_t>(pump_ - 1, 0);
  alive_ = model_->alive();
  const bool release = (lines & kLineBrakeRelease) != 0 && pump_ > 0;
  plant_->step(drive_.data(), release, amp_enable, edges_);
  next_edge_ = 0;
  step_start_ = next_step_;
  next_step_ += clks_per_step_;
  expect_edges();
}

void Machine::expect_edges() {
  coming_.clear();
  for (size_t n = next_edge_; n < edges_.size(); ++n) {
    const PinEdge &e = edges_[n];
    coming_.push_back(
        {step_start_ + e.clk, e.axis, static_cast<unsigned>(e.a | e.b << 1 | e.i << 2)});
  }
  expected_ = model_->expect(coming_);
}

bool Machine::trace(const std::string &path, double from_s, double to_s) {
  trace_path_ = path;
  trace_at_ = clocks(from_s);
  trace_end_ = clocks(to_s);
  due_ = clock_;
  return clock_ < trace_at_ || trace_due();
}

bool Machine::trace_due() {
  const bool begins = clock_ < trace_end_;
  const bool good = model_->trace(begins ? trace_path_ : "") || !begins;
  if (!good) note("log", -1, "the trace file cannot be made");
  trace_at_ = begins ? trace_end_ : INT64_MAX;
  return good;
}

void Machine::apply_due() {
  if (clock_ >= trace_at_) trace_due();
  while (next_event_ < events_.size() && clocks(events_[next_event_].t) <= clock_) {
    apply(events_[next_event_++]);
  }
  if (clock_ >= next_step_) plant_step();
  while (!expected_ && next_edge_ < edges_.size() &&
         step_start_ + edges_[next_edge_].clk <= clock_) {
    const PinEdge &edge = edges_[next_edge_++];
    model_->pins().set_encoder(edge.axis, edge.a | edge.b << 1u | edge.i << 2u);
  }
}

int64_t Machine::next_due() const {
  int64_t stop = std::min(next_step_, trace_at_);
  if (!expected_ && next_edge_ < edges_.size())
    stop = std::min(stop, step_start_ + edges_[next_edge_].clk);
  if (next_event_ < events_.size()) stop = std::min(stop, clocks(events_[next_event_].t));
  return stop;
}

bool Machine::advance(int64_t n, Watch watch) {
  const int64_t limit = clock_ + n;
  const int dtack = watch == Watch::kDtackLow ? 0 : watch == Watch::kDtackHigh ? 1 : -1;
  while (clock_ < limit && !failed()) {
    if (clock_ >= due_) {
      apply_due();
      due_ = next_due();
    }
    int64_t ran = 0;
    const Stop stop = model_->run(std::min(limit, due_) - clock_, dtack, &ran);
    clock_ += ran;
    look_for_failure();
    bool irq_changed = false;
    if (stop == Stop::kLines) {
      irq_changed = ((model_->lines() ^ lines_) & kLineIrq) != 0;
      lines_changed();
    }
    if (dtack >= 0 && model_->dtack() == (dtack == 0)) return true;
    if (irq_changed && watch == Watch::kIrq) return true;
  }
  return false;
}

bool Machine::bus_cycle(Model::BusRequest request, Model::BusReply *reply) {
  if (clock_ >= due_ || failed() || bus_errors_ != 0) return false;
  request.due = due_;
  if (!model_->bus_cycle(request, reply)) return false;
  clock_ = reply->end;
  look_for_failure();
  return true;
}

void Machine::look_for_failure() {
  if (failed()) note("assert", -1, model_->failure());
  if (!model_->was_upset()) return;
  const std::string doubt = model_->take_doubt();
  if (!doubt.empty()) note("assert", -1, "after an upset: " + doubt);
}

void Machine::lines_changed() {
  const unsigned now = model_->lines();
  const unsigned changed = now ^ lines_;
  lines_ = now;
  trail_.add((static_cast<uint64_t>(clock_) << 16) ^ now);
  tap_.lines(time(), now);
  if (changed & kLinePanic) {
    note("panic", -1, now & kLinePanic ? "PANIC line goes high" : "PANIC line goes low");
  }
  if (changed & now & kLineSclock) {
    sample_clock_ = clock_;
    // The plant is at the end of the step whose edges are being played back.
    const double done = static_cast<double>(clock_ - step_start_) / clks_per_step_;
    for (int axis = 0; axis < axes_; ++axis) {
      const double from = step_angles_[static_cast<size_t>(axis)];
      sample_angles_[static_cast<size_t>(axis)] = from + (plant_->angle(axis) - from) * done;
    }
  }
}

std::string Machine::check_event(const mmcs_event &event) const {
  if (event.input < 0) return "no such input";
  if (!std::isfinite(event.value)) return "its value is not a number";
  if (event.input >= kInputCount) {
    const int reg = register_of(event.input), of_card = card_register_of(event.input);
    if (reg < 0 && of_card < 0) return "no such input";
    const double limit =
        std::ldexp(1.0, of_card < 0 ? registers()[static_cast<size_t>(reg)].width
                                    : model_->own_card()->width(static_cast<size_t>(of_card)));
    return event.value >= 0 && event.value < limit ? "" : "value out of range";
  }
  const Input &input = kInputs[event.input];
  const bool plant = input.action == Action::kPlant;  // whose index -1 is all axes
  const int limit = plant                                  ? axes_
                    : input.about.scope == MMCS_SCOPE_AXIS ? 2 * config_.cards
                    : input.about.scope == MMCS_SCOPE_CARD ? config_.cards
                                                           : 1;
  if (event.index < (plant ? -1 : 0) || event.index >= limit) return "no such axis or card";
  const bool of_mark1 = input.about.scope != MMCS_SCOPE_MACHINE &&
                        (input.action == Action::kUpset || input.action == Action::kPin) &&
                        input.number != static_cast<int>(Pin::kAxisEnable);
  const int slot = input.about.scope == MMCS_SCOPE_AXIS ? event.index / 2 : event.index;
  if (of_mark1 && model_->own_card() && model_->own_card()->stands_in(slot))
    return "an own card is in that slot, not a Mark I";
  if (event.value < input.about.low || event.value > input.about.high) return "value out of range";
  if (input.native() && config_.host != MMCS_HOST_NATIVE) {
    return "a real processor has no such input";
  }
  if (input.action == Action::kUpset) return model_->cannot(Pin::kCount);
  if (input.action != Action::kPin) return "";
  const auto pin = static_cast<Pin>(input.number);
  return model_->cannot(pin);
}

void Machine::add_event(const mmcs_event &event) {
  // After all events of the same time, so that they happen in the order given.
  const auto at =
      std::upper_bound(events_.begin() + static_cast<std::ptrdiff_t>(next_event_), events_.end(),
                       event, [](const mmcs_event &a, const mmcs_event &b) { return a.t < b.t; });
  events_.insert(at, event);
  due_ = clock_;
}

double Machine::input_value(int input, int index, double t) const {
  const mmcs_input &about = kInputs[input].about;
  for (auto event = events_.rbegin(); about.lasting && event != events_.rend(); ++event) {
    const bool here = event->index == index || event->index == -1;
    if (event->input == input && here && event->t <= t) return event->value;
  }
  return about.healthy;
}

void Machine::apply(const mmcs_event &event) {
  char text[100];
  const int of_card = card_register_of(event.input);
  const std::string name =
      of_card < 0 ? input_name(event.input) : "seu." + model_->own_card()->name(of_card);
  std::snprintf(text, sizeof text, "%s[%d] = %g", name.c_str(), event.index, event.value);
  const bool table = event.input >= 0 && event.input < kInputCount;
  const bool axis = !table || kInputs[event.input].about.scope == MMCS_SCOPE_AXIS;
  note("fault", axis && of_card < 0 ? event.index : -1, text);
  if (of_card >= 0) return model_->upset_card(of_card, static_cast<uint64_t>(event.value));
  if (!table) {
    model_->upset(register_of(event.input), static_cast<uint64_t>(event.value));
    return;
  }
  const Input &input = kInputs[event.input];
  const unsigned value = static_cast<unsigned>(event.value);
  switch (input.action) {
    case Action::kPin:
      model_->pins().set(static_cast<Pin>(input.number), event.index, value);
      break;
    case Action::kPlant:
      plant_->set_input(input.number, event.index, event.value);
      break;
    case Action::kStall:
      stalled_until_ = clock_ + clocks(event.value * 1e-3);
      break;
    case Action::kBusError:
      bus_errors_ = value;
      break;
    case Action::kHostDead:
      host_dead_ = host_dead_ || value != 0;
      break;
    case Action::kWritesLost:
      writes_lost_ = value;
      break;
    case Action::kWriteFlip:
      write_flips_[static_cast<size_t>(event.index)] = value;
      break;
    case Action::kUpset:
      model_->upset(find_register(upset_path(input, event.index)), value);
      break;
  }
}

void Machine::note(const char *kind, int axis, const std::string &text) {
  // The tap tells of PANIC and errors by itself, with their values.
  const std::string name = kind;
  if (name != "panic" && name != "error") tap_.event(time(), kind, axis, 0, text);
  if (notes_.size() >= kMaxNotes) {
    ++notes_lost_;
    return;
  }
  mmcs_note note{};
  note.t = time();
  note.axis = axis;
  std::snprintf(note.kind, sizeof note.kind, "%s", kind);
  std::snprintf(note.text, sizeof note.text, "%s", text.c_str());
  notes_.push_back(note);
}

}  // namespace mmcs
