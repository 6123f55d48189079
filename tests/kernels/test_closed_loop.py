"""The kernels, emulated, in closed loop around the plant's crane with sway, drives, friction, sensors as they are."""

from __future__ import annotations

import math
import random

import pytest
import reference as ref
from cmrc import _core
from cmrc_test import plant as parts
from harness import Dsp

SETTLED, RAMP_DONE = 0x100000, 0x200000
REFRESH, POINT_TICKS, SERVO_TICKS = 8000, 64, 16  # a servo at 500 Hz halves the test's time; the harder case


class Crane:
    """Host rules, sensors and latches, reduced to one DSP that is never late. Channels are the order of encoders and
    drives on the bus."""

    kernels = ("trajectory_crane", "inverse_crane", "torque", "pid")
    channels = (0, 1, 2, 3, 4)
    scales, u_max = ref.COUNTS, ref.U_MAX  # by channel
    parameters = staticmethod(_core.plant.CraneParameters)
    processor = Dsp

    def __init__(self, home: list[float], payload: float) -> None:
        plant = _core.plant
        parameters = self.parameters()
        self.equations, self.motion = plant.Crane(parameters), parts.CraneMotion(parameters)
        self.state, self.inputs = plant.CraneState(), parts.CraneInputs()
        q = plant.inverse_kinematics(parameters, plant.CranePose(0, *home))
        self.state.q, self.state.qd = q, [0.0] * 7
        self.inputs.payload = (payload, ref.I_SPREADER + ref.I_PER_KG * (payload - ref.M_SPREADER))
        self.noise = random.Random(1)
        self.sway = [0, 0]
        self.tick, self.planned, self.result, self.leg_ended = 0, 0, 0, True
        dsp = self.dsp = self.processor()
        dsp.put("CR_POINT_PERIOD", POINT_TICKS / REFRESH)
        dsp.put("CR_SERVO_PERIOD", SERVO_TICKS / REFRESH)
        dsp.put("CR_POINT_TICKS", POINT_TICKS)
        dsp.put("CR_SERVO_TICKS", SERVO_TICKS)
        dsp.hang(round(payload))
        dsp.put("CR_HOME", *home)
        dsp.put("CR_RAMP_BASE", 0.0, 0.0)
        total = self.counts()
        dsp.put("CR_ENCODER_TOTAL", *total)
        dsp.put("CR_ENCODER_LAST", *(c & 0xFFFFFF for c in total))

    def counts(self) -> list[int]:
        joints = [*self.state.q[:4], self.state.q[6]]
        return [math.floor(joints[j] * c) for j, c in zip(self.channels, self.scales, strict=True)]

    def go(self, vias: list[list[float]]) -> None:
        self.dsp.put("CR_LEG", 1)
        self.dsp.put("CR_ROUTE_COUNT", len(vias), offset=1)
        self.dsp.put("CR_ROUTE", *(x for via in vias for x in via))
        self.leg_ended = False

    def ramp(self, base: float, delta: float, seconds: float) -> None:
        self.dsp.put("CR_RAMP_BASE", base, delta)
        self.dsp.put("CR_RAMP_START", self.tick)
        self.dsp.put("CR_RAMP_TICKS", int(seconds * REFRESH))

    def step(self) -> None:
        dsp = self.dsp
        if not self.leg_ended and self.planned - (self.result & 0xFFFF) < 2:
            self.leg_ended = bool(dsp.run(self.kernels[0], self.planned)[0])
            dsp.run(self.kernels[1], self.planned)
            self.planned += 1
        for j, c in enumerate(self.counts()):
            dsp.device("ENCODER", c & 0xFFFFFF, offset=j)
        if self.tick % 80 == 0:
            lsb = math.radians(10) / 2048
            self.sway = [
                math.floor((self.state.q[4 + i] + self.noise.gauss(0, math.radians(0.02))) / lsb) for i in range(2)
            ]
        for i in range(2):
            dsp.device("SWAY_ALPHA", self.sway[i], offset=i)
        dsp.run(self.kernels[2], tick=self.tick)
        self.result = dsp.run(self.kernels[3], tick=self.tick)[0]
        self.inputs.braked = [dsp.device_word("DRIVE_ENABLE") != 0x1F] * 5
        torques = [dsp.device_word("DRIVE_TORQUE", offset=j) / 2047 * u for j, u in enumerate(self.u_max)]
        self.inputs.command = [torques[self.channels.index(j)] for j in range(5)]
        self.motion.advance(self.state, self.inputs, SERVO_TICKS / REFRESH)
        self.tick += SERVO_TICKS

    def seconds(self) -> float:
        return self.tick / REFRESH

    def run_until(self, done: int, limit: float) -> float:
        """Steps until the result has bit `done` (and the leg is over); returns the seconds that took."""
        start = self.seconds()
        while True:
            self.step()
            over = self.leg_ended and self.planned == self.result & 0xFFFF
            if over and self.result & done:
                return self.seconds() - start
            assert self.seconds() - start < limit

    def load(self) -> list[float]:
        return list(self.equations.payload_position(self.state.q))


def test_a_leg_and_a_ramp_end_where_they_should_without_sway() -> None:
    crane = Crane([14.0, 15.0, 12.0, 0.0], 40e3)
    target = [10.0, 19.0, 10.5, 0.1]
    crane.go([target])
    leg = ref.Leg([14.0, 15.0, 12.0, 0.0], [target])
    taken = crane.run_until(SETTLED, leg.total() + 4)
    assert taken == pytest.approx(leg.total() + ref.SETTLE_TIME, abs=1.5)
    assert crane.load() == pytest.approx(target[:3], abs=0.04)  # capture window: 0.15 m
    worst = 0.0
    crane.ramp(0.0, 1.0, 8.0)
    crane.run_until(RAMP_DONE, 9)
    for _ in range(250):
        crane.step()
        x, y, _ = crane.load()
        worst = max(worst, math.hypot(x - target[0], y - target[1]))
    assert worst < 0.04
    assert crane.load()[2] == pytest.approx(target[2] - 1.0, abs=0.01)


def test_a_pushed_load_comes_to_rest_in_two_swings() -> None:
    """Sway damping: unaided, the plant's 0.7 % would leave 92 % of the amplitude after two periods."""
    crane = Crane([12.0, 16.0, 14.0, 0.0], 30e3)
    for _ in range(20):
        crane.step()
    qd = list(crane.state.qd)
    qd[4], qd[5] = 0.010, -0.008
    crane.state.qd = qd
    period = 2 * math.pi * math.sqrt(crane.state.q[3] / 9.81)
    for _ in range(int(2 * period * REFRESH / SERVO_TICKS)):
        crane.step()
    speed = math.hypot(*crane.state.qd[4:6]) + math.hypot(*crane.state.q[4:6]) * 2 * math.pi / period
    assert speed < 0.25 * math.hypot(0.010, 0.008)
