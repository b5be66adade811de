// SPDX-License-Identifier: Apache-2.0
// Coverage-guided fuzzing of what a file of snapshots brings to the engine: bytes that are refused
// with a sentence, or restored into a machine that goes on.
//
// Input: what it is (0 a state, 1 a past, 2 and 3 the same as they stand, header included), then
// the bytes. A state and a past get a header that says they are whole: a digest is no signature.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "archive.h"
#include "hash.h"
#include "mcdef.h"
#include "mmcs_sim.h"

namespace {

using mmcs::Bytes;

constexpr size_t kHeader = 104, kSize = 88, kDigest = 96;
constexpr double kOn = 0.0002;  // s that an accepted state goes on

mmcs_sim *sim;
Bytes good[2];  // a state and its past, as files hold them
bool goes_on;

Bytes with_header(const Bytes &like, const uint8_t *content, size_t size) {
  Bytes out(like.begin(), like.begin() + kHeader);
  const uint64_t length = size, sum = mmcs::digest(content, size);
  std::memcpy(out.data() + kSize, &length, 8);
  std::memcpy(out.data() + kDigest, &sum, 8);
  out.insert(out.end(), content, content + size);
  return out;
}

bool restore(const Bytes &state, const Bytes &past) {
  char why[200] = "";
  const int result = mmcs_sim_restore_bytes(sim, state.data(), state.size(), past.data(),
                                            past.size(), why, sizeof why);
  if ((result == 0) != (why[0] == 0)) std::abort();  // refused without a sentence
  return result == 0;
}

void must(bool truth, const char *what) {
  if (truth) return;
  std::fprintf(stderr, "snapshot: %s\n", what);
  std::exit(2);
}

// A machine at work: an axis that is moved, events to come, a table.
void start() {
  mmcs_config config = {};
  config.abi = MMCS_SIM_ABI;
  config.cards = 1;
  config.axes = 2;
  config.skip = 1;
  config.cpu_us_per_axis = 30;
  config.latency_max_us = 20;
  config.bus_timeout_us = 16;
  mmcs_motor motor = {};
  motor.inertia = 1e-4;
  motor.viscous = 1e-4;
  motor.km = 0.1;
  motor.resistance = 1.0;
  motor.amp_gain = 1.0;
  motor.gear = 50;
  motor.counts_per_rev = 2000;
  motor.index_per_rev = 1;
  const mmcs_motor motors[2] = {motor, motor};
  char why[200] = "";
  sim = mmcs_sim_create(&config, motors, nullptr, why, sizeof why);
  must(sim != nullptr, why);
  const int client = mmcs_sim_open(sim, 2);
  for (int axis = 0; axis < 2; ++axis) {
    struct mc_param param = MC_PARAM_INITIAL;
    param.which = axis;
    param.mode = MD_POS | COULCOMP;
    param.a0 = 5;
    must(mmcs_sim_ioctl(sim, client, MSETPARAM, &param) == 0, "parameters");
  }
  must(mmcs_sim_ioctl(sim, client, MENABLE, nullptr) == 0, "enable");
  static const double table[] = {0, 5, 9, 3};
  mmcs_segment segment = {};
  segment.kind = MMCS_SEG_TABLE;
  segment.duration = 0.05;
  segment.table = table;
  segment.table_len = 4;
  must(mmcs_sim_add_segment(sim, &segment) == 0, "segment");
  const mmcs_event event = {1.0, 0, 0, 1.0};
  must(mmcs_sim_add_event(sim, &event) == 0, "event");
  must(mmcs_sim_start_motion(sim, client) == 0, "motion");
  must(mmcs_sim_run(sim, mmcs_sim_time(sim) + 0.01) == 0, "run");
  const int64_t id = mmcs_sim_snapshot(sim);
  const uint8_t *bytes;
  int64_t size = mmcs_sim_snapshot_bytes(sim, id, &bytes);
  good[0].assign(bytes, bytes + size);
  size = mmcs_sim_history_bytes(sim, &bytes);
  good[1].assign(bytes, bytes + size);
  must(restore(good[0], good[1]), "the snapshot itself is refused");
}

// The first inputs of all: what there is to damage.
void write_seeds(const std::filesystem::path &folder) {
  for (int kind = 0; kind < 4; ++kind) {
    const Bytes &from = good[kind & 1];
    std::ofstream file(folder / ("seed" + std::to_string(kind)), std::ios::binary);
    file.put(static_cast<char>(kind));
    const size_t skip = kind < 2 ? kHeader : 0;
    file.write(reinterpret_cast<const char *>(from.data() + skip),
               static_cast<std::streamsize>(from.size() - skip));
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int *, char ***) {
  start();
  goes_on = std::getenv("GOES_ON") != nullptr;
  if (const char *folder = std::getenv("SEEDS")) write_seeds(folder);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 1) return 0;
  const int kind = data[0] & 3, which = kind & 1;
  const Bytes bytes =
      kind < 2 ? with_header(good[which], data + 1, size - 1) : Bytes(data + 1, data + size);
  const bool taken = which ? restore(good[0], bytes) : restore(bytes, good[1]);
  if (taken && goes_on) (void)mmcs_sim_run(sim, mmcs_sim_time(sim) + kOn);
  return 0;
}
