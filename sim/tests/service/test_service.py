# SPDX-License-Identifier: Apache-2.0
"""sim/service against a recorder of requests: their order, and which refusal is told."""

import errno
import random
import re
import zlib
from pathlib import Path

import pytest

from mmcs import ROOT, mcdef, service, setup_file
from tools.compiled import compiled, ran, written

pytestmark = pytest.mark.req("FW-1")
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
  if (argument) printf(" %d", *(int *)argument);
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
int mmcs_sim_run(mmcs_sim *sim, double t) { return printf("run %g\n", now = t), answer(); }
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
int mmcs_sim_add_segment(mmcs_sim *sim, const mmcs_segment *s, const double *numbers) {
  return printf("segment %d %g %g\n", s->axis, s->t0, numbers[s->table_at]), answer();
}
mmcs_sim *mmcs_sim_create(const mmcs_config *config, const mmcs_motor *motors,
                          const mmcs_link *links, char *err, size_t err_len) { return NULL; }
const char *mmcs_sim_build_id(void) { return "c1 0"; }
int32_t mmcs_sim_build_cards(void) { return 1; }
int32_t mmcs_sim_build_clk_hz(void) { return 0; }
static void end(int result, const char *said) { printf("= %d %s\n", result, said); exit(0); }
int main(int argc, char **argv) {
  struct mc_param params[32] = {{.a0 = 5, .mode = MD_POS | POSCHK}, {.a0 = 6}, {.a0 = 7}};
  const mmcs_driver driver = {argc > 5 ? atoi(argv[5]) : 2, atoi(argv[2]), 1000, 1};
  mmcs_set sets[] = {{3, -1, 50}, {9, MD_MASK, MD_VEL}, {0, -1, 9}};
  char said[300] = "";
  fail = atoi(argv[3]);
  if (!strcmp(argv[1], "configure"))
    end(mmcs_sim_configure(NULL, 0, atoi(argv[4]), &driver, params, said, sizeof said), said);
  size_t size;
  void *setup = mmcs_setup_load(argv[5], &size, said, sizeof said);
  mmcs_script *script = mmcs_script_create_from(setup, size, NULL, said, sizeof said);
  if (!script) end(-1, said);
  if (!strcmp(argv[1], "begin"))
    end(mmcs_script_begin(script, NULL, said, sizeof said), said);
  for (int n = 0; n < 2 && !strcmp(argv[1], "act"); n++) {  // and again
    static unsigned char kept[4000];
    const mmcs_process_told *told;
    if (!n) mmcs_script_resume(script, 5, 0.5, atof(argv[4]), argc > 6);
    if (!n) mmcs_script_save(script, kept);
    if (n) mmcs_script_restore(script, kept);
    const double until = mmcs_script_duration(script);
    const int result = mmcs_script_act(script, NULL, until, said, sizeof said);
    mmcs_script_told(script, &told);
    if (!n) printf("%d %d %g %g\n", told->acts, told->turns, told->shortest_us, told->longest_us);
    if (n || result) end(result, said);
  }
  mmcs_call call = {0.25, strtoul(argv[6], NULL, 0), atoi(argv[7]), atoi(argv[8]), 0, 3};
  int result = mmcs_script_ask(script, NULL, &call, sets);
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
    include = [f"-I{ROOT}/{folder}" for folder in ("sim/abi", "sim/setup", "firmware/include")]
    command = ["c++", "-std=c++17", *include]
    names = ("configure", "script")
    service = [compiled(f"{n}.o", [*command, "-c"], [ROOT / f"sim/service/{n}.cpp"]) for n in names]
    reader = compiled("setup.o", ["cc", *include, "-c"], [ROOT / "sim/setup/setup.c"])
    recorder = written("recorder.c", RECORDER)
    program = compiled(
        "recorder", ["cc", *include], [recorder, reader, *service], ["-lstdc++", "-lm"]
    )

    def run(*words) -> list[str]:
        out = ran(program, *words, check=True).stdout
        lines = [line.split() for line in out.splitlines()]
        return [" ".join([NAMES.get(line[0], line[0]), *line[1:]]) for line in lines]

    return run


PARAMS = [{"a0": 5, "mode": mcdef.MD_POS | mcdef.POSCHK}, {"a0": 6}, {"a0": 7}]
SETS = [(3, -1, 50), (9, mcdef.MD_MASK, mcdef.MD_VEL), (0, -1, 9)]


@pytest.fixture
def set_up(tmp_path):
    """A set-up file of a driver with these parameters, and more records."""

    def write(axes: int = 3, duration: float = 1.0, **records) -> Path:
        driver = {"axes": axes, "interval_us": 1000, "double_buffer": 1}
        records |= {"config": [{"cards": 1}], "driver": [driver], "param": PARAMS[:axes]}
        data = setup_file.write("c1 0", "recorded", duration=duration, set=SETS, **records)
        (tmp_path / "recorded.bin").write_bytes(data)
        return tmp_path / "recorded.bin"

    return write


ALL = ["MSETNUMJOINTS 2", "MSETINTERVAL 1000", "MDACMODE 1", "MSETENC 0", "MSETENC 1"]
W = " write of the scenario's process"
ON = ["MGETPARAM 0", "MSETPARAM 0 a0 5 mode 201", "MGETPARAM 1", "MSETPARAM 1 a0 6 mode 0",
      "MENABLE"]  # fmt: skip


def test_a_driver_is_configured_in_the_order_of_a_user_program(said):
    assert said("configure", 0, 0, 3) == [*ALL, *ON, "write 0 0", "= 0"]
    assert said("configure", 1, 0, 1) == ["MSETVERBOSITY 1", *ALL, "= 0"]
    assert said("configure", 0, 0, 2) == [*ON, "= 0"]
    assert [len(said("configure", 0, 0, 3, axes)) for axes in (-1, 32, 33)] == [1, 102, 1]


def test_the_first_refusal_ends_it_and_is_named(said):
    names = [line.split(" a0")[0] for line in [*ALL, *ON]]
    names = [n.replace("PARAM ", "PARAM of axis ") for n in names] + ["write of the setpoints"]
    for n, name in enumerate(names):
        lines = said("configure", 0, n + 1, 3)
        assert len(lines) == n + 2 and lines[-1] == f"= -{errno.EINVAL} {name}"


def test_a_script_begins_as_a_user_program_does(said, set_up):
    """Motions and events at power-on first, those of the motion when its start is known."""
    up = {"at": 0.1, "until": -1, "value": 1, "input": 2, "at_power_on": 1}
    fault = {"at": 0.2, "until": 0.3, "value": 7, "input": 3, "index": 1}
    motion = {"axis": 1, "t0": 0.25, "table_at": 1, "table_len": 1}
    file = set_up(2, event=[fault, up], segment=[motion], number=[0, 8.5],
                  refusal=[{"request": b"MENABLE"}])  # fmt: skip
    start = ["event 0.7 3 1 7", "event 0.8 3 1 1", "start 5"]
    asked = ["segment 1 0.25 8.5", "event 0.1 2 0 1", "open 2", *ALL, *ON, "write 0 0", *start]
    assert said("begin", 0, 0, 0, file) == [*asked, "= 0 start of motion"]
    assert said("begin", 0, 1, 0, file) == [asked[0], "= -22 motion of axis 1"]
    assert said("begin", 0, 2, 0, file) == [*asked[:2], "= -22 estop at 0.100000 s"]
    assert said("begin", 0, 3, 0, file) == [*asked[:3], "= -6 open"]
    assert said("begin", 0, 12, 0, file)[-1] == "= -22 MSETPARAM of axis 1"
    assert said("begin", 0, 13, 0, file)[-1] == "= 22 MENABLE", "this one is expected"
    assert said("begin", 0, 0, 0, set_up(0)) == ["start 0", "= 0 start of motion"]


def test_calls_ask_each_axis_named(said, set_up):
    def call(request, axes=5, value=0, fail=0):
        return said("call", 0, fail, 0, set_up(), getattr(mcdef, request), axes, value)

    assert call("MCALIB") == ["read 3", "MCALIB 0", "MCALIB 2", "= 0 0:0 2:0"]
    assert call("MCALIB", fail=3) == ["read 3", "MCALIB 0", "MCALIB 2", "= -22 0:0 2:-22"]
    assert call("MSETENC", value=-1)[1] == f"MSETENC {0xFFFF02}"
    assert call("MCLEARERROR") == ["read 3", "MCLEARERROR", "= 0 -1:0"]
    assert call("MCLEARERROR", fail=1) == ["read 3", "= -22 -1:-22"], "nothing is cleared unseen"
    assert call("MDACMODE", value=1) == ["MDACMODE 1", "= 0 -1:0"]
    assert call("MSTOP", fail=1) == ["MSTOP", "= -22 -1:-22"]
    assert call("MSETPARAM", axes=3) == [
        "MSETPARAM 0 a0 50 mode 202", "MSETPARAM 1 a0 50 mode 2", "= 0 0:0 1:0"]  # fmt: skip


def test_axes_at_one_limit_are_turned_round(said, set_up):
    """The call of the same moment comes first; then the process acts every millisecond. From a way
    back on it does so again, with the parameters of what was due before."""
    early = {"at": 0.2, "request": mcdef.MSETPARAM, "axes": 1, "sets": 3}
    late = {"at": 0.2515, "request": mcdef.MSETPARAM, "axes": 3}
    stop = {"at": 0.25, "request": mcdef.MSTOP, "axes": 2, "sets": 3}
    turns = {"at": 0.25, "kind": 1, "axes": 7}
    file = set_up(duration=0.252, call=[early, stop, late], process=[turns], number=[7, -8, 9])
    first = ["run 0.75", "MSTOP", "run 0.75", "write 7 -8 9"]
    turn = ["run 0.751", "signals", "read 3", "MCLEARERROR", "write -7 8 9"]
    turn += ["run 0.7515", "MSETPARAM 0 a0 50 mode 202", "MSETPARAM 1 a0 6 mode 0"]
    done = ["run 0.7", "MSETPARAM 0 a0 50 mode 202"]
    for t, more, lines in ((0, (), done + first), (0.25, (), first), (0.25, (1,), first[2:])):
        told = said("act", 0, 0, t, file, *more)
        assert told == [*lines, *turn, "0 1 0 0", *lines, *turn, "= 0" + W]
    assert said("act", 0, 1, 0, file) == [done[0], "0 0 0 0", "= 1"], "an assertion has failed"


def test_a_position_loop_wakes_up_by_its_period_and_lateness(said, set_up):
    """u = p (goal - y) - d v, with the goal 0 before its time; the third turn is 100 us late."""
    late = {"d": 3, "period_us": 1000, "late_at": 3, "turns": 2}
    for at, axes, p, u in ((1, 2, 2, "0 -16 0"), (1, 2, 999, "0 -2047 0"), (0, 1, 999, "2047 0 0")):
        loop = late | {"at": at / 1000, "p": p, "axes": axes}
        file = set_up(duration=0.0025, process=[loop], number=[7, -8, 9, 0, 100])
        turns = [("0.5", "0 0 0" if at else u), ("0.501", u), ("0.5021", u)]
        woken = [line for t, u in turns for line in (f"run {t}", f"read {axes}", f"write {u}")]
        assert said("act", 0, 0, 0, file) == [*woken, "3 0 1000 1100", *woken, "= 0" + W]


DESIGNED = "4202 85be 0834 c358 7a87 c79b dfe8 8520 c6f8 d7da d53e ba7c"
METHODS = [*["backward", "bilinear", "prewarp", "matched", "ztransform", "zoh"] * 4, "euler"]
SCALES = [None, None, None, 1, 4, 256, 256, 1 << 14, 1 << 30, 0, (1 << 30) + 1]
INTERVALS_S, TAUS, PREWARPS = [*[1e-3, 4e-3, 0.05] * 6, 0], [0, 0, 1e-4, 0.01] * 5, [60, 700, 3200]


def test_designs_are_as_ever():
    """Of random gains by every method, to six digits; refusals by their words. Who means to change
    them puts the new digests here."""
    chance, parts = random.Random(1989), []
    for n in range(1200):
        p, i, d = (0 if chance.random() < 0.35 else 10 ** chance.uniform(-3, 2) for _ in range(3))
        gains = [p, i, d / 10, chance.choice([*TAUS, -0.001])]
        t, prewarp, made = chance.choice(INTERVALS_S), chance.choice([*PREWARPS, 0]), []
        try:
            made.append(service.design_discrete(gains, chance.choice(METHODS), t, prewarp))
            num, den = made[0]["num"], made[0]["den"]
            made.append(service.design_integers(num, den, chance.choice(SCALES)))
            made.append(service.design_answer(gains, t))
        except service.DesignError as no:
            made.append(str(no))
        text = re.sub(r"-?\d+\.\d+(e-?\d+)?", lambda m: f"{float(m[0]):.6g}", str(made))
        parts[n // 100 :] = [zlib.crc32(text.encode(), *parts[n // 100 :])]
    assert " ".join(f"{part & 0xFFFF:04x}" for part in parts) == DESIGNED
