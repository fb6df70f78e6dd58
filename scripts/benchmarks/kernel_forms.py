"""Results in rows, padded rows and blocks against Pinocchio; the regressor against memory; the engine's own cost."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import lwr_dyn
from benchmarks.kernel_limit import FORMS, kernel_call
from benchmarks.timing import head, paired, row
from lwr_dyn.checks.arm.model_laws import random_states
from lwr_dyn.dynamics.pinocchio_engine import pinocchio_model
from lwr_dyn.model.arm import Arm

IN_CACHE, MANY = 2048, 100_000


def mass_matrix_forms(arm: Arm, pairs: int) -> None:
    """B in every form against crba state by state, inside the cache and beyond."""
    model = pinocchio_model(arm)
    data = model.createData()
    for count in (IN_CACHE, MANY):
        states = random_states(arm, count, seed=2).q

        def crba(states: np.ndarray = states) -> None:
            for q in states:
                pin.crba(model, data, q)

        head(f"{arm.name}: B of {count} states, one thread (time for all)")
        for layout, structure in FORMS:
            batch = lwr_dyn.batch_dynamics(arm, layout=layout, structure=structure)
            mine, other, ratio = paired(kernel_call(batch, "mass_matrix", arm, count), crba, pairs, 3)
            note = f"{1 / ratio:.1f} times faster, {mine / count * 1e9:.1f} ns a state"
            row(f"mass_matrix, {layout}, {structure}", "crba in a loop", (mine, other, ratio), note)


def regressor_and_memory(arm: Arm, pairs: int) -> None:
    """The regressor against setting as much memory as its own result takes."""
    for count in (IN_CACHE // 2, 10_000):
        head(f"{arm.name}: regressor of {count} states against memset of its result")
        for layout, structure in FORMS:
            batch = lwr_dyn.batch_dynamics(arm, layout=layout, structure=structure)
            call, out = kernel_call(batch, "torque_regressor", arm, count), batch.form("torque_regressor").empty(count)
            as_much = np.empty(len(out) * out.strides[0], dtype=np.uint8)

            def memset(memory: np.ndarray = as_much) -> None:
                memory.fill(0)

            result = paired(call, memset, pairs, 3)
            note = f"{result[0] / count * 1e9:.0f} ns a state"
            row(f"torque_regressor, {layout}, {structure}", "memset", result, note)


def engine_cost(arm: Arm, pairs: int) -> None:
    """`engine="kernels"` against the kernel alone, which writes into memory that is there."""
    engine, batch = lwr_dyn.dynamics_of(arm, engine="kernels"), lwr_dyn.batch_dynamics(arm)
    states = random_states(arm, MANY, seed=2)
    x = (states.q, states.dq, states.ddq)
    head(f'{arm.name}: engine="kernels" on {MANY} states against its kernels (B and C: the rest is new memory)')
    for function, arguments in (
        ("inverse_dynamics", x), ("forward_dynamics", x), ("bias_torque", x[:2]), ("gravity_vector", x[:1]),
        ("mass_matrix", x[:1]), ("coriolis_matrix", x[:2]),
    ):  # fmt: skip
        method, kernel = getattr(engine, function), kernel_call(batch, function, arm, MANY)
        row(function, "kernel alone", paired(lambda f=method, a=arguments: f(*a), kernel, pairs, 1))


def kernel_forms(arm: Arm, pairs: int) -> None:
    """All three."""
    mass_matrix_forms(arm, pairs)
    regressor_and_memory(arm, pairs)
    engine_cost(arm, pairs)
