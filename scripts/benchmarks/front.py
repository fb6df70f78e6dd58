"""What a person calls: one state and one loop, beside Pinocchio called raw, dynibo and MuJoCo's loop."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pinocchio as pin

import lwr_dyn
from benchmarks.dynamics_peers import mujoco_loop
from benchmarks.timing import Call, head, installed, paired, row
from lwr_dyn.control.paper_laws import InverseDynamics

SAMPLES = 14000


def front(pairs: int) -> None:
    """One state by every engine, then 14 s of IST at 1 kHz by every loop; none of the peers checks its arguments."""
    arm = lwr_dyn.load("lwr4plus")
    _one_state(arm, pairs)
    if installed("mujoco"):
        _one_loop(arm, pairs)


def _given(name: str, states: np.ndarray) -> tuple[np.ndarray, ...]:
    return tuple(states[: 1 if name == "mass_matrix" else 3])


def _one_state(arm: lwr_dyn.Arm, pairs: int) -> None:
    kernels, usual = lwr_dyn.dynamics_of(arm, "kernels"), lwr_dyn.dynamics_of(arm)
    states = np.random.default_rng(0).uniform(-1.0, 1.0, (3, arm.n))
    model, data = usual.ungated.model, usual.ungated.data
    raw = {"mass_matrix": pin.crba, "inverse_dynamics": pin.rnea, "forward_dynamics": pin.aba}
    head("One state by engine kernels (one call from Python; a new array, arguments checked)")
    for name, theirs in raw.items():
        given = _given(name, states)
        ours = partial(getattr(kernels, name), *given)
        row(name, "pin raw", paired(ours, partial(theirs, model, data, *given), pairs, 20000))
        row(name, "engine pinocchio", paired(ours, partial(getattr(usual, name), *given), pairs, 20000))
    if installed("dynibo"):
        _beside_dynibo(arm, states, kernels, pairs)


def _beside_dynibo(arm: lwr_dyn.Arm, states: np.ndarray, kernels: lwr_dyn.Dynamics, pairs: int) -> None:
    """It reads no rotors, and its gravity is 9.80665 m/s^2: compared with ours without rotors, in that gravity."""
    import dynibo

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "arm.urdf")
        path.write_text(lwr_dyn.urdf_text(arm), encoding="utf-8")
        robot = dynibo.Robot.from_urdf(str(path))
    chain = replace(arm.chain, gravity=arm.chain.gravity * (9.80665 / np.linalg.norm(arm.chain.gravity)))
    bare = lwr_dyn.dynamics_of(replace(arm, chain=chain), "kernels", rotors="none")
    for name in ("mass_matrix", "inverse_dynamics", "forward_dynamics"):
        given = _given(name, states)
        ours, theirs = partial(getattr(kernels, name), *given), partial(getattr(robot, name), *given)
        want = getattr(bare, name)(*given)
        off = float(np.abs(np.reshape(theirs(), want.shape) - want).max())
        note = f"differ by {off:.1e} without rotors, with its gravity"
        row(name, f"dynibo {version('dynibo')}", paired(ours, theirs, pairs, 20000), note)


def _one_loop(arm: lwr_dyn.Arm, pairs: int) -> None:
    reference = lwr_dyn.reference("ist", arm)
    motion = reference.sample(np.arange(SAMPLES) / 1000.0)
    kernels = lwr_dyn.dynamics_of(arm, "kernels")
    law = InverseDynamics(lwr_dyn.dynamics_of(arm), 2500.0, 100.0)
    fast = InverseDynamics(kernels, 2500.0, 100.0)
    theirs = mujoco_loop(arm, motion, "RK4")
    ways: dict[str, Call] = {
        "simulate": lambda: lwr_dyn.simulate(arm, law, reference),
        'simulate, engine="kernels" for law and plant': lambda: lwr_dyn.simulate(arm, fast, reference, engine=kernels),
        'simulate, loop="compiled"': lambda: lwr_dyn.simulate(arm, law, reference, loop="compiled"),
        "rollouts(runs=1)": lambda: lwr_dyn.rollouts(arm, law, reference, runs=1),
    }
    head("Closed loop, inverse dynamics, 14 s at 1 kHz, RK4 (time for the whole run; simulate with record and audit)")
    for name, ours in ways.items():
        row(name, "mujoco RK4", paired(ours, theirs, pairs, 1))
