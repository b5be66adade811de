# SPDX-License-Identifier: Apache-2.0
"""The robot files as C initialisers, so that the plant's tests need no TOML reader."""

import re

from mmcs import ROOT, load


def fields() -> list[str]:
    """Names of struct mmcs_motor in their order."""
    text = (ROOT / "sim" / "abi" / "mmcs_sim.h").read_text()
    body = re.search(r"struct mmcs_motor \{(.*?)\} mmcs_motor;", text, re.DOTALL)[1]
    body = re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL)
    return [n for names in re.findall(r"\w+ ([\w, ]+);", body) for n in names.split(", ")]


def header() -> str:
    lines = ["#pragma once", '#include "mmcs_sim.h"', "namespace robots {"]
    for name, scenario in (("lab32", "axes32"), ("lab500", "lab500"), ("puma560", "puma560")):
        robot = load(scenario).robot
        lines.append(f"inline constexpr mmcs_motor {name}[] = {{")
        for values in robot.motors(coupled=False):
            lines.append("  {" + ", ".join(str(values[f]) for f in fields()) + "},")
        lines.append("};")
        rotors = ", ".join(str(motor.rotor_inertia) for motor in robot.axis)
        lines.append(f"inline constexpr double {name}_rotor_inertia[] = {{{rotors}}};")
        if robot.link:
            lines.append(f"inline constexpr mmcs_link {name}_links[] = {{")
            for k in robot.links():
                com, inertia = (", ".join(map(str, k[v])) for v in ("com", "inertia"))
                first = ", ".join(str(k[v]) for v in ("alpha", "a", "d", "theta0", "mass"))
                lines.append(f"  {{{first}, {{{com}}}, {{{inertia}}}}},")
            lines.append("};")
    return "\n".join([*lines, "}  // namespace robots", ""])


if __name__ == "__main__":
    print(header(), end="")
