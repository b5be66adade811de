# SPDX-License-Identifier: Apache-2.0
"""The examples of the programmer's manual run as they are printed, each as a program of its own."""

import re

import pytest

from mmcs import ROOT
from mmcs.tests.device_bench import compile_1989
from tools.compiled import written

PAGE = (ROOT / "docs" / "use" / "driver.md").read_text()
EXAMPLES = re.findall(r"```c\n(.*?)```", PAGE, flags=re.S)

PROGRAM = """
#include <stdio.h>
#include <signal.h>
#include <sys/file.h>
#include "/usr/sys/sundev/mcdef.h"
#include <sys/mmcs.h>
int fd;
check(result) { if (result < 0) { perror("example"); exit(1); } }
#define expect(truth) if (!(truth)) { printf("not so: %s\\n", #truth); exit(2); }
void handler() {}
struct mc_stats then, now;
main()
{
    check(fd = open("/dev/mc0", O_RDWR));
    {
EXAMPLE
    }
    /* whatever the example sets off comes before the program ends, on any machine */
    check(ioctl(fd, MGETSTATS, &then));
    do
        check(ioctl(fd, MGETSTATS, &now));
    while (now.total - then.total < 50);
    exit(0);
}
"""


def title(example):
    return re.sub(r"\W+", "-", example.split("*/")[0].split(":")[0].strip("/* ")).strip("-")


@pytest.mark.req("DRV-1", "DRV-3")
@pytest.mark.parametrize("example", EXAMPLES, ids=title)
def test_example(bench, example):
    source = written(f"example_{title(example)}.c", PROGRAM.replace("EXAMPLE", example))
    assert bench.finish(bench.start(compile_1989(source))) == ("", 0)
