# SPDX-License-Identifier: Apache-2.0
"""States in which a part nearly always is, and the code that generate.py makes of them.

A state (usual.toml) tells of some of a part's registers, inputs and wires what they are; all else
may be anything. For each of them fast.cpp gets a clock, and what follows from inputs, compiled with
these values as constants. They are compared before, so that the table decides nothing but the
speed. The last state is for a part in none of the others: it tells only what is so nearly always.
"""

from __future__ import annotations

import re
from pathlib import Path

KINDS = ("clock", "inputs")
WIDEST = 4  # bits of a variable that tells states apart


def members(root: Path) -> list[str]:
    """A model's variables of no more than WIDEST bits, without those of Verilator's own."""
    found = re.findall(
        r"^\s*(?:VL_(?:IN|OUT)8\((\w+),(\d+),(\d+)\)|CData/\*(\d+):(\d+)\*/ (\w+));",
        root.read_text(), re.M)  # fmt: skip
    widths = {m[0] or m[5]: int(m[1] or m[3]) - int(m[2] or m[4]) + 1 for m in found}
    own = re.compile(r"__V|(.*__DOT__)?clk_i$")
    return [n for n, width in widths.items() if width <= WIDEST and not own.match(n)]


def readable(name: str, module: str) -> str:
    name = name.removeprefix(f"{module}__DOT__")
    return name.replace("__DOT__", ".").replace("__BRA__", "[").replace("__KET__", "]")


def usual_text(module: str, table: dict, root: Path, edges: str) -> str:
    """The states of a part, as fast.cpp includes them."""
    member = {readable(n, module): n for n in members(root)}
    before = {new: old for old, new in re.findall(r"\((\w+), (\w+)\)", edges)}
    names = table.get("names", "").split()
    out = []
    for kind in KINDS:
        states = []
        for row in table.get(kind, []):
            told = {n: int(v, 16) for n, v in zip(names, row, strict=True) if v != "-"}
            # In another machine the part may be another: then the last state alone is left.
            if told.keys() <= member.keys() or row is table[kind][-1]:
                state = {member[n]: v for n, v in told.items() if n in member}
                states.append(state | {before[n]: v for n, v in state.items() if n in before})
        out += _kind(kind, states)
    return "\n".join(out) + "\n"


def _kind(kind: str, states: list[dict[str, int]]) -> list[str]:
    out = []
    for number, state in enumerate(states):
        out.append(f"__attribute__((flatten)) static bool {kind}_{number}(Root *root) {{")
        out += [f"  if (root->{n} != {v}) __builtin_unreachable();" for n, v in state.items()]
        out += [f"  return one_{kind}(root);", "}"]
    out += [f"struct Usual_{kind} {{", f"  static constexpr size_t kStates = {len(states)};",
            "  static constexpr Value kValues[] = {"]  # fmt: skip
    out += [f"    {{{number}, offsetof(Root, {n}), sizeof(Root::{n}), {v}}},"
            for number, state in enumerate(states) for n, v in state.items()]  # fmt: skip
    out += ["    {0, 0, 0, 0}};", "  static size_t guess(const Root *root) {"]
    out += _guess(dict(enumerate(states[:-1])), "    ")
    out += ["  }", "  static bool run(size_t state, Root *root) {", "    switch (state) {"]
    out += [f"      case {n}: return {kind}_{n}(root);" for n in range(len(states))]
    return [*out, f"      default: return one_{kind}(root);", "    }", "  }", "};"]


def _guess(states: dict[int, dict[str, int]], indent: str) -> list[str]:
    """Which state it is, if it is one of these: by as few variables as tell them apart."""
    if len(states) < 2:
        return [f"{indent}return {next(iter(states), 0)};"]

    def groups(name: str) -> dict[int, dict]:
        out: dict[int, dict] = {}
        for number, state in states.items():
            out.setdefault(state[name], {})[number] = state
        return out

    common = set.intersection(*(set(s) for s in states.values()))
    best = min(sorted(common), key=lambda n: max(map(len, groups(n).values())))
    out = [f"{indent}switch (root->{best}) {{"]
    for value, group in groups(best).items():
        out += [f"{indent}  case {value}:", *_guess(group, indent + "    ")]
    return [*out, f"{indent}}}", f"{indent}return 0;"]
