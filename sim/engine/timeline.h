// SPDX-License-Identifier: Apache-2.0
// Time travel: snapshots of a simulation, kept in memory or given out as bytes.
//
// A snapshot is everything that changes: RTL, plant, driver, motions, events, random numbers,
// running hashes. The past (log, notes, checkpoints) is not in it, only how long it was, so that a
// ring of snapshots stays small; history() gives the past out once for all of them. Snapshots are
// taken when no firmware is active: a native driver in the middle of a call is a C++ stack.
#pragma once

#include <string>
#include <vector>

#include "host.h"
#include "machine.h"
#include "mmcs_sim.h"
#include "vme_bus.h"

namespace mmcs {

class Timeline {
 public:
  // config_digest tells machines apart: same build, other robot or host settings.
  Timeline(Machine &machine, VmeBus &bus, Host &host, uint64_t config_digest)
      : machine_(machine), bus_(bus), host_(host), config_digest_(config_digest) {}

  // As Host::run_until, filling the ring on the way.
  bool run_until(int64_t clock);
  // A snapshot of now; its number, or -1 when an assertion has failed.
  int64_t take() { return add(false); }
  // Digest of all that decides the future: equal at the same clock, two runs are the same from
  // there on, whatever has happened before.
  uint64_t future();
  // Runs until the clock. The snapshot is of that instant, or, when the firmware is active then,
  // of the last instant before at which it was not.
  int64_t take_at(int64_t clock);
  // Goes back; later snapshots are forgotten, as their past will be another. False: no such one.
  bool restore(int64_t id);
  bool drop(int64_t id);
  // From now on a snapshot every so many clocks; the oldest of more than `count` go. 0: none.
  void ring(int64_t every_clks, int count);

  const std::vector<mmcs_snapshot> &list() const { return infos_; }
  int64_t deeds = 0;  // acts on the machine so far; a snapshot tells how many there had been
  // Header and state; nullptr: no such one. Valid until the next call.
  const Bytes *bytes(int64_t id);
  const Bytes *history();
  // "" or why these bytes cannot be restored here; then nothing has changed.
  std::string restore_bytes(const uint8_t *snapshot, size_t size, const uint8_t *past,
                            size_t past_size);

 private:
  template <class A>
  void state(A &a) {
    machine_.state(a);
    bus_.state(a);
    host_.state(a);
  }
  template <class A>
  void past(A &a) {
    machine_.history(a);
    host_.history(a);
  }
  int64_t add(bool of_ring);
  void forget(size_t place);
  size_t find(int64_t id) const;
  Bytes packed(const std::string &kind, const Bytes &content) const;

  Machine &machine_;
  VmeBus &bus_;
  Host &host_;
  uint64_t config_digest_;
  std::vector<mmcs_snapshot> infos_;  // in order of time and number
  std::vector<Bytes> states_;
  int64_t next_id_ = 0;
  int64_t ring_every_ = 0;
  int64_t ring_next_ = 0;
  int ring_count_ = 0;
  Bytes out_, history_out_;
};

// Which build this is: kind, cards and a digest of every source in it.
const char *build_id();
uint64_t config_digest(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links);

}  // namespace mmcs
