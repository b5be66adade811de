# SPDX-License-Identifier: Apache-2.0
"""Whether an arm can be integrated in steps of 50 us (sim/plant), and the values that would do.

With the motors' own inertias B, the springs K and the joint side's mass matrix M (rotors of rigid
joints included), the couplings swing with the eigenvalues of K (1/B + M^-1), and their damping D
decays with those of D (1/B + M^-1). Both are taken over many poses within the stops."""

import math

import numpy as np

STEP_S = 50e-6
POSES = 200
MOST_SWING, MOST_DECAY = 0.25, 0.5


def is_body(inertia: list[float]) -> bool:
    """xx yy zz xy yz xz about the centre of mass: no axis may have less than none."""
    xx, yy, zz, xy, yz, xz = inertia
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return bool(np.linalg.eigvalsh(matrix)[0] >= -1e-9 * max(np.trace(matrix), 1e-300))


def has_mass_distribution(inertia: list[float]) -> bool:
    """Where the mass lies: its second moments, which no body has less than none of either. They are
    what makes the greatest moment of inertia at most the sum of the other two."""
    half = sum(inertia[:3]) / 2
    return is_body([half - own for own in inertia[:3]] + [-product for product in inertia[3:]])


def link_frame(alpha: float, a: float, d: float, angle: float) -> np.ndarray:
    """Of a link in that of the one before (Denavit-Hartenberg)."""
    c, s = math.cos(angle), math.sin(angle)
    ca, sa = math.cos(alpha), math.sin(alpha)
    return np.array([
        [c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1],
    ])  # fmt: skip


def mass_matrix(links, q) -> np.ndarray:
    """By the Jacobians of the links' centres of mass."""
    frame, n = np.eye(4), len(links)
    axes, origins, mass = [], [], np.zeros((n, n))
    for k, (link, angle) in enumerate(zip(links, q, strict=True)):
        axes.append(frame[:3, 2].copy())
        origins.append(frame[:3, 3].copy())
        frame = frame @ link_frame(link.alpha, link.a, link.d, angle + link.theta0)
        turn = frame[:3, :3]
        centre = frame[:3, 3] + turn @ np.array(link.com)
        xx, yy, zz, xy, yz, xz = link.inertia
        inertia = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
        spin = np.array(axes).T
        move = np.array([np.cross(z, centre - p) for z, p in zip(axes, origins, strict=True)]).T
        mass[: k + 1, : k + 1] += link.mass * move.T @ move + spin.T @ inertia @ spin
    return mass


def stiff_joints(robot) -> list[tuple[str, float]]:
    """(key, the most that it may be) of a stiffness or damping that is too much with its load."""
    flexible = [n for n, motor in enumerate(robot.axis) if motor.stiffness > 0]
    if not flexible:
        return []
    chance = np.random.default_rng(1989)
    stops = [(m.stop_lo, m.stop_hi) if m.stop_lo < m.stop_hi else (-math.pi, math.pi)
             for m in robot.axis]  # fmt: skip
    poses = [[m.angle0 for m in robot.axis]]
    poses += [[chance.uniform(lo, hi) for lo, hi in stops] for _ in range(POSES - 1)]
    rotor = [0.0 if m.stiffness else m.gear**2 * m.rotor_inertia for m in robot.axis]
    own = np.diag([1 / (robot.axis[n].rotor_inertia * robot.axis[n].gear ** 2) for n in flexible])
    worst: dict[str, float] = {}
    for pose in poses:
        mass = mass_matrix(robot.link, pose) + np.diag(rotor)
        values = np.linalg.eigvalsh(mass)
        if not values[0] > 1e-12 * values[-1]:
            return [(f"axis.{flexible[-1]}.stiffness", 0.0)]
        soft = own + np.linalg.inv(mass)[np.ix_(flexible, flexible)]
        for name, most in (("stiffness", MOST_SWING / STEP_S**2), ("damping", MOST_DECAY / STEP_S)):
            roots = np.sqrt([getattr(robot.axis[n], name) for n in flexible])
            values, vectors = np.linalg.eigh(roots[:, None] * soft * roots)
            if values[-1] > most:
                guilty = flexible[int(np.abs(vectors[:, -1]).argmax())]
                limit = getattr(robot.axis[guilty], name) * most / values[-1]
                key = f"axis.{guilty}.{name}"
                worst[key] = min(limit, worst.get(key, math.inf))
    return list(worst.items())
