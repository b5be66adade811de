# SPDX-License-Identifier: Apache-2.0
"""The machine as a Gymnasium environment: torque in, encoders out, the whole loop between.

    env = gymnasium.make("mmcs_gymnasium:MMCS/Reach-v0", scenario="lab500")
    envs = gymnasium.make_vec("MMCS/Reach-v0", num_envs=4, vectorization_mode="async")

What acts is a user's program that closes the loop itself (§1.3.1): each step writes torques
through the driver, lets some servo intervals pass, and reads what the driver published. Importing
this module registers the environment.
"""

try:
    import gymnasium
except ImportError:
    raise ImportError("Gymnasium is not installed; pip install './bridges[gymnasium]'") from None
import numpy as np
from gymnasium import spaces

from mmcs import InputError, Machine, load

ID = "MMCS/Reach-v0"
CLIP = 10.0  # of observations, in their units


class ReachEnv(gymnasium.Env):
    """Bring every axis to a target, drawn anew for each episode, and hold it.

    Action: torque of each axis, -1 to 1 of its current limit. Observation, three numbers an axis:
    target - position and speed, in ranges and ranges per second, and the last action. Reward: minus
    the mean square of the first, less a tenth of that of the actions. terminated: the driver has
    shut the machine down (a limit, PANIC).
    """

    metadata = {"render_modes": []}  # noqa: RUF012  (as the base class has it)

    def __init__(self, scenario: str = "lab500", step_intervals: int = 5, episode_steps: int = 200,
                 reach_counts: int = 500, render_mode: str | None = None):  # fmt: skip
        """reach_counts: targets are drawn from so far to either side; it is the range above."""
        for name, value in (("step_intervals", step_intervals), ("episode_steps", episode_steps),
                            ("reach_counts", reach_counts)):  # fmt: skip
            if not isinstance(value, int) or value < 1:
                raise InputError.one(name, "", value, "must be a whole number of at least 1")
        self.render_mode = render_mode
        self.setup = load(scenario)
        self.axes, self.reach = self.setup.axes, reach_counts
        self.step_intervals = step_intervals
        self.step_s = step_intervals * self.setup.scenario.interval_us * 1e-6
        self.episode_steps = episode_steps
        self.limits = np.array([values["ilim"] for values in self.setup.params])
        self.action_space = spaces.Box(-1.0, 1.0, (self.axes,), np.float32)
        self.observation_space = spaces.Box(-CLIP, CLIP, (3 * self.axes,), np.float32)
        self.machine = Machine(self.setup, mode="torque")
        self.start = self.machine.save()  # where every episode begins, to the bit

    def reset(self, *, seed: int | None = None, options: dict | None = None):
        super().reset(seed=seed)
        self.machine.restore(self.start)
        self.target = self.np_random.integers(-self.reach, self.reach, self.axes, endpoint=True)
        self.action = np.zeros(self.axes, np.float32)
        self.counts = self.machine.read()["encnow"]
        self.steps = 0
        return self._observe(np.zeros(self.axes)), self._info()

    def step(self, action):
        self.action = np.clip(np.asarray(action, np.float32), -1.0, 1.0)
        before = self.counts
        torques = np.rint(self.action * self.limits)
        self.counts = self.machine.step(torques, self.step_intervals)["encnow"]
        self.steps += 1
        observation = self._observe((self.counts - before) / self.step_s)
        error = (self.target - self.counts) / self.reach
        reward = -float(np.mean(error**2)) - 0.1 * float(np.mean(self.action**2))
        stopped = not self.machine.enabled
        return observation, reward, stopped, self.steps >= self.episode_steps, self._info()

    def _observe(self, speed: np.ndarray) -> np.ndarray:
        parts = (self.target - self.counts) / self.reach, speed / self.reach, self.action
        return np.clip(np.concatenate(parts), -CLIP, CLIP).astype(np.float32)

    def _info(self) -> dict:
        return {
            "counts": self.counts.copy(),
            "target": self.target.copy(),
            "time": self.machine.time,
        }

    def close(self) -> None:
        self.machine.close()


gymnasium.register(ID, entry_point="mmcs_gymnasium:ReachEnv")
