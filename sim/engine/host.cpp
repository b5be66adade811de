// SPDX-License-Identifier: Apache-2.0
// The host computer: see host.h.

#include "host.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace mmcs {
namespace {

constexpr uint32_t kWindow = 0x6000;  // jumpers A15-A11
constexpr unsigned kAmDriver = 0x2D;  // short supervisory
constexpr int kLevel = 5;             // J5, J7
constexpr uint8_t kVector = 0x40;     // the first one free for users on a 68000
constexpr uint32_t kSysclkHz = 8000000;
constexpr double kPatienceS = 1.0;  // as long as a request waits at most
constexpr double kLookS = 1e-3;
constexpr double kQuietS = 0.05;   // without an interrupt: mc_watch(),
constexpr double kAgainS = 0.01;   // and again
constexpr double kSliceS = 20e-6;  // between looks for what ends a stretch on a real processor

}  // namespace

Host::Host(Machine &machine, VmeBus &bus, const mmcs_config &config)
    : machine_(machine),
      bus_(bus),
      memory_((mc_size() + 7) / 8),
      random_(config.seed),
      latency_clks_(machine.clocks(config.latency_max_us * 1e-6)),
      cpu_us_per_axis_(config.cpu_us_per_axis),
      signals_(MC_MAX_CLIENTS),
      motion_(config.axes),
      recorder_(config.axes) {
  bind();
  const struct mc_config mc_config = {kSysclkHz, kVector, static_cast<uint32_t>(config.axis_speed)};
  if (mc_attach(mc(), &mc_bus_, &mc_os_, &mc_config) != 0) {
    throw std::runtime_error("the driver refuses its configuration");
  }
  if (config.host == MMCS_HOST_NATIVE) return;
  Processor::Events events{[this] { recorder_.mark(machine_); },
                           [this](bool sampled) {
                             heard();
                             served(sampled);
                           },
                           [this](int client) { mc_os_.signal(this, client); },
                           [this](const std::string &text) { mc_os_.log(this, text.c_str()); }};
  cpu_ = std::make_unique<Processor>(machine_, bus_, mc(), config, std::move(events));
}

void Host::bind() {
  mc_bus_.ctx = mc_os_.ctx = this;
  mc_bus_.read8 = [](void *ctx, uint16_t offset, uint8_t *value) {
    return of(ctx).access(false, offset, value);
  };
  mc_bus_.write8 = [](void *ctx, uint16_t offset, uint8_t value) {
    return of(ctx).access(true, offset, &value);
  };
  mc_os_.signal = [](void *ctx, int client) {
    if (of(ctx).machine_.host_dead()) return;
    ++of(ctx).signals_.at(static_cast<size_t>(client));
    if (of(ctx).ends_ != Ends::kAtClock) of(ctx).ended_ = true;
    of(ctx).machine_.note("signal", -1, "SIGUSR1 to client " + std::to_string(client));
  };
  mc_os_.log = [](void *ctx, const char *text) {
    if (!of(ctx).machine_.host_dead()) of(ctx).machine_.note("log", -1, text);
  };
  mc_os_.compute = [](void *ctx, unsigned axes) {
    Host &host = of(ctx);
    if (host.machine_.host_dead()) return;
    const double us = host.cpu_us_per_axis_ * axes;
    host.machine_.advance(host.machine_.clocks(us * 1e-6), Watch::kNothing);
  };
  mc_os_.delay_us = [](void *ctx, uint32_t us) { of(ctx).wait(us); };
  mc_os_.mask = [](void *ctx) {
    const unsigned previous = of(ctx).masked_;
    of(ctx).masked_ = true;
    return previous;
  };
  mc_os_.unmask = [](void *ctx, unsigned previous) {
    of(ctx).masked_ = previous != 0;
    of(ctx).poll();
  };
  mc_os_.copy_in = mc_os_.copy_out = [](void *, void *to, const void *from, size_t len) {
    if (!to || !from) return -MC_EFAULT;
    std::memcpy(to, from, len);
    return 0;
  };
}

enum mc_bus_result Host::access(bool write, uint16_t offset, uint8_t *value) {
  uint32_t data = *value;
  const BusResult result = write ? bus_.write(kWindow + offset, kAmDriver, 1, data)
                                 : bus_.read(kWindow + offset, kAmDriver, 1, &data);
  if (!write) *value = static_cast<uint8_t>(data);
  poll();
  return static_cast<enum mc_bus_result>(result);
}

// --- interrupts --------------------------------------------------------------------------------

// Draws the latency when a request appears; forgets it when the request goes away.
void Host::track_request() {
  if (!machine_.irq()) {
    requested_ = false;
  } else if (!requested_) {
    requested_ = true;
    due_clock_ = machine_.clock() + random_.upto(latency_clks_);
  }
}

bool Host::due() const {
  return requested_ && !masked_ && !serving_ && machine_.clock() >= due_clock_ &&
         machine_.clock() >= machine_.stalled_until() && !machine_.host_dead();
}

// A request that nobody takes stays: between two of its interrupts others have their turn.
void Host::poll() {
  int64_t quiet_since = -1;
  track_request();
  while (due() && !machine_.failed() && quiet_since != quiet_since_) {
    quiet_since = quiet_since_;
    serve();
    track_request();
  }
}

// Also when an exception ends it the host is free again: else no interrupt would ever be served.
bool Host::interrupt() {
  struct Level {
    Host &host;
    explicit Level(Host &h) : host(h) { host.serving_ = host.masked_ = true; }
    ~Level() { host.requested_ = host.serving_ = host.masked_ = false; }
  } const level(*this);
  recorder_.mark(machine_);
  uint8_t vector = 0;
  if (bus_.acknowledge(kLevel, &vector) == BusResult::kOk && vector == kVector) {
    const bool sampled = mc_interrupt(mc()) == 1;
    heard();
    return sampled;
  }
  mc_spurious(mc());
  return false;
}

void Host::serve() {
  served(interrupt());
}

// An interrupt is over: what it found is recorded, and the process writes for the next one.
void Host::served(bool sampled) {
  if (machine_.host_dead()) return;  // in the midst of it: what the driver did then was no more
  if (sampled) {
    recorder_.sample(mc(), machine_);
    machine_.tap().sample(mc(), machine_.model(), recorder_.samples(), recorder_.sample_clock());
  }
  recorder_.errors(machine_, mc());
  recorder_.interrupt(machine_, stats());
  tell();
  if (sampled && ends_ == Ends::kAtSample) ended_ = true;
  if (sampled) write_setpoints();
}

void Host::heard() {
  if (machine_.host_dead()) return;
  quiet_since_ = machine_.clock();
  watch_clock_ = quiet_since_ + machine_.clocks(kQuietS);
}

// The clock of Unix: the driver is told when no interrupt has come for long. A request that has
// waited longer than its latency is one that nobody takes: of a wrong vector.
void Host::watch() {
  const int64_t now = machine_.clock();
  if (opens_ == 0 || now < watch_clock_) return;
  watch_clock_ = std::max(now, machine_.stalled_until()) + machine_.clocks(kAgainS);
  if (requested_ && now - quiet_since_ < latency_clks_ + machine_.clocks(kQuietS)) return;
  if (now < machine_.stalled_until() || machine_.host_dead()) return;
  const auto us =
      static_cast<uint32_t>(static_cast<double>(now - quiet_since_) * 1e6 / Model::clk_hz());
  if (cpu_) {
    cpu_->watch(us);
  } else {
    mc_watch(mc(), us);
    recorder_.errors(machine_, mc());
    tell();
  }
}

bool Host::run_until(int64_t clock, const std::function<void()> &idle) {
  if (cpu_) {
    bool good = true;
    while (good && !ended_ && machine_.clock() < clock) {
      watch();
      int64_t end = opens_ > 0 ? std::min(clock, watch_clock_) : clock;
      if (ends_ != Ends::kAtClock) {
        end = std::min(end, machine_.clock() + machine_.clocks(kSliceS));
      }
      good = cpu_->run_until(end, idle);
    }
    return good;
  }
  while (machine_.clock() < clock && !machine_.failed()) {
    if (idle) idle();
    poll();
    watch();
    if (ended_) return !machine_.failed();
    int64_t until = opens_ > 0 ? std::min(clock, watch_clock_) : clock;
    if (requested_ && !masked_ && !machine_.host_dead()) {
      until = std::min(until, std::max(due_clock_, machine_.stalled_until()));
    }
    if (until > machine_.clock()) machine_.advance(until - machine_.clock(), Watch::kIrq);
  }
  poll();
  return !machine_.failed();
}

// --- the process that moves the axes -----------------------------------------------------------

void Host::start_motion(int client) {
  motion_client_ = client;
  motion_axes_ = 0;
  recorder_.start(machine_.clock());
  const int joints = mc_joints(mc());
  for (int axis = 0; axis < joints; ++axis) {
    if (!motion_.moves(axis)) continue;
    motion_axes_ = axis + 1;
    motion_.start(axis, mc_setpoint(mc(), axis));
  }
  written_.clear();
}

// Between samples, at the time of the sample: what it writes is in force at the next one.
void Host::write_setpoints() {
  if (motion_axes_ == 0 || recorder_.sample_clock() < recorder_.start_clock()) return;
  const double t = static_cast<double>(recorder_.sample_clock() - recorder_.start_clock()) /
                   static_cast<double>(Model::clk_hz());
  std::vector<int32_t> values(static_cast<size_t>(motion_axes_));
  for (int axis = 0; axis < motion_axes_; ++axis) {
    values[static_cast<size_t>(axis)] =
        motion_.moves(axis) ? motion_.at(axis, t) : mc_setpoint(mc(), axis);
  }
  if (values == written_) return;
  if (cpu_) {
    cpu_->post_write(motion_client_, values);
  } else {
    send(motion_client_, values);
  }
  written_.swap(values);
}

// What the way to the driver changes of a program's setpoints is changed here.
int Host::send(int client, std::vector<int32_t> values) {
  const size_t bytes = 4 * values.size();
  if (!machine_.pass_write(values)) return static_cast<int>(bytes);
  return mc_write(mc(), client, values.data(), bytes);
}

// --- /dev/mc0 ----------------------------------------------------------------------------------

void Host::tell() {
  if (machine_.tap().on()) machine_.tap().driver(machine_.time(), mc());
}

// A request of a process: its patience begins; interrupts that waited are served after it.
template <class F>
int Host::request(F f) {
  if (machine_.host_dead()) return 0;  // who could hear another answer?
  const int64_t outer =
      std::exchange(patience_ends_, machine_.clock() + machine_.clocks(kPatienceS));
  const int result = f();
  patience_ends_ = outer;
  if (!cpu_) poll();
  tell();
  return result;
}

void Host::wait(uint32_t us) {
  const int64_t end = machine_.clock() + machine_.clocks(us * 1e-6);
  const bool outer = std::exchange(waiting_, true);
  while (machine_.clock() < std::min(end, patience_ends_) && !machine_.failed()) {
    const int64_t look = machine_.clock() + machine_.clocks(kLookS);
    run_until(std::min({end, patience_ends_, look}));
    if (look_ && look_(look_ctx_) != 0) patience_ends_ = machine_.clock();
  }
  waiting_ = outer;
}

int Host::open(int flags) {
  return request([=] {
    const int client =
        cpu_ ? cpu_->call(MAILBOX_OPEN, 0, static_cast<uint32_t>(flags), nullptr, 0, 0)
             : mc_open(mc(), flags);
    if (client >= MC_MAX_CLIENTS) return -MC_EIO;  // a firmware may answer anything
    if (client < 0) return client;
    signals_.at(static_cast<size_t>(client)) = 0;
    if (opens_++ == 0) heard();
    return client;
  });
}

int Host::close(int client) {
  if (client == motion_client_) {
    motion_client_ = -1;
    motion_axes_ = 0;
  }
  return request([=] {
    const int result =
        cpu_ ? cpu_->call(MAILBOX_CLOSE, client, 0, nullptr, 0, 0) : mc_close(mc(), client);
    if (result == 0) --opens_;
    return result;
  });
}

int Host::ioctl(int client, uint32_t request, void *arg) {
  return this->request([=] {
    if (!cpu_) return mc_ioctl(mc(), client, request, arg);
    const size_t size = request >> 16 & 0x1FFF;
    return cpu_->call(MAILBOX_IOCTL, client, request, arg, request & MC_ARG_IN ? size : 0,
                      request & MC_ARG_OUT ? size : 0);
  });
}

int Host::read(int client, void *buf, size_t len) {
  if (cpu_) return cpu_->call(MAILBOX_READ, client, static_cast<uint32_t>(len), buf, 0, len);
  return mc_read(mc(), client, buf, len);
}

int Host::write(int client, const void *buf, size_t len) {
  if (buf == nullptr || len % sizeof(int32_t) != 0 || len == 0 || cpu_) {
    return cpu_ ? cpu_->call(MAILBOX_WRITE, client, static_cast<uint32_t>(len),
                             const_cast<void *>(buf), len, 0)
                : mc_write(mc(), client, buf, len);
  }
  std::vector<int32_t> values(len / sizeof(int32_t));
  std::memcpy(values.data(), buf, len);
  return send(client, std::move(values));
}

int Host::stop() {
  if (cpu_) {
    cpu_->stop();
    return 0;
  }
  return request([=] { return mc_halt(mc()); });
}

int Host::take_signals(int client) {
  if (client < 0 || client >= MC_MAX_CLIENTS) return 0;
  int count = 0;
  std::swap(count, signals_[static_cast<size_t>(client)]);
  return count;
}

}  // namespace mmcs
