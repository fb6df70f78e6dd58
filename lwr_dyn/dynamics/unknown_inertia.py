"""Inertial parameters that a source leaves open: allowed where no torque depends on them.

Torques are linear in the parameters, tau = Y(q, dq, ddq) pi. A parameter cannot matter when its column of Y is zero at
all states: of a link on a vertical first axis only Izz moves anything. The columns are computed at random states.
"""

from typing import Any

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL, Regressor
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Chain

STATES = 20
ROUNDING = 1e-12
"""Of the largest entry of Y: what a column of zeros may be off."""
_UNITS = ("kg", *("kg m",) * 3, *("kg m^2",) * 6)


def chain_with_dynamics(arm: Any) -> Chain:
    """The chain of an arm whose torques its source determines.

    Raises
    ------
    MissingDataError
        Links without inertia, or an unknown parameter on which a torque depends.
    """
    chain: Chain = arm.require_dynamics()
    if any(link.body.unknown for link in chain.links if link.body is not None):
        _refuse_what_matters(arm.name, chain)
    return chain


def _refuse_what_matters(name: str, chain: Chain) -> None:
    rng = np.random.default_rng(0)
    Y = np.abs(Regressor(chain)(*rng.uniform(-np.pi, np.pi, (3, STATES, chain.n)))).max(axis=0)  # (n, 15 n)
    largest = float(Y[:, : len(INERTIAL) * chain.n].max())
    for i, link in enumerate(chain.links):
        for p in () if link.body is None else link.body.unknown:
            column = Y[:, len(INERTIAL) * i + p]
            joint = int(np.argmax(column))
            if column[joint] > ROUNDING * largest:
                share = f"the torque of {chain.links[joint].joint}: up to {column[joint]:.3g} N m per {_UNITS[p]}"
                raise MissingDataError(name, f"{INERTIAL[p]} of {link.link} about its frame's origin is", share)
