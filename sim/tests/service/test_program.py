# SPDX-License-Identifier: Apache-2.0
"""sim/service against a recorder of requests: their order, and which refusal is told."""

import errno
import subprocess

import pytest

from mmcs import ROOT, mcdef
from tools.compiled import compiled, written

RECORDER = r"""
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mcdef.h"
#include "mmcs_sim.h"
static int n, fail;
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
int mmcs_sim_signals(mmcs_sim *sim, int client) { return puts("signals"), fail == 0; }
static void end(int result, const char *said) { printf("= %d %s\n", result, said); exit(0); }
int main(int argc, char **argv) {
  struct mc_param params[4] = {{.a0 = 5, .mode = MD_POS | POSCHK}, {.a0 = 6}, {.a0 = 7}};
  mmcs_driver driver = {2, atoi(argv[2]), 1000, 1};
  mmcs_set sets[] = {{3, -1, 50}, {9, MD_MASK, MD_VEL}, {0, -1, 9}};
  struct mc_state states[4];
  int32_t results[32], goals[4] = {-7, 8, 9, 10}, setpoints[4] = {1, 2, 3, 4};
  char said[40] = "";
  fail = atoi(argv[3]);
  if (!strcmp(argv[1], "configure"))
    end(mmcs_sim_configure(NULL, 0, atoi(argv[4]), &driver, params, said, sizeof said), said);
  if (!strcmp(argv[1], "bounce")) {
    int result = mmcs_sim_bounce(NULL, 0, 4, 0x7, goals, setpoints);
    for (int k = 0; k < 4; k++) snprintf(said + strlen(said), 9, "%d ", setpoints[k]);
    end(result, said);
  }
  mmcs_call call = {strtoul(argv[4], NULL, 0), atoi(argv[5]), atoi(argv[6]), 3};
  int result = mmcs_sim_call(NULL, 0, 3, params, &call, sets, states, results);
  for (int k = 0; k < 3; k++) snprintf(said + strlen(said), 9, "%d ", results[k]);
  end(result, said);
}
"""
NAMES = {f"{v:08x}": n for n, v in mcdef.constants().items()
         if v & 0xFF00 == mcdef.MC_GROUP and not n.startswith("MC_")}  # fmt: skip


@pytest.fixture(scope="module")
def said():
    """Lines of requests by name, then what came of it."""
    command = ["c++", "-std=c++17", f"-I{ROOT}/sim/abi", f"-I{ROOT}/firmware/include"]
    service = compiled("program.o", [*command, "-c"], [ROOT / "sim/service/program.cpp"])
    recorder = written("recorder.c", RECORDER)
    program = compiled("recorder", ["cc", *command[2:]], [recorder, service], ["-lstdc++"])

    def run(*words) -> list[str]:
        out = subprocess.check_output([program, *map(str, words)], text=True)
        lines = [line.split() for line in out.splitlines()]
        return [" ".join([NAMES.get(line[0], line[0]), *line[1:]]) for line in lines]

    return run


ALL = ["MSETNUMJOINTS 2", "MSETINTERVAL 1000", "MDACMODE 1", "MSETENC 0", "MSETENC 1"]
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
def test_calls_ask_each_axis_named(said):
    def call(request, axes=5, value=0, fail=0):
        return said("call", 0, fail, getattr(mcdef, request), axes, value)

    assert call("MCALIB") == ["read 3", "MCALIB 0", "MCALIB 2", "= 0 0 0 0"]
    assert call("MCALIB", fail=3) == ["read 3", "MCALIB 0", "MCALIB 2", "= -22 0 0 -22"]
    assert call("MSETENC", value=-1)[1] == f"MSETENC {0xFFFF02}"
    assert call("MCLEARERROR") == ["read 3", "MCLEARERROR", "= 0 0 0 0"]
    assert call("MCLEARERROR", fail=1) == ["read 3", "= -22 -22 0 0"], "nothing is cleared unseen"
    assert call("MDACMODE", value=1) == ["MDACMODE 1", "= 0 0 0 0"]
    assert call("MSTOP", fail=1) == ["MSTOP", "= -22 -22 0 0"]
    assert call("MSETPARAM", axes=3) == [
        "MSETPARAM 0 a0 50 mode 202", "MSETPARAM 1 a0 50 mode 2", "= 0 0 0 0"]  # fmt: skip


def test_axes_at_one_limit_are_turned_round(said):
    lines = ["signals", "read 4", "MCLEARERROR", "write -7 8 3 4", "= 1 -7 8 3 4"]
    assert said("bounce", 0, 0) == lines
    assert said("bounce", 0, 9) == ["signals", "= 0 1 2 3 4"], "not without a signal"
