"""A crane as a gymnasium environment. A separate module, because importing gymnasium takes longer than importing all of
cmrc."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from cmrc.arguments import mapping, number
from cmrc.one_state import OneState
from cmrc.plant.arguments import numbers
from cmrc.plant.crane import ACTUATED, Array, Crane

try:
    import gymnasium
except ImportError:
    gymnasium = None


class _PlainBox:
    """The used part of gymnasium's Box, if that package is missing."""

    def __init__(self, low: float | Array, high: float | Array, shape: tuple[int, ...], dtype: DTypeLike) -> None:
        self.shape = shape
        self.dtype = np.dtype(dtype)
        self.low: Array = np.full(shape, low, dtype)
        self.high: Array = np.full(shape, high, dtype)
        self._random = np.random.default_rng(0)

    def seed(self, seed: int | None = None) -> None:
        self._random = np.random.default_rng(seed)

    def contains(self, x: Array) -> bool:
        return x.shape == self.shape and bool(np.all(x >= self.low) and np.all(x <= self.high))

    def sample(self) -> Array:
        """Uniform where bounded, normal where not."""
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        uniform = self._random.uniform(np.where(bounded, self.low, 0.0), np.where(bounded, self.high, 1.0))
        return np.where(bounded, uniform, self._random.normal(size=self.shape))


_Environment: Any = object if gymnasium is None else gymnasium.Env
_Box: Any = _PlainBox if gymnasium is None else gymnasium.spaces.Box


class CraneEnv(OneState, _Environment):  # type: ignore[misc]
    """A crane as an environment of gymnasium (a ``gymnasium.Env`` if that package is installed; it works in the same
    way without).

    Action: five shares of the maximum torque, -1 to 1. Observation: q, qd and the vector from the load to ``target``
    (17 numbers). Reward: minus the length of that vector in m and minus the sway in rad, times ``dt``. An episode
    terminates when the load is within 0.1 m of the target and slower than 0.05 m/s, or a drive has a fault; it is
    truncated after ``duration`` seconds. The same actions after ``reset`` with the same seed give the same numbers, bit
    for bit.
    """

    _second = "another one that is reset with the same seed takes the same steps"

    metadata: dict[str, list[str]] = {"render_modes": []}  # noqa: RUF012 (gymnasium's own form)
    render_mode: str | None = None

    def __init__(self, target: Sequence[float], dt: float = 0.01, duration: float = 60.0, **config: object) -> None:
        if not 0.0 < number("dt", dt, "a step in s") <= 60.0:
            raise ValueError(f"dt must be above 0, at most 60 s (got {dt})")
        if not number("duration", duration, "a duration in s") > 0.0:
            raise ValueError(f"duration must be positive (got {duration})")
        self.crane = Crane(config)
        self.target: Array = np.array(numbers("target (x, y, z)", target, 3))
        self.dt = dt
        self.duration = duration
        self._start = self.crane.snapshot()
        p = self.crane.parameters
        most = np.full(17, np.inf)
        least = -most
        for k, low, high in zip(ACTUATED, p.lower, p.upper, strict=True):
            least[k], most[k] = low, high
        self.action_space = _Box(-1.0, 1.0, shape=(5,), dtype=np.float64)
        """Five shares of ``crane.maximum_torques``: a Box of gymnasium, or one with low, high, shape, dtype, contains
        and sample."""
        self.observation_space = _Box(least, most, shape=(17,), dtype=np.float64)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, float] | None = None
    ) -> tuple[Array, dict[str, float]]:
        """Goes back to the start, with sway angles within ``options["sway"]`` rad, drawn from ``seed``; without a seed
        the sequence of draws continues, beginning with seed 0."""
        chosen = mapping("options", options, 'a dictionary, {"sway": 0.1},')
        if unknown := sorted(set(chosen) - {"sway"}):
            raise ValueError(f'reset has the option "sway", not {unknown}')
        if seed is not None or getattr(self, "_random", None) is None:
            self._random = np.random.default_rng(seed or 0)
        if gymnasium is not None:
            super().reset(seed=seed)
        self.crane.restore(self._start)
        most = number("sway", chosen.get("sway", 0.0), "an angle in rad")
        if not 0.0 <= most < np.radians(40.0):
            raise ValueError(f"the sway at the start must be 0 to 40 degrees (got {most} rad)")
        if most > 0.0:
            q = self.crane.state.q
            q[4:6] = self._random.uniform(-most, most, 2)
            self.crane.reset(q)
        return self._observe(), {}

    def step(self, action: Sequence[float] | Array) -> tuple[Array, float, bool, bool, dict[str, float]]:
        """Observation, reward, terminated, truncated, info (``way_m`` to the target, ``speed_m_s``)."""
        self.crane.step(np.array(numbers("an action", action, 5)) * self.crane.maximum_torques, self.dt)
        state = self.crane.state
        way = float(np.linalg.norm(self.crane.payload() - self.target))
        model = self.crane._core.model
        speed = float(np.linalg.norm(model.payload_velocity(state.q, state.qd)))
        there = way < 0.1 and speed < 0.05
        reward = -(way + float(np.abs(state.q[4:6]).sum())) * self.dt
        return (
            self._observe(),
            reward,
            there or bool(self.crane.faulted),
            self.crane._core.time >= round(self.duration * 1e12),
            {"way_m": way, "speed_m_s": speed},
        )

    def _observe(self) -> Array:
        state = self.crane.state
        observation: Array = np.concatenate([state.q, state.qd, self.target - self.crane.payload()])
        return observation
