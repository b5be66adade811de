// SPDX-License-Identifier: Apache-2.0
// The tap: every servo sample and every change, for readers beside the program; laid out as in
// docs/use/protocol.md.
//
// Two bounded rings of plain records, one of samples and one of events; each reader keeps its own
// place. Looking costs the machine neither a bus cycle nor time, and is no part of its state: with
// the tap and without it a run is the same to the bit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "driver.h"
#include "mmcs_sim.h"
#include "model.h"

namespace mmcs {

class Tap {
 public:
  // A sample's axis: struct mc_state, setpoint, demand, current.
  static constexpr int kFields = 10;

  explicit Tap(int cards) : cards_(cards), axes_(2 * cards), row_bytes_(bytes_of_row(cards)) {}

  // From now on the last so many samples and events are kept; 0: none, and nothing is looked at.
  void keep(int64_t rows, int64_t events);
  bool on() const { return events_kept_ > 0; }

  // What happens, told by those whom it happens to.
  void sample(const struct mc *mc, const Model &model, int64_t number, int64_t clock);
  void lines(double t, unsigned lines);
  void lights(double t, const Model &model);
  void driver(double t, const struct mc *mc);  // after every interrupt and request
  void event(double t, const char *kind, int axis, int32_t value, const std::string &text);

  // Positions count from the first record ever; what came before the oldest is lost.
  struct Read {
    int64_t next, lost;
    int32_t count;
  };
  int row_bytes() const { return row_bytes_; }
  int64_t rows() const { return rows_; }
  int64_t events() const { return events_; }
  // Every n-th position from `from` on, as many as there are and as `buffer` holds.
  Read read_rows(int64_t from, int32_t every, uint8_t *buffer, int32_t limit) const;
  Read read_events(int64_t from, mmcs_tap_event *buffer, int32_t limit) const;

 private:
  static int bytes_of_row(int cards) { return (24 + 4 * kFields * 2 * cards + 4 * cards + 7) & ~7; }
  void errors(double t, const struct mc *mc, int axis);

  int cards_, axes_, row_bytes_;
  int64_t rows_kept_ = 0, events_kept_ = 0;
  int64_t rows_ = 0, events_ = 0;  // so many have been; the next one's position
  std::vector<uint8_t> row_ring_;
  std::vector<mmcs_tap_event> event_ring_;
  // as last told
  unsigned lines_ = 0;
  int enabled_ = 0, stopped_ = 0;
  std::vector<unsigned> lights_;
  std::vector<int32_t> errcodes_;
  std::vector<struct mc_param> params_;
  struct Settings {
    uint32_t interval_us;
    int diag, double_buffer, joints;
  } settings_{};
};

}  // namespace mmcs
