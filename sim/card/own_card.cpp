// SPDX-License-Identifier: Apache-2.0
// See own_card.h.

#include "own_card.h"

#include <dlfcn.h>

#include <stdexcept>

namespace mmcs {

OwnCard::OwnCard(const std::string &library) {
  library_ = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library_) throw std::runtime_error("no card at " + library + "; run the scenario again");
  const auto create =
      reinterpret_cast<decltype(&mmcs_card_create)>(dlsym(library_, "mmcs_card_create"));
  destroy_ = reinterpret_cast<decltype(&mmcs_card_destroy)>(dlsym(library_, "mmcs_card_destroy"));
  if (!create || !destroy_) throw std::runtime_error(library + " is no card");
  model_ = create();
  if (!model_) throw std::runtime_error(library + ": a register of the card is not in its model");
  for (const char *name : kInputs) inputs_.push_back(model_->board->port(name));
  for (const char *name : kOutputs) outputs_.push_back(model_->board->port(name));
  for (int port = 0; port < kPorts; ++port) joints_[port] = model_->board->port(kPortNames[port]);
  for (Port encoder : {kEncA, kEncB, kEncI}) inputs_.push_back(joints_[encoder]);
  drive_ = model_->board->port("drive_v_o");
  slots_ = model_->board->port("slots_o");
  clashes_ = model_->board->port("clash_o");
  for (const char *idle : {"pcx_ior_no", "pcx_iow_no"}) model_->board->port(idle).put(1);
  model_->board->eval();
  send();
  for (const auto &[name, net] : model_->registers) {
    const size_t bytes = static_cast<size_t>(net.bytes);
    known_.resize(known_.size() + bytes);
    if (!memory_.empty() && memory_.back().first + memory_.back().second == net.at)
      memory_.back().second += bytes;
    else
      memory_.emplace_back(net.at, bytes);
  }
}

OwnCard::~OwnCard() {
  if (model_) destroy_(model_);
  if (library_) dlclose(library_);
}

void OwnCard::put(size_t input, uint64_t value) {
  const Net &net = inputs_[input];
  if (!net || net.get() == value) return;
  net.put(value);
  changed_ = true;
}

bool OwnCard::take(Port port, int lsb, uint64_t value) {
  if (!has(port, lsb)) return false;
  joints_[port].put(lsb, kPortFields[port], value);
  changed_ = true;
  return true;
}

bool OwnCard::follow() {
  if (!changed_) return false;
  changed_ = looked_ = false;
  active_ = true;
  model_->board->inputs();
  return send();
}

// A card that has been active for long is looked at in two clocks of so many.
bool OwnCard::clock() {
  constexpr unsigned kLong = 64;
  model_->board->clock();
  const bool look = busy_ < kLong || busy_ % kLong >= kLong - 2;
  active_ = !look || registers_changed() || !looked_;
  looked_ = look;
  busy_ = active_ ? busy_ + 1 : 0;
  return active_ && send();
}

void OwnCard::upset(size_t reg, uint64_t bits) {
  const Net &net = model_->registers[reg].second;
  net.put(net.get() ^ bits);
  model_->board->settle();
  changed_ = true;
}

void OwnCard::restore(const std::vector<uint64_t> &values) {
  for (size_t reg = 0; reg < values.size(); ++reg) model_->registers[reg].second.put(values[reg]);
  model_->board->settle();
  model_->board->inputs();
  changed_ = true;
  send();
}

void OwnCard::copy_registers(std::vector<char> *to) const {
  to->clear();
  for (const auto &[at, count] : memory_) to->insert(to->end(), at, at + count);
}

void OwnCard::mark() {
  copy_registers(&marked_);
  marked_inputs_.clear();
  for (const Net &input : inputs_) marked_inputs_.push_back(input ? input.get() : 0);
}

void OwnCard::go_back() {
  for (size_t n = 0; n < inputs_.size(); ++n) {
    if (inputs_[n]) inputs_[n].put(marked_inputs_[n]);
  }
  for (int round = 0; round < 2; ++round) {  // resets among them follow
    const char *from = marked_.data();
    for (const auto &[at, count] : memory_) {
      std::memcpy(at, from, count);
      from += count;
    }
    model_->board->settle();
    model_->board->inputs();
  }
  send();
  changed_ = looked_ = false;
  active_ = true;
}

// Whether a register has changed since this was asked last.
bool OwnCard::registers_changed() {
  bool any = false;
  char *known = known_.data();
  for (const auto &[at, bytes] : memory_) {
    if (std::memcmp(known, at, bytes) != 0) {
      std::memcpy(known, at, bytes);
      any = true;
    }
    known += bytes;
  }
  return any;
}

// Takes the outputs; true if any has changed.
bool OwnCard::send() {
  bool any = false;
  for (size_t n = 0; n < kMostOutputs; ++n) {
    const uint64_t now = outputs_[n].get();
    any = any || now != sent_[n];
    sent_[n] = now;
  }
  if (any && clashes_.get()) {
    const uint64_t slot = inputs_[kAddress].get() >> 10 & 15;
    clash_ = "two cards answer a read at the addresses of slot " + std::to_string(slot);
  }
  return any;
}

}  // namespace mmcs
