# SPDX-License-Identifier: Apache-2.0
"""The machine as a Gymnasium environment: the checker's rules, seeds, vectors; make learn-test."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from mmcs_gymnasium import ID

from mmcs import InputError

pytestmark = pytest.mark.req("DRV-4")
SHORT = {"episode_steps": 60}


def episode(env, seed: int, policy) -> tuple[list[np.ndarray], list[float]]:
    observation, _ = env.reset(seed=seed)
    seen, rewards, over = [observation], [], False
    while not over:
        observation, reward, terminated, truncated, _ = env.step(policy(observation))
        seen.append(observation)
        rewards.append(reward)
        over = terminated or truncated
    return seen, rewards


def test_the_checker_is_content():
    env = gymnasium.make(ID, **SHORT)
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


def pd(observation: np.ndarray) -> np.ndarray:
    """The loop that a user would close: distance and speed of each axis."""
    axes = len(observation) // 3
    return np.clip(6 * observation[:axes] - 0.25 * observation[axes : 2 * axes], -1, 1)


def test_the_lines_of_the_page():
    import gymnasium

    env = gymnasium.make("mmcs_gymnasium:MMCS/Reach-v0", scenario="puma560", step_intervals=5)
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    assert observation in env.observation_space
    env.close()


def test_the_same_seed_is_the_same_episode_after_any_other():
    env = gymnasium.make(ID, **SHORT)
    first, _ = episode(env, 7, pd)
    episode(env, 8, lambda o: -np.ones(1))
    again, _ = episode(env, 7, pd)
    other, _ = episode(env, 9, pd)
    env.close()
    assert np.array_equal(first, again) and not np.array_equal(first, other)


@pytest.mark.req("SRV-6")
def test_a_loop_that_works_is_worth_more_than_none():
    env = gymnasium.make(ID)
    seen, rewards = episode(env, 3, pd)
    _, idle = episode(env, 3, lambda o: np.zeros(1))
    env.close()
    assert abs(seen[0][0]) > 0.2 and abs(seen[-1][0]) < 0.1, "it reaches the target"
    assert sum(rewards) > sum(idle) / 2


def test_two_at_once():
    envs = gymnasium.make_vec(ID, num_envs=2, vectorization_mode="async", **SHORT)
    observations, _ = envs.reset(seed=5)
    assert observations.shape == (2, 3) and observations[0][0] != observations[1][0]
    for _ in range(5):
        observations, rewards, *_ = envs.step(np.zeros((2, 1), np.float32))
    assert rewards.shape == (2,)
    envs.close()


def test_arm_and_mistakes():
    env = gymnasium.make(ID, scenario="puma560", **SHORT)
    observation, info = env.reset(seed=1)
    assert observation.shape == (18,) and len(info["counts"]) == 6
    env.step(env.action_space.sample() * 0.1)
    env.close()
    with pytest.raises(InputError, match="episode_steps"):
        gymnasium.make(ID, episode_steps=0)
