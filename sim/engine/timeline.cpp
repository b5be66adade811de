// SPDX-License-Identifier: Apache-2.0
// Time travel: see timeline.h.

#include "timeline.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

// Made by the Makefile, one per variant of the model.
extern "C" const char mmcs_build_id_text[];

namespace mmcs {
namespace {

const std::string kSnapshot = "MMCS snapshot ", kHistory = "MMCS history ";
// While waiting for an instant: earlier ones are too far from it to be the last idle one.
constexpr double kCandidateS = 0.02;

struct Header {
  char made_by[96];  // what it is, and the build
  uint64_t config, digest;
};

// The image that a real processor runs is part of the machine.
uint64_t file_digest(const char *name) {
  std::ifstream file(name, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  return digest(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size());
}

std::string check(const uint8_t *data, size_t size, const std::string &kind, uint64_t config) {
  Header h{};
  if (data && size >= sizeof h) std::memcpy(&h, data, sizeof h);
  h.made_by[sizeof h.made_by - 1] = 0;
  const std::string by = h.made_by;
  if (by.rfind(kind, 0) != 0) return "not a snapshot of MMCS, or cut short";
  if (by != kind + build_id()) {
    return "made by another build (" + by.substr(kind.size()) + ", this one is " + build_id() +
           "); run the scenario again to make it anew";
  }
  if (h.config != config)
    return "belongs to another machine: robot, host, its firmware or seed differ";
  return h.digest == digest(data + sizeof h, size - sizeof h) ? "" : "cut short or damaged";
}

}  // namespace

const char *build_id() {
  return mmcs_build_id_text;
}

// skip is left out: it changes how fast time passes, not what happens.
uint64_t config_digest(const mmcs_config &config, const mmcs_motor *motors,
                       const mmcs_link *links) {
  Hash hash;
  for (int32_t n : {config.cards, config.axes, config.links, config.amp_panic_cut}) {
    hash.add(static_cast<uint64_t>(n));
  }
  hash.add(config.seed);
  for (double g : config.gravity) hash.add(g);
  for (double x : {config.cpu_us_per_axis, config.latency_max_us, config.bus_timeout_us}) {
    hash.add(x);
  }
  if (config.host != MMCS_HOST_NATIVE) {
    hash.add(static_cast<uint64_t>(config.host));
    hash.add(static_cast<uint64_t>(config.wait_states));
    hash.add(static_cast<uint64_t>(config.instruction_cache));
    hash.add(file_digest(config.firmware));
  }
  if (*config.card) hash.add(file_digest(config.card));
  // Neither struct has padding.
  static_assert(sizeof(mmcs_motor) % 8 == 0 && sizeof(mmcs_link) % 8 == 0);
  const auto add = [&hash](const void *data, size_t count, size_t size) {
    hash.add(digest(static_cast<const uint8_t *>(data), count * size));
  };
  if (motors) add(motors, static_cast<size_t>(config.axes), sizeof *motors);
  if (links) add(links, static_cast<size_t>(config.links), sizeof *links);
  return hash.value();
}

// A clock that has passed runs nothing: a pending interrupt is served when time goes on.
bool Timeline::run_until(int64_t clock) {
  if (machine_.clock() >= clock) return !machine_.failed();
  if (ring_count_ == 0) return host_.run_until(clock);
  return host_.run_until(clock, [this] {
    if (machine_.clock() < ring_next_) return;
    add(true);
    ring_next_ = machine_.clock() + ring_every_;
  });
}

int64_t Timeline::add(bool of_ring) {
  if (machine_.failed()) return -1;
  Writer writer;
  state(writer);
  states_.push_back(writer.take());
  infos_.push_back({next_id_++, machine_.clock(), machine_.time(),
                    static_cast<int64_t>(states_.back().size()), host_.recorder().rows(), deeds,
                    !of_ring});
  const auto ringed = [](const mmcs_snapshot &info) { return !info.kept; };
  if (of_ring && std::count_if(infos_.begin(), infos_.end(), ringed) > ring_count_)
    drop(std::find_if(infos_.begin(), infos_.end(), ringed)->id);
  return next_id_ - 1;
}

uint64_t Timeline::future() {
  FutureWriter writer;
  state(writer);
  const Bytes bytes = writer.take();
  return digest(bytes.data(), bytes.size());
}

int64_t Timeline::take_at(int64_t clock) {
  int64_t last = -1;
  const int64_t near = clock - machine_.clocks(kCandidateS);
  const bool good = host_.run_until(clock, [&] {
    if (machine_.clock() < near) return;
    if (last >= 0) drop(last);
    last = take();
  });
  if (!good || (machine_.clock() != clock && last >= 0)) return last;
  if (last >= 0) drop(last);
  return take();
}

size_t Timeline::find(int64_t id) const {
  const auto at = std::find_if(infos_.begin(), infos_.end(),
                               [id](const mmcs_snapshot &info) { return info.id == id; });
  return static_cast<size_t>(at - infos_.begin());
}

void Timeline::forget(size_t place) {
  const auto n = static_cast<std::ptrdiff_t>(place);
  infos_.erase(infos_.begin() + n);
  states_.erase(states_.begin() + n);
}

bool Timeline::drop(int64_t id) {
  const size_t place = find(id);
  if (place == infos_.size()) return false;
  forget(place);
  return true;
}

void Timeline::ring(int64_t every_clks, int count) {
  ring_every_ = every_clks;
  ring_next_ = machine_.clock();
  ring_count_ = count;
}

bool Timeline::restore(int64_t id) {
  const size_t place = find(id);
  if (place == infos_.size()) return false;
  Reader reader(states_[place].data(), states_[place].size());
  state(reader);
  while (infos_.size() > place + 1) forget(place + 1);
  deeds = infos_[place].deeds;
  ring_next_ = machine_.clock() + ring_every_;
  return true;
}

Bytes Timeline::packed(const std::string &kind, const Bytes &content) const {
  Header h{{}, config_digest_, digest(content.data(), content.size())};
  std::snprintf(h.made_by, sizeof h.made_by, "%s", (kind + build_id()).c_str());
  Writer writer;
  writer.raw(&h, sizeof h);
  writer.raw(content.data(), content.size());
  return writer.take();
}

const Bytes *Timeline::bytes(int64_t id) {
  const size_t place = find(id);
  if (place == infos_.size()) return nullptr;
  out_ = packed(kSnapshot, states_[place]);
  return &out_;
}

const Bytes *Timeline::history() {
  Writer writer;
  past(writer);
  history_out_ = packed(kHistory, writer.take());
  return &history_out_;
}

std::string Timeline::restore_bytes(const uint8_t *snapshot, size_t size, const uint8_t *past_data,
                                    size_t past_size) {
  std::string why = check(snapshot, size, kSnapshot, config_digest_);
  if (why.empty()) why = check(past_data, past_size, kHistory, config_digest_);
  if (!why.empty()) return why;
  Writer own_past, own;
  past(own_past);
  state(own);
  try {
    Reader before(past_data + sizeof(Header), past_size - sizeof(Header));
    past(before);
    Reader now(snapshot + sizeof(Header), size - sizeof(Header));
    state(now);
  } catch (...) {  // nothing has happened
    const Bytes kept_past = own_past.take(), kept = own.take();
    Reader before(kept_past.data(), kept_past.size()), now(kept.data(), kept.size());
    past(before);
    state(now);
    throw;
  }
  infos_.clear();
  states_.clear();
  ring_next_ = machine_.clock() + ring_every_;
  return "";
}

}  // namespace mmcs
