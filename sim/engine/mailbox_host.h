// SPDX-License-Identifier: Apache-2.0
// The host's end of the mailbox, firmware/ports/mailbox.h: requests of /dev/mc to a processor that
// runs the compiled driver, and what it reports. Which processor, and how time passes for it, is up
// to those who derive from this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "archive.h"
#include "driver.h"
#include "machine.h"
#include "phases.h"

namespace mmcs {

class MailboxHost {
 public:
  // What the firmware reports. The mirror holds joints, setpoints, states and counts by then.
  struct Events {
    std::function<void()> acknowledged;
    std::function<void(bool sampled)> served;
    std::function<void(int client)> signal;
    std::function<void(const std::string &text)> log;
  };

  MailboxHost(Machine &machine, struct mc *mirror, Events events)
      : machine_(machine), mirror_(mirror), events_(std::move(events)) {}
  virtual ~MailboxHost() = default;
  MailboxHost(const MailboxHost &) = delete;
  MailboxHost &operator=(const MailboxHost &) = delete;

  // One request of /dev/mc; time passes until it is answered. `in` and `out` bytes of `data` go
  // there and back. -EIO when the firmware is dead or silent for a second.
  int call(uint32_t what, int client, uint32_t a, void *data, size_t in, size_t out);
  // A write() that nobody waits for, by a process that runs between two samples.
  void post_write(int client, const std::vector<int32_t> &values);

  // Stops the machine as soon as the processor takes its interrupt, whatever request it is at.
  void stop();

  // So many microseconds no interrupt has come: mc_watch().
  void watch(uint32_t us);

  // As Host::run_until().
  virtual bool run_until(int64_t clock, const std::function<void()> &idle) = 0;

  // What the firmware is doing; nullptr: nobody looks.
  virtual const Phases *phases() const { return nullptr; }

  virtual void save(Writer &a) = 0;
  virtual void restore(Reader &a) = 0;

 protected:
  // A word of the mailbox, by its place in bytes.
  virtual uint32_t word(size_t offset) const = 0;
  virtual void set_word(size_t offset, uint32_t value) = 0;
  virtual uint8_t byte(size_t offset) const = 0;
  virtual void ring() = 0;
  // Lets some time pass, not beyond `limit` if nothing happens.
  virtual void step(int64_t limit) = 0;

  // Lets the firmware start. Throws std::runtime_error when it does not.
  void start();
  bool busy() const;
  void report(uint32_t what);
  template <class A>
  void mailbox_state(A &a) {
    a(up_);
    a(dead_);
    a(pending_);
  }

  Machine &machine_;
  struct mc *mirror_;
  Events events_;
  int up_ = 0;
  int dead_ = 0;

 private:
  // The one that call() waits for.
  struct Request {
    uint32_t what;
    void *data;
    size_t out;
    int result;
    bool done;
  };
  void collect(Request &request);
  void post(uint32_t what, int client, uint32_t a, const void *data, size_t bytes);
  void mirror();
  std::string text() const;

  bool asks_ = false;  // call() waits for its turn
  Request *request_ = nullptr;
  std::vector<int32_t> pending_;  // a write that waits for the one before: client, values
};

}  // namespace mmcs
