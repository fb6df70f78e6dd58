"""The sampled loops of all controllers with given gains, for the command `gains`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from lwr_dyn.control.gains import Gains
from lwr_dyn.control.inverse_dynamics import tuned_inverse_dynamics
from lwr_dyn.control.linear_feedback import Linearised
from lwr_dyn.control.pd_gravity import PDGravity, tuned_pd_gravity
from lwr_dyn.control.pid import PID
from lwr_dyn.design.sampled_loop import Sampling
from lwr_dyn.design.sampled_stability import SampledStability, stability_in_box
from lwr_dyn.design.sampled_text import stability_table
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.tables import Table
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True, eq=False)
class SampledGains:
    """What sampling does to each controller with these gains, by name."""

    table: Table
    record: Mapping[str, Any]


def judge_of_gains(rate: float, delay: int) -> Callable[[Arm, Gains], SampledGains]:
    """What judges gains at a rate [Hz] and a delay [samples]; raises `OptionError` for another rate or delay."""
    sampling = Sampling(rate, delay)

    def judged(arm: Arm, gains: Gains) -> SampledGains:
        found = sampled_loops(arm, gains, sampling)
        return SampledGains(stability_table(arm, found), {name: each.to_json() for name, each in found.items()})

    return judged


def sampled_loops(arm: Arm, gains: Gains, sampling: Sampling) -> dict[str, SampledStability]:
    """The sampled loop of each controller with these gains, and with the gains of the arm's file, where it has any."""
    dynamics, omega_n, xi = dynamics_of(arm), gains.omega_n, gains.xi
    controllers: dict[str, Linearised] = {
        "pd-gravity": PDGravity(dynamics, gains.Kp, gains.Kd),
        "pid": PID(gains.Kp, gains.Kd, arm.effort, dynamics=dynamics, omega_n=omega_n),
        "inverse-dynamics": tuned_inverse_dynamics(arm, dynamics, omega_n=omega_n, xi=xi),
    }
    if arm.gains is not None:
        controllers["pd-gravity --own-gains"] = tuned_pd_gravity(arm, dynamics, own_gains=True)
    return {name: stability_in_box(arm, dynamics, each, sampling) for name, each in controllers.items()}
