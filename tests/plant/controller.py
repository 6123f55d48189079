"""A plain ideal controller for tests of the plant: computed torque on true signals, one move at a time. No part of the
emulator."""

import math

import numpy as np
from cmrc._core import plant

LATCH = 125_000_000
SERVO = 8 * LATCH
COORDINATES = [0, 1, 2, 3, 6]
AMONG_THEM = np.ix_(COORDINATES, COORDINATES)


class Crane:
    """Drives a dock's crane by joint-space quintics with computed torque, every millisecond, or less often where that
    is enough: the controller takes four times as long as the plant."""

    def __init__(self, dock: plant.Dock, t: int = 0, period_ms: int = 1):
        self.dock, self.t, self.period_ms = dock, t, period_ms
        config = dock.config
        self.parameters = config.crane
        self.drives = list(config.crane.drives)
        self.model = plant.Crane(config.crane)
        self.reference = np.array(dock.signal.q)
        self.integral = np.zeros(5)
        dock.enable_drives(0x1F, t)

    def gravity(self, full, mass):
        forces = self.model.gravity(full, mass)
        return [forces[k] for k in COORDINATES]

    def tick(self, q_ref, qd_ref, qdd_ref):
        s = self.dock.signal
        q, qd = np.array(s.q), np.array(s.qd)
        mass = self.dock.payload_mass
        inertia = 1.25e5 + (mass - 10e3) * (12.192**2 + 2.438**2) / 12
        full = np.zeros(7)
        error, rate = q_ref - q, qd_ref - qd
        self.integral += error * (1e-3 * self.period_ms)
        wish = qdd_ref + 9.0 * error + 6.0 * rate + 4.0 * self.integral
        full[COORDINATES] = q
        force = np.array(self.model.mass_matrix(full, mass, inertia))[AMONG_THEM] @ wish
        hold = self.gravity(full, mass)
        if s.contact:  # what the ground carries, the rope does not
            hold[3] = max(hold[3], -s.tension)
            hold[2] = self.gravity(full, max(s.tension, 0.0) / 9.81)[2]
        for j, drive in enumerate(self.drives):
            torque = (force[j] + hold[j] + self.model.friction(j, qd_ref[j])) / (drive.gear * drive.efficiency)
            code = round(torque / drive.maximum_torque * 2047)
            self.dock.set_torque_code(j, max(-2047, min(2047, code)), self.t)
        self.t += self.period_ms * SERVO
        self.dock.advance_to(self.t)

    def hold(self, seconds):
        for _ in range(round(seconds * 1000 / self.period_ms)):
            self.tick(self.reference, np.zeros(5), np.zeros(5))

    def move(self, target, seconds, stop=lambda: False):
        start, target = self.reference, np.array(target, float)
        for i in range(round(seconds * 1000 / self.period_ms)):
            u = (i + 1) * self.period_ms / (seconds * 1000)
            d = target - start
            self.reference = start + d * (10 * u**3 - 15 * u**4 + 6 * u**5)
            self.tick(
                self.reference,
                d * (30 * u**2 - 60 * u**3 + 30 * u**4) / seconds,
                d * (60 * u - 180 * u**2 + 120 * u**3) / seconds**2,
            )
            if stop():
                return

    def pose(self, x, y, z, yaw=0.0):
        q = plant.inverse_kinematics(self.parameters, plant.CranePose(0.0, x, y, z, yaw))
        return [q[k] for k in COORDINATES]


def quiet_dock(**changes) -> plant.DockConfig:
    """The default dock with the crane waiting above its first container and no sensor noise."""
    config = plant.default_dock()
    config.home = plant.CranePose(
        0.0, *changes.get("above", (12.7, 24.0)), changes.get("z", 7.5), changes.get("yaw", 0.0)
    )
    return config


def degrees(value):
    return math.degrees(value)
