"""One run of many again, whole, by `simulate`: the plant, the law and the noise that the kernel had."""

from collections.abc import Mapping

import numpy as np

from lwr_dyn.codegen.rollouts.bodies_of_runs import arm_of_run
from lwr_dyn.codegen.rollouts.counted_encoder import CountedEncoder
from lwr_dyn.codegen.rollouts.laws.protocol import LawForm
from lwr_dyn.codegen.rollouts.loop_setup import LoopSetup
from lwr_dyn.codegen.rollouts.smooth_friction import friction_function, friction_table
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.sensors import Encoder
from lwr_dyn.simulation.simulate import simulate

DEFAULT_ENCODER = Encoder()
"""What resolution and noise a run are put into where no encoder was given: its cut-off counts."""


def simulated_run(setup: LoopSetup, row: Mapping[str, Array], number: int, form: LawForm | None = None) -> Run:
    """A run by `simulate`.

    Parameters
    ----------
    setup : LoopSetup
    row : mapping
        One run's parameters by the names of `run_parameters.parameter_shapes`.
    number : int
        Of the run, for the noise.
    form : LawForm, optional
        Where gains or the law's model are among the parameters: it makes the controller. Without it, the setup's
        controller runs, and these parameters are not looked at.

    Raises
    ------
    DivergenceError, OptionError
        As `simulate`.
    """
    plant = arm_of_run(setup.plant, row)
    friction = None
    if setup.friction == "smooth":
        table = row.get("friction")
        table = friction_table(setup.plant.friction_models()) if table is None else table.reshape(5, plant.n)
        friction = friction_function(table, setup.friction_width)
    controller = setup.controller
    if form is not None and any(name in form.parameters or name.startswith("model_") for name in row):
        values = {name: row.get(name, value) for name, value in form.values().items()}
        controller = form.controller(arm_of_run(setup.arm, row, "model_"), values)
    return simulate(
        setup.arm, controller, setup.references[int(row.get("reference", 0))], rate=setup.rate,
        substeps=setup.substeps, plant=plant, friction="none" if friction is None else friction,
        encoder=encoder_of_run(setup, row, number), saturate=setup.saturate, position_limits=setup.position_limits,
        allow_unphysical=True, seed=setup.seed, delay=int(row.get("delay", setup.delay)), duration=setup.duration,
        q0=row.get("q0"), dq0=row.get("dq0"), progress=lambda share: None,
    )  # fmt: skip


def encoder_of_run(setup: LoopSetup, row: Mapping[str, Array], number: int) -> CountedEncoder | None:
    """The encoder of a run with its noise; None for the true state."""
    if setup.encoder is None and not {"resolution", "noise"} & row.keys():
        return None
    base = setup.encoder or DEFAULT_ENCODER
    resolution, noise = (float(np.asarray(row.get(name, getattr(base, name)))) for name in ("resolution", "noise"))
    return CountedEncoder(resolution, noise, base.cutoff_hz, run=number)
