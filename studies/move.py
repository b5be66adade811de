# SPDX-License-Identifier: Apache-2.0
"""Plans the course of the move of puma560_coupled: `python -m studies.move` writes arm_move.csv.

Joint 1 has 928 D/A units of current, of which friction takes 452. The plan is a linear programme
over the setpoint's acceleration, piecewise linear with a knot each 10 ms: the least peak current of
joint 1 such that its error stays within ERROR counts and it passes its goal by at most OVER counts.
The motor is linear in it; what the arm does beyond that (inertia that changes, torques of the other
joints) is learned from runs on the machine as a disturbance in D/A units.
"""

import argparse

import numpy as np

T, N, KNOT, WAY = 1e-3, 500, 10, 4000
ERROR, OVER, JERK = 56, 6, 2.5e7  # counts, counts, counts/s^3
START = 40  # units kept back before the joint has broken away, whose stiction the model lacks
FRICTION, COMPENSATED = 452, 136
SETS = ("expect=[]", "call=[]", "duration=0.65", "motion.1.at=0.64", "axis.0.ilim=2047")


def respond(law: dict, plant: tuple[float, float], r: np.ndarray, push: np.ndarray):
    """Law's output and error of a linear motor with one sample of delay, sample by sample."""
    b0 = law["b0"]
    a0, a1, b1 = law["a0"] / b0, law["a1"] / b0, law.get("b1", 0) / b0
    y = v = e1 = u1 = waiting = 0.0
    out, errors = np.zeros(len(r)), np.zeros(len(r))
    for k, w in enumerate(r):
        e = w - y
        u = a0 * e + a1 * e1 - b1 * u1
        out[k], errors[k], e1, u1 = u, e, e, u
        after = v + (plant[0] * (waiting + push[k]) - plant[1] * v) * T
        y, v, waiting = y + (v + after) / 2 * T, after, u
    return out, errors


def plan(law: dict, plant: tuple[float, float], push: np.ndarray) -> np.ndarray:
    """Shares of the way, one a sample."""
    from scipy.optimize import linprog

    n, knots = N + 60, N // KNOT + 1
    t = np.arange(n)
    hats = [np.where(t <= N, np.clip(1 - abs(t - m * KNOT) / KNOT, 0, None), 0)
            for m in range(knots)]  # fmt: skip
    speed = np.array([np.cumsum(hat) * T for hat in hats]).T
    way = np.cumsum(speed, axis=0) * T
    made = [respond(law, plant, way[:, m], np.zeros(n)) for m in range(knots)]
    u, e = (np.array([one[part] for one in made]).T for part in (0, 1))
    u0, e0 = respond(law, plant, np.zeros(n), push[:n] + COMPENSATED)
    rows, bounds = [], []

    def at_most(matrix, bound, peak=0.0):
        rows.append(np.hstack([matrix, np.full((len(matrix), 1), peak)]))
        bounds.append(np.broadcast_to(bound, len(matrix)))

    k = np.arange(8, N, 3)
    kept = np.where(k < 95, START, 0) + np.where(k > 340, 25, 0)
    at_most(u[k], -(u0[k] + COMPENSATED) - kept, -1.0)
    at_most(-u[k], u0[k] + COMPENSATED - kept, -1.0)
    at_most(e[k], ERROR - e0[k])
    at_most(-e[k], ERROR + e0[k])
    at_most(-speed[20 : N - 10 : 4], 0.0)
    k = np.arange(N - 60, N, 3)
    at_most((way - e)[k], WAY + OVER + e0[k])
    k = np.array([N - 2, N])
    at_most(e[k], 12 - e0[k])
    at_most(-e[k], 12 + e0[k])
    steps = np.diff(np.eye(knots), axis=0)
    at_most(steps, JERK * KNOT * T)
    at_most(-steps, JERK * KNOT * T)
    ends = np.zeros((4, knots + 1))
    ends[0, :-1], ends[1, :-1], ends[2, 0], ends[3, -2] = way[N], speed[N + 1], 1, 1
    best = linprog(
        np.r_[np.zeros(knots), 1], np.vstack(rows), np.concatenate(bounds), ends,
        [WAY, 0, 0, 0], bounds=[(None, None)] * knots + [(0, None)],
    )  # fmt: skip
    return np.clip((way @ best.x[:-1])[: N + 1] / WAY, 0, 1)


def smooth(x: np.ndarray, width: int) -> np.ndarray:
    window = np.hanning(width + 2)[1:-1]
    padded = np.pad(x.astype(float), width, mode="edge")
    return np.convolve(padded, window / window.sum(), "same")[width:-width]


def learn(count: np.ndarray, current: np.ndarray, plant: tuple[float, float]) -> np.ndarray:
    """What pushed the joint beyond its current and its viscous friction, from the move's begin."""
    speed = np.gradient(smooth(count, 25)) / T
    acts = np.r_[0, smooth(current, 15)[:-1]]
    speeding = smooth(np.gradient(speed) / T, 15)
    push = ((speeding + plant[1] * speed) / plant[0] - acts)[50:]
    push = np.r_[push, np.full(200, -FRICTION)]
    push[:25], push[470:] = -FRICTION, push[460:470].mean()
    return push


def main(rounds: int = 4) -> None:
    from mmcs import find, load, logcols, simulate

    table = find("puma560_coupled").with_name("arm_move.csv")
    law, plant = load("puma560_coupled", *SETS).params[0], (151.0, 1.5)
    push, best, least = np.full(700, -FRICTION), "", np.inf
    for turn in range(rounds):
        text = "share\n" + "".join(f"{share:.5f}\n" for share in plan(law, plant, push))
        table.write_text(text)
        log = simulate(load("puma560_coupled", *SETS)).log
        current, count, error = (
            logcols.column(log, 0, name)[:638] for name in ("current", "encoder", "error")
        )
        print(f"{turn}: current {current.min()} to {current.max()}, error {error.min()} to "
              f"{error.max()}")  # fmt: skip
        if abs(current).max() < least:
            best, least = text, abs(current).max()
        push = learn(count, current, plant)
    table.write_text(best)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
