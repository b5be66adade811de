// SPDX-License-Identifier: Apache-2.0
// A scenario carried out: events, requests and processes, each at its time (§2.3.6).

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "setup.h"

namespace {

constexpr size_t kAxes = 32;
constexpr int kWords = sizeof(mc_param) / sizeof(int);
constexpr int kReadWrite = 2, kInvalid = 22;  // of open(2) and errno
constexpr double kSignalCheckS = 0.001;       // how soon after a SIGUSR1 its handler runs, at most
constexpr double kMostDrive = 2047;
constexpr double kNever = std::numeric_limits<double>::infinity();

bool named(uint32_t axes, size_t axis) {
  return axes >> axis & 1;
}

int rounded(double value) {
  return static_cast<int>(std::nearbyint(value));  // halves to even
}

void tell(char *what, size_t size, const std::string &text) {
  if (what && size) std::snprintf(what, size, "%s", text.c_str());
}

}  // namespace

struct mmcs_script {
  struct Process {
    mmcs_process asked;
    std::vector<double> goals, late_us;
    double due;
    int64_t turn = 0;
    double woken = 0;
  };

  explicit mmcs_script(const setup &s)
      : duration(s.head->duration),
        driver(s.drivers ? *s.driver : mmcs_driver{}),
        params_now(s.param, s.param + s.params),
        setpoints(s.params),
        segments(s.segment, s.segment + s.segments),
        events(s.event, s.event + s.events),
        calls(s.call, s.call + s.calls),
        sets(s.set, s.set + s.sets),
        numbers(s.number, s.number + s.numbers),
        refusals(s.refusal, s.refusal + s.refusals),
        told(s.processs) {
    for (size_t n = 0; n < s.processs; ++n) {
      const mmcs_process &process = s.process[n];
      const double *goals = s.number + process.goals_at, *late = s.number + process.late_at;
      const double due = process.kind == MMCS_PROCESS_PD ? 0.0 : process.at;
      processes.push_back({process, {goals, goals + axes()}, {late, late + process.turns}, due});
    }
  }

  size_t axes() const { return params_now.size(); }

  // The inputs' values from `from` on.
  int schedule(mmcs_sim *sim, double from, bool at_power_on, std::string &what) const {
    for (const mmcs_timed_event &event : events) {
      if ((event.at_power_on != 0) != at_power_on) continue;
      const mmcs_event begin = {from + event.at, event.input, event.index, event.value};
      const mmcs_input *is = mmcs_sim_input(event.input);
      const double healthy = is ? is->healthy : 0;  // of an upset of any register
      const mmcs_event end = {from + event.until, event.input, event.index, healthy};
      if (mmcs_sim_add_event(sim, &begin) != 0 ||
          (event.until >= 0 && mmcs_sim_add_event(sim, &end) != 0)) {
        const char *name = mmcs_sim_input_name(event.input);
        what = std::string(name ? name : "an upset of a register") + " at " +
               std::to_string(begin.t) + " s";
        return -kInvalid;
      }
    }
    return 0;
  }

  int begin(mmcs_sim *sim, std::string &what) {
    int result = 0;
    for (const mmcs_segment &segment : segments) {
      what = "motion of axis " + std::to_string(segment.axis);
      if (mmcs_sim_add_segment(sim, &segment, numbers.data()) != 0) return -kInvalid;
    }
    result = schedule(sim, 0, true, what);
    if (result < 0) return result;
    if (axes() > 0) {
      what = "open";
      result = client = mmcs_sim_open(sim, kReadWrite);
      if (result < 0) return result;
      char refused[80];
      result = mmcs_sim_configure(sim, client, MMCS_SET_UP | MMCS_SWITCH_ON, &driver,
                                  params_now.data(), refused, sizeof refused);
      what = refused;
    }
    start = mmcs_sim_time(sim);
    if (result < 0) return expects(what) ? -result : result;
    result = schedule(sim, start, false, what);
    if (result < 0) return result;
    what = "start of motion";
    return mmcs_sim_start_motion(sim, std::max(client, 0));
  }

  // Of a request "MSETPARAM of axis 2".
  bool expects(const std::string &refused) const {
    const std::string name = refused.substr(0, refused.find(' '));
    return std::any_of(refusals.begin(), refusals.end(), [&](const mmcs_refusal &one) {
      return name == std::string(one.request, strnlen(one.request, sizeof one.request));
    });
  }

  int act(mmcs_sim *sim, double until, std::string &what) {
    for (;;) {
      Process *process = nullptr;
      double due = next < calls.size() ? calls[next].at : kNever;
      for (Process &one : processes) {
        if (one.due < due) due = (process = &one)->due;
      }
      if (!(due < until)) return 0;
      if (mmcs_sim_run(sim, start + due) != 0) return 1;
      if (!process) {
        const mmcs_call &call = calls[next++];
        ask(sim, call, sets.data() + call.set_at);  // a refusal is an answer
        continue;
      }
      const int result = process->asked.kind == MMCS_PROCESS_PD ? follow(sim, *process, what)
                                                                : bounce(sim, *process, what);
      if (result < 0) return result;
    }
  }

  // changes: of an MSETPARAM.
  int ask(mmcs_sim *sim, const mmcs_call &call, const mmcs_set *changes) {
    const uint32_t request = call.request;
    mc_state states[kAxes] = {};
    if (request == MCALIB || request == MCLEARERROR) {
      // MCALIB: the potentiometer tells which index pulse comes; MCLEARERROR clears what a read
      // showed
      const int got = mmcs_sim_read(sim, client, states, sizeof *states * axes());
      if (got < 0) return answer(request, -1, got);
    }
    if (request != MCALIB && request != MSETENC && request != MSETPARAM) {
      int value = call.value;
      return answer(request, -1,
                    mmcs_sim_ioctl(sim, client, request, request & MC_ARG_IN ? &value : nullptr));
    }
    int least = 0;
    for (size_t n = 0; n < axes(); ++n) {
      if (!named(call.axes, n)) continue;
      const int axis = static_cast<int>(n);
      int value = request == MCALIB ? axis : axis | (call.value & 0xFFFF) << 8;
      void *argument = &value;
      if (request == MSETPARAM) {
        merge(n, call, changes);
        argument = &params_now[n];
      }
      const int result = mmcs_sim_ioctl(sim, client, request, argument);
      least = std::min(least, answer(request, axis, result, states[n]));
    }
    return least;
  }

  void merge(size_t axis, const mmcs_call &call, const mmcs_set *changes) {
    int words[kWords];
    std::memcpy(words, &params_now[axis], sizeof words);
    words[0] = static_cast<int>(axis);
    for (const mmcs_set *change = changes; change != changes + call.sets; ++change) {
      const mmcs_set &set = *change;
      if (set.word < 1 || set.word >= kWords) continue;  // word 0 is `which`
      words[set.word] = (words[set.word] & ~set.mask) | (set.value & set.mask);
    }
    std::memcpy(&params_now[axis], words, sizeof words);
  }

  int answer(uint32_t request, int axis, int result, const mc_state &seen = {}) {
    answers.push_back({request, axis, result, seen.adcvai, seen.encnow});
    return std::min(result, 0);
  }

  // A position loop in a user's process: it is late by its jitter, and sees the last sample.
  int follow(mmcs_sim *sim, Process &process, std::string &what) {
    mc_state states[kAxes] = {};
    size_t count = axes();
    while (count > 1 && !named(process.asked.axes, count - 1)) --count;
    what = "read of the scenario's process";
    const int got = mmcs_sim_read(sim, client, states, sizeof *states * count);
    if (got < 0) return got;
    const double now = mmcs_sim_time(sim) - start;
    mmcs_process_told &seen = told[static_cast<size_t>(&process - processes.data())];
    if (seen.acts++) {
      const double period_us = (now - process.woken) * 1e6;
      seen.shortest_us = seen.acts == 2 ? period_us : std::min(seen.shortest_us, period_us);
      seen.longest_us = std::max(seen.longest_us, period_us);
    }
    process.woken = now;
    for (size_t n = 0; n < count; ++n) {
      if (!named(process.asked.axes, n)) continue;
      const double goal = now >= process.asked.at ? process.goals[n] : 0.0;
      const double u =
          process.asked.p * (goal - states[n].encnow) - process.asked.d * states[n].vel;
      setpoints[n] = rounded(std::min(std::max(u, -kMostDrive), kMostDrive));
    }
    const auto turn = static_cast<size_t>(process.turn++);
    const double late = turn < process.late_us.size() ? process.late_us[turn] : 0.0;
    process.due = (static_cast<double>(process.turn) * process.asked.period_us + late) * 1e-6;
    return write(sim, what);
  }

  // On SIGUSR1: reads the states, clears what they showed, turns the axes at a limit round.
  int bounce(mmcs_sim *sim, Process &process, std::string &what) {
    process.due += kSignalCheckS;
    const bool going = process.turn++ > 0;
    if (going && !mmcs_sim_signals(sim, client)) return 0;
    mc_state states[kAxes] = {};
    if (going) {
      what = "read of the scenario's process";
      const int got = mmcs_sim_read(sim, client, states, sizeof *states * axes());
      if (got < 0) return got;
      mmcs_sim_ioctl(sim, client, MCLEARERROR, nullptr);
    }
    bool turned = false;
    for (size_t n = 0; n < axes(); ++n) {
      const int limits = states[n].errcode & MERR_POSLIM;
      const bool turns = limits == MERR_PHI || limits == MERR_PLO;
      if (!named(process.asked.axes, n) || (going && !turns)) continue;
      const int goal = rounded(process.goals[n]), speed = std::abs(goal);
      setpoints[n] = !going ? goal : limits == MERR_PHI ? -speed : speed;
      turned = true;
    }
    if (!turned) return 0;
    told[static_cast<size_t>(&process - processes.data())].turns += going;
    return write(sim, what);
  }

  int write(mmcs_sim *sim, std::string &what) {
    what = "write of the scenario's process";
    return std::min(
        0, mmcs_sim_write(sim, client, setpoints.data(), sizeof setpoints[0] * setpoints.size()));
  }

  // Gives visit() the bytes of all that changes, but the answers and reports.
  template <class Visit>
  void state(Visit visit) {
    visit(&client, sizeof client);
    visit(&start, sizeof start);
    visit(&next, sizeof next);
    visit(params_now.data(), sizeof params_now[0] * params_now.size());
    visit(setpoints.data(), sizeof setpoints[0] * setpoints.size());
    for (Process &process : processes) {
      visit(&process.due, sizeof process.due);
      visit(&process.turn, sizeof process.turn);
    }
  }

  double duration;
  mmcs_driver driver;
  std::vector<mc_param> params_now;  // in force, of each axis
  std::vector<int> setpoints;        // as written last
  std::vector<mmcs_segment> segments;
  std::vector<mmcs_timed_event> events;
  std::vector<mmcs_call> calls;  // in order of time
  size_t next = 0;               // of them
  std::vector<mmcs_set> sets;
  std::vector<double> numbers;
  std::vector<mmcs_refusal> refusals;
  std::vector<Process> processes;
  std::vector<mmcs_process_told> told;
  std::vector<mmcs_answer> answers;
  int client = -1;
  double start = 0;
};

extern "C" {

mmcs_script *mmcs_script_create_from(const void *data, size_t size, const mmcs_overrides *overrides,
                                     char *err, size_t err_len) {
  setup read;
  if (!setup_open(&read, data, size, overrides, err, err_len)) return nullptr;
  auto *made = new mmcs_script(read);
  setup_close(&read);
  tell(err, err_len, "");
  return made;
}
void mmcs_script_destroy(mmcs_script *script) {
  delete script;
}

int mmcs_script_begin(mmcs_script *script, mmcs_sim *sim, char *what, size_t what_len) {
  std::string named;
  const int result = script->begin(sim, named);
  tell(what, what_len, named);
  return result;
}
double mmcs_script_duration(const mmcs_script *script) {
  return script->duration;
}
double mmcs_script_start(const mmcs_script *script) {
  return script->start;
}
int mmcs_script_axes(const mmcs_script *script) {
  return static_cast<int>(script->axes());
}
int mmcs_script_client(const mmcs_script *script) {
  return script->client;
}
void mmcs_script_resume(mmcs_script *script, int client, double start, double t, int at_it) {
  script->client = client;
  script->start = start;
  for (; script->next < script->calls.size(); ++script->next) {
    const mmcs_call &call = script->calls[script->next];
    if (at_it ? call.at > t : call.at >= t) break;
    if (call.request != MSETPARAM) continue;
    for (size_t n = 0; n < script->axes(); ++n)
      if (named(call.axes, n)) script->merge(n, call, script->sets.data() + call.set_at);
  }
}
int mmcs_script_act(mmcs_script *script, mmcs_sim *sim, double until, char *what, size_t what_len) {
  std::string named;
  const int result = script->act(sim, until, named);
  tell(what, what_len, named);
  return result;
}
int mmcs_script_ask(mmcs_script *script, mmcs_sim *sim, const mmcs_call *call,
                    const mmcs_set *sets) {
  return script->ask(sim, *call, sets + call->set_at);
}
size_t mmcs_script_save(mmcs_script *script, uint8_t *bytes) {
  size_t size = 0;
  script->state([&](const void *part, size_t length) {
    if (bytes) std::memcpy(bytes + size, part, length);
    size += length;
  });
  return size;
}
void mmcs_script_restore(mmcs_script *script, const uint8_t *bytes) {
  script->state([&](void *part, size_t length) {
    std::memcpy(part, bytes, length);
    bytes += length;
  });
}
int32_t mmcs_script_answers(const mmcs_script *script, const mmcs_answer **answers) {
  *answers = script->answers.data();
  return static_cast<int32_t>(script->answers.size());
}
int32_t mmcs_script_told(const mmcs_script *script, const mmcs_process_told **told) {
  *told = script->told.data();
  return static_cast<int32_t>(script->told.size());
}

}  // extern "C"
