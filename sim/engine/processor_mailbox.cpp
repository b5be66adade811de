// SPDX-License-Identifier: Apache-2.0
// The host's end of the mailbox, firmware/ports/mailbox.h: requests, and what the firmware reports.

#include "processor.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace mmcs {
namespace {

constexpr double kStartS = 0.1;
constexpr double kAnswerS = 1.0;

#define FIELD(name) offsetof(struct mailbox, name)

}  // namespace

void Processor::start() {
  const int64_t end = machine_.clock() + machine_.clocks(kStartS);
  while (!up_ && machine_.clock() < end && !machine_.failed()) step(end);
  if (!up_) throw std::runtime_error("the firmware does not come up");
}

uint32_t Processor::word(size_t offset) const {
  const uint8_t *m = memory_ + MAILBOX_BASE + offset;
  return static_cast<uint32_t>(m[0]) << 24 | static_cast<uint32_t>(m[1]) << 16 |
         static_cast<uint32_t>(m[2]) << 8 | m[3];
}

void Processor::set_word(size_t offset, uint32_t value) {
  uint8_t *m = memory_ + MAILBOX_BASE + offset;
  for (int n = 3; n >= 0; --n, value >>= 8) m[n] = static_cast<uint8_t>(value);
}

void Processor::ring() {
  doorbell_ = 1;
  set_level();
}

bool Processor::busy() const {
  return word(FIELD(posted)) != word(FIELD(done));
}

void Processor::post(uint32_t what, int client, uint32_t a, const void *data, size_t bytes) {
  set_word(FIELD(call), what);
  set_word(FIELD(client), static_cast<uint32_t>(client));
  set_word(FIELD(a), a);
  set_word(FIELD(has_data), data ? 1 : 0);
  bytes = std::min(bytes, sizeof(uint32_t) * MAILBOX_DATA_WORDS);
  for (size_t at = 0; data && at + 4 <= bytes; at += 4) {
    uint32_t value;
    std::memcpy(&value, static_cast<const uint8_t *>(data) + at, 4);
    set_word(FIELD(data) + at, value);
  }
  set_word(FIELD(posted), word(FIELD(posted)) + 1);
  ring();
}

int Processor::call(uint32_t what, int client, uint32_t a, void *data, size_t in, size_t out) {
  const int64_t end = machine_.clock() + machine_.clocks(kAnswerS);
  const auto late = [&] { return dead_ || machine_.clock() >= end || machine_.failed(); };
  asks_ = true;
  while ((busy() || !pending_.empty()) && !late()) step(end);
  asks_ = false;
  if (busy() || !pending_.empty()) return -MC_EIO;
  Request request{what, data, out, 0, false};
  request_ = &request;
  post(what, client, a, data, in);
  while (!request.done && !late()) step(end);
  request_ = nullptr;
  return request.done ? request.result : -MC_EIO;
}

// At once: the mailbox belongs to the next request after this.
void Processor::collect(Request &request) {
  request.done = true;
  request.result = static_cast<int>(word(FIELD(result)));
  if (request.result < 0 || !request.data) return;
  if (request.what == MAILBOX_READ) {
    if (static_cast<size_t>(request.result) > request.out) request.result = -MC_EIO;
    request.out = std::min(request.out, static_cast<size_t>(std::max(request.result, 0)));
  }
  request.out = std::min(request.out, sizeof(uint32_t) * MAILBOX_DATA_WORDS);
  for (size_t at = 0; at + 4 <= request.out; at += 4) {
    const uint32_t value = word(FIELD(data) + at);
    std::memcpy(static_cast<uint8_t *>(request.data) + at, &value, 4);
  }
}

void Processor::post_write(int client, const std::vector<int32_t> &values) {
  if (busy() && asks_) return;  // the process asks for something else, and waits for that
  if (busy()) {
    pending_ = values;
    pending_.insert(pending_.begin(), client);
    return;
  }
  post(MAILBOX_WRITE, client, static_cast<uint32_t>(4 * values.size()), values.data(),
       4 * values.size());
}

void Processor::stop() {
  set_word(FIELD(stop), word(FIELD(stop)) + 1);
  ring();
}

void Processor::watch(uint32_t us) {
  set_word(FIELD(quiet_us), us);
  ring();
}

// What the firmware published, as the native driver would hold it.
void Processor::mirror() {
  mirror_->joints = static_cast<int>(std::min<uint32_t>(word(FIELD(joints)), MAILBOX_AXES));
  int32_t stats[6];
  for (size_t n = 0; n < 6; ++n) stats[n] = static_cast<int32_t>(word(FIELD(stats) + 4 * n));
  static_assert(sizeof stats == sizeof mirror_->stats);
  mirror_->power = word(FIELD(enabled)) != 0 ? MC_RUNNING : MC_IDLE;
  mirror_->stopped = word(FIELD(latched)) != 0;
  mirror_->cause = static_cast<uint8_t>(word(FIELD(cause)));
  mirror_->cause_of = static_cast<uint8_t>(word(FIELD(cause_of)) + 1);
  std::memcpy(&mirror_->stats, stats, sizeof stats);
  for (int axis = 0; axis < mirror_->joints && axis < MAILBOX_AXES; ++axis) {
    const size_t at = FIELD(axis) + static_cast<size_t>(axis) * sizeof(struct mailbox_axis);
    mirror_->axis[axis].setpoint = static_cast<int32_t>(word(at));
    int32_t state[7];
    for (size_t n = 0; n < 7; ++n) state[n] = static_cast<int32_t>(word(at + 4 + 4 * n));
    std::memcpy(&mirror_->axis[axis].state, state, sizeof state);
    mirror_->axis[axis].code = static_cast<uint16_t>(word(at + 32) + MC_DAC_ZERO);
    mirror_->axis[axis].par.mode =
        static_cast<int>(word(FIELD(mode) + 4 * static_cast<size_t>(axis)));
  }
}

void Processor::report(uint32_t what) {
  switch (what) {
    case MAILBOX_UP:
      up_ = 1;
      break;
    case MAILBOX_SERVED:
    case MAILBOX_SAMPLED:
      mirror();
      events_.served(what == MAILBOX_SAMPLED);
      break;
    case MAILBOX_DONE:
      mirror();
      if (busy()) break;  // of the request before: `done` was seen, and the next one posted
      if (request_) collect(*request_);
      request_ = nullptr;
      if (!pending_.empty()) {
        const std::vector<int32_t> values(pending_.begin() + 1, pending_.end());
        const int client = pending_.front();
        pending_.clear();
        post_write(client, values);
      }
      break;
    case MAILBOX_SIGNAL:
      if (word(FIELD(signal_client)) < MC_MAX_CLIENTS) {
        events_.signal(static_cast<int>(word(FIELD(signal_client))));
      }
      break;
    case MAILBOX_LOG:
      events_.log(text());
      break;
    case MAILBOX_DEAD: {
      dead_ = 1;
      char line[80];
      std::snprintf(line, sizeof line, "the firmware died: exception %u at 0x%X",
                    static_cast<unsigned>(word(FIELD(fault))),
                    static_cast<unsigned>(word(FIELD(fault_pc))));
      events_.log(line);
      break;
    }
    default:
      break;
  }
}

std::string Processor::text() const {
  std::string out;
  for (size_t n = 0; n < MAILBOX_TEXT; ++n) {
    const char c = static_cast<char>(memory_[MAILBOX_BASE + FIELD(text) + n]);
    if (c == 0) break;
    out += c;
  }
  return out;
}

}  // namespace mmcs
