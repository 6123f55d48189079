"""Error against cost of the crane by itself, by order and tolerance: what the default of ``Crane`` and ``CraneEnv`` is
chosen by (docs/plant-python.md).

python tests/plant/benchmarks/tolerance.py            # the table of errors, the same on every machine
python tests/plant/benchmarks/tolerance.py --speed    # processor time, beside MuJoCo on a comparable tree
"""

import argparse
import time

import numpy as np
from cmrc.plant import ACTUATED, Agv, Crane, CraneEnv

STEP, STEPS = 0.01, 1000
HOME = (0.0, 12.0, 16.0, 14.0, 0.0)
TARGET = (14.0, 18.0, 10.0)


def actions() -> np.ndarray:
    """Shares of the largest torques that keep the crane near its home for 10 s: what holds it, and pushes that change
    at each step."""
    crane = Crane(load_mass=20e3, home=HOME)
    hold = np.zeros(5)
    for _ in range(3):
        crane.reset(crane.state.q, torques=hold)
        hold = hold - np.linalg.solve(
            crane.linearize().A[7:14, 14:][list(ACTUATED)], crane.acceleration()[list(ACTUATED)]
        )
    return hold / crane.maximum_torques + np.random.default_rng(1).normal(size=(STEPS, 5)) * 0.05


def path(shares: np.ndarray, **config: float) -> np.ndarray:
    crane = Crane(load_mass=20e3, home=HOME, **config)
    states = []
    for row in shares * crane.maximum_torques:
        crane.step(row, STEP)
        states.append(crane.state.q)
    assert not crane.events
    return np.array(states)


def errors(shares: np.ndarray) -> None:
    drives = Crane().parameters.drives
    count = np.array([2.0 * np.pi / 16384 / drive.gear for drive in drives])
    exact = path(shares, tolerance=1e-12, order=5)
    print("| order | tolerance | largest error of a joint, counts | of a sway angle, codes |")
    print("|---|---|---|---|")
    for order in (3, 4, 5):
        for tolerance in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
            off = np.abs(path(shares, tolerance=tolerance, order=order) - exact).max(axis=0)
            print(
                f"| {order} | {tolerance:.0e} | {(off[list(ACTUATED)] / count).max():.1e} | {off[4:6].max() / np.radians(10.0) * 2048:.1e} |"
            )


def steps_per_second(shares: np.ndarray, repeat: int = 5, **config: float) -> float:
    best = np.inf
    for _ in range(repeat):
        env = CraneEnv(TARGET, dt=STEP, load_mass=20e3, home=HOME, **config)
        env.reset(seed=0)
        start = time.process_time()
        for row in shares:
            env.step(row)
        best = min(best, time.process_time() - start)
    return len(shares) / best


TREE = """<mujoco><option timestep="0.001" integrator="RK4" gravity="0 0 -9.81"/><worldbody>
<body pos="0 0 22"><joint name="s" type="slide" axis="1 0 0" armature="4e4"/><inertial pos="0 0 0" mass="180000" diaginertia="1 1 1"/>
<body><joint name="psi" type="hinge" axis="0 0 1" armature="7.5e6"/><inertial pos="-7 0 0" mass="60000" diaginertia="4e6 4e6 4e6"/>
<body pos="2.5 0 0"><joint name="phi" type="hinge" axis="0 -1 0" armature="2e8"/><inertial pos="14 0 0" mass="22000" diaginertia="1 1.88e6 1.88e6"/>
<body pos="32 0 0"><joint name="alpha" type="hinge" axis="0 -1 0"/><joint name="beta" type="hinge" axis="1 0 0"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<body pos="0 0 -14"><joint name="l" type="slide" axis="0 0 -1" armature="2.6e5"/><joint name="kappa" type="hinge" axis="0 0 1" armature="1e5"/>
<inertial pos="0 0 0" mass="30000" diaginertia="1e5 5e5 5e5"/></body></body></body></body></body></worldbody>
<actuator><motor joint="s"/><motor joint="psi"/><motor joint="phi"/><motor joint="l"/><motor joint="kappa"/></actuator></mujoco>"""


def mujoco_steps_per_second(repeat: int = 5) -> float:
    """The same tree of seven freedoms with motors at the joints, RK4 of 1 ms, ten of them for a step; no friction, lag
    or events."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(TREE)
    best = np.inf
    for _ in range(repeat):
        data = mujoco.MjData(model)
        start = time.process_time()
        for _ in range(STEPS):
            mujoco.mj_step(model, data, nstep=10)
        best = min(best, time.process_time() - start)
    return STEPS / best


def seconds_of(work, repeat: int = 5) -> float:
    """Least processor time of several, s."""
    least = np.inf
    for _ in range(repeat):
        start = time.process_time()
        work()
        least = min(least, time.process_time() - start)
    return least


def million_steps_of_crane(steps: int = 20_000) -> float:
    """Processor time of a million steps of 1 ms with torques that change by 1 % at each, s; each step a call from
    Python."""
    crane, torques = Crane(), np.array([40.0, 60.0, -30.0, 50.0, 5.0])

    def work() -> None:
        for n in range(steps):
            crane.step(torques * (1.0 + 0.01 * (n % 2)), 1e-3)

    return seconds_of(work) * 1e6 / steps


def million_steps_of_mujoco(steps: int = 20_000) -> float:
    """The same of MuJoCo's tree, RK4."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(TREE)
    data, torques = mujoco.MjData(model), np.array([40.0, 60.0, -30.0, 50.0, 5.0])

    def work() -> None:
        for n in range(steps):
            data.ctrl[:] = torques * (1.0 + 0.01 * (n % 2))
            mujoco.mj_step(model, data)

    return seconds_of(work) * 1e6 / steps


def second_of_agv(seconds: float = 20.0) -> float:
    """Processor time of a simulated second of an AGV that drives a curve, ms."""
    agv = Agv()
    return seconds_of(lambda: agv.step(1.0, 0.1, -0.05, seconds)) / seconds * 1e3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--speed", action="store_true", help="measure the steps per second of processor time")
    arguments = parser.parse_args()
    shares = actions()
    if not arguments.speed:
        return errors(shares)
    for order in (3, 4, 5):
        for tolerance in (1e-5, 1e-6, 1e-7, 1e-8):
            print(
                f"CraneEnv, order {order}, tolerance {tolerance:.0e}: {steps_per_second(shares, order=order, tolerance=tolerance):.0f} steps/s"
            )
    print(f"CraneEnv unchanged: {steps_per_second(shares):.0f} steps/s")
    print(f"MuJoCo: {mujoco_steps_per_second():.0f} steps/s")
    print(
        f"a million steps of 1 ms, other torques at each: Crane {million_steps_of_crane():.1f} s, MuJoCo {million_steps_of_mujoco():.1f} s"
    )
    print(f"a simulated second of an AGV: {second_of_agv():.2f} ms")


if __name__ == "__main__":
    main()
