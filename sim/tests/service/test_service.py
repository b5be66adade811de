# SPDX-License-Identifier: Apache-2.0
"""sim/service against a recorder of requests: their order, and which refusal is told."""

import errno

import pytest

from mmcs import ROOT, mcdef
from tools.compiled import compiled, ran, written

RECORDER = r"""
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"
static int n, fail;
static double now = 0.5;
static int answer(void) { return ++n == fail ? -22 : 0; }
int mmcs_sim_ioctl(mmcs_sim *sim, int client, uint32_t request, void *argument) {
  printf("%08x", request);
  if (request & 0x80000000) printf(" %d", *(int *)argument);
  if (request == MSETPARAM) printf(" a0 %d mode %x", ((struct mc_param *)argument)->a0,
                                   ((struct mc_param *)argument)->mode);
  puts("");
  return answer();
}
int mmcs_sim_write(mmcs_sim *sim, int client, const void *data, size_t size) {
  printf("write");
  for (size_t k = 0; k < size / 4; k++) printf(" %d", ((const int *)data)[k]);
  puts("");
  return answer();
}
int mmcs_sim_read(mmcs_sim *sim, int client, void *data, size_t size) {
  struct mc_state *states = data;
  printf("read %d\n", (int)(size / sizeof *states));
  for (size_t k = 0; k < size / sizeof *states; k++)
    states[k].errcode = k == 0 ? MERR_PHI : k == 1 ? MERR_PLO : k == 2 ? MERR_POSLIM : 0;
  return answer() ? -22 : (int)size;
}
int mmcs_sim_signals(mmcs_sim *sim, int client) { return puts("signals"), 1; }
int mmcs_sim_open(mmcs_sim *sim, int flags) {
  return printf("open %d\n", flags), answer() ? -6 : 5;
}
int mmcs_sim_run(mmcs_sim *sim, double t) { return printf("run %g\n", now = t), 0; }
double mmcs_sim_time(const mmcs_sim *sim) { return now; }
int mmcs_sim_start_motion(mmcs_sim *sim, int client) {
  return printf("start %d\n", client), answer();
}
const char *mmcs_sim_input_name(int32_t input) { return "estop"; }
static const mmcs_input row = {.healthy = 1};
const mmcs_input *mmcs_sim_input(int32_t input) { return input == 3 ? &row : NULL; }
int mmcs_sim_add_event(mmcs_sim *sim, const mmcs_event *event) {
  return printf("event %g %d %d %g\n", event->t, event->input, event->index, event->value),
         answer();
}
static void end(int result, const char *said) { printf("= %d %s\n", result, said); exit(0); }
int main(int argc, char **argv) {
  struct mc_param params[4] = {{.a0 = 5, .mode = MD_POS | POSCHK}, {.a0 = 6}, {.a0 = 7}};
  mmcs_driver driver = {2, atoi(argv[2]), 1000, 1};
  mmcs_set sets[] = {{3, -1, 50}, {9, MD_MASK, MD_VEL}, {0, -1, 9}};
  char said[40] = "";
  fail = atoi(argv[3]);
  if (!strcmp(argv[1], "configure"))
    end(mmcs_sim_configure(NULL, 0, atoi(argv[4]), &driver, params, said, sizeof said), said);
  if (strcmp(argv[1], "begin")) driver.axes = 3;
  mmcs_script *script = mmcs_script_create(&driver, params);
  if (!strcmp(argv[1], "begin")) {
    mmcs_timed_event up = {0.1, -1, 1, 2, 0, 1}, fault = {0.2, 0.3, 7, 3, 1, 0};
    mmcs_script_event(script, &fault);
    mmcs_script_event(script, &up);
    end(mmcs_script_begin(script, NULL, said, sizeof said), said);
  }
  mmcs_call call = {0.25, strtoul(argv[4], NULL, 0), atoi(argv[5]), atoi(argv[6])};
  if (!strcmp(argv[1], "act")) {
    double goals[] = {7, -8, 9}, late[] = {0, 100};
    mmcs_process turns = {0.25, 0, 0, 0, MMCS_PROCESS_BOUNCE, 0x7};
    mmcs_process loop = {0.001, 2, 3, 1000, MMCS_PROCESS_PD, 0x2};
    mmcs_script_call(script, &call, sets, 3);
    mmcs_script_process(script, call.value ? &loop : &turns, goals, late, 2);
    mmcs_script_resume(script, 5, 0.5, atof(argv[7]), 0);
    end(mmcs_script_act(script, NULL, call.value ? 0.0025 : 0.252, said, sizeof said), said);
  }
  int result = mmcs_script_ask(script, NULL, &call, sets, 3);
  const mmcs_answer *answers;
  const int count = mmcs_script_answers(script, &answers);
  for (int k = 0; k < count; k++)
    snprintf(said + strlen(said), 14, "%d:%d ", answers[k].axis, answers[k].result);
  end(result, said);
}
"""
NAMES = {f"{v:08x}": n for n, v in mcdef.constants().items()
         if v & 0xFF00 == mcdef.MC_GROUP and not n.startswith("MC_")}  # fmt: skip


@pytest.fixture(scope="module")
def said():
    """Lines of requests by name, then what came of it."""
    command = ["c++", "-std=c++17", f"-I{ROOT}/sim/abi", f"-I{ROOT}/firmware/include"]
    names = ("configure", "script")
    service = [compiled(f"{n}.o", [*command, "-c"], [ROOT / f"sim/service/{n}.cpp"]) for n in names]
    recorder = written("recorder.c", RECORDER)
    program = compiled("recorder", ["cc", *command[2:]], [recorder, *service], ["-lstdc++", "-lm"])

    def run(*words) -> list[str]:
        out = ran(program, *words, check=True).stdout
        lines = [line.split() for line in out.splitlines()]
        return [" ".join([NAMES.get(line[0], line[0]), *line[1:]]) for line in lines]

    return run


ALL = ["MSETNUMJOINTS 2", "MSETINTERVAL 1000", "MDACMODE 1", "MSETENC 0", "MSETENC 1"]
W = " write of the scenario's process"
ON = ["MGETPARAM 0", "MSETPARAM 0 a0 5 mode 201", "MGETPARAM 1", "MSETPARAM 1 a0 6 mode 0",
      "MENABLE"]  # fmt: skip


@pytest.mark.req("FW-1")
def test_a_driver_is_configured_in_the_order_of_a_user_program(said):
    assert said("configure", 0, 0, 3) == [*ALL, *ON, "write 0 0", "= 0"]
    assert said("configure", 1, 0, 1) == ["MSETVERBOSITY 1", *ALL, "= 0"]
    assert said("configure", 0, 0, 2) == [*ON, "= 0"]


@pytest.mark.req("FW-1")
def test_the_first_refusal_ends_it_and_is_named(said):
    names = [line.split(" a0")[0] for line in [*ALL, *ON]]
    names = [n.replace("PARAM ", "PARAM of axis ") for n in names] + ["write of the setpoints"]
    for n, name in enumerate(names):
        lines = said("configure", 0, n + 1, 3)
        assert len(lines) == n + 2 and lines[-1] == f"= -{errno.EINVAL} {name}"


@pytest.mark.req("FW-1")
def test_a_script_begins_as_a_user_program_does(said):
    """Events at power-on first, those of the motion when its start is known."""
    start = ["event 0.7 3 1 7", "event 0.8 3 1 1", "start 5"]
    asked = ["event 0.1 2 0 1", "open 2", *ALL, *ON, "write 0 0", *start]
    assert said("begin", 0, 0) == [*asked, "= 0 start of motion"]
    assert said("begin", 0, 1) == [asked[0], "= -22 estop at 0.100000 s"]
    assert said("begin", 0, 2) == [*asked[:2], "= -6 open"]
    assert said("begin", 0, 12)[-1] == "= -22 MENABLE"


@pytest.mark.req("FW-1")
def test_calls_ask_each_axis_named(said):
    def call(request, axes=5, value=0, fail=0):
        return said("call", 0, fail, getattr(mcdef, request), axes, value, 0)

    assert call("MCALIB") == ["read 3", "MCALIB 0", "MCALIB 2", "= 0 0:0 2:0"]
    assert call("MCALIB", fail=3) == ["read 3", "MCALIB 0", "MCALIB 2", "= -22 0:0 2:-22"]
    assert call("MSETENC", value=-1)[1] == f"MSETENC {0xFFFF02}"
    assert call("MCLEARERROR") == ["read 3", "MCLEARERROR", "= 0 -1:0"]
    assert call("MCLEARERROR", fail=1) == ["read 3", "= -22 -1:-22"], "nothing is cleared unseen"
    assert call("MDACMODE", value=1) == ["MDACMODE 1", "= 0 -1:0"]
    assert call("MSTOP", fail=1) == ["MSTOP", "= -22 -1:-22"]
    assert call("MSETPARAM", axes=3) == [
        "MSETPARAM 0 a0 50 mode 202", "MSETPARAM 1 a0 50 mode 2", "= 0 0:0 1:0"]  # fmt: skip


def test_axes_at_one_limit_are_turned_round(said):
    """The call of the same moment comes first; then the process acts every millisecond."""
    first = ["run 0.75", "MSTOP", "run 0.75", "write 7 -8 9"]
    turn = ["signals", "read 3", "MCLEARERROR", "write -7 8 9"]
    assert said("act", 0, 0, mcdef.MSTOP, 0, 0, 0) == [*first, "run 0.751", *turn, "= 0" + W]
    done = said("act", 0, 0, mcdef.MSTOP, 0, 0, 0.3)
    assert "MSTOP" not in done, "what was due before a snapshot has been done"


def test_a_position_loop_wakes_up_by_its_period_and_lateness(said):
    """u = p (goal - y) - d v, with the goal 0 before its time; the third turn is 100 us late."""
    turns = [("0.5", 0), ("0.501", -16), ("0.5021", -16)]
    woken = [line for t, u in turns for line in (f"run {t}", "read 2", f"write 0 {u} 0")]
    assert said("act", 0, 0, mcdef.MSTOP, 0, 1, 0) == [*woken, "= 0" + W]
