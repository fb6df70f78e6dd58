"""A study and its runs by formula: what statistics and pages are tried on, without a simulation."""

from dataclasses import replace

import numpy as np

from lwr_dyn.studies.sweep.sampling import VariedParameter
from lwr_dyn.studies.sweep.summary import ControllerRuns
from lwr_dyn.studies.sweep.sweep_study import SweepStudy

CONTROLLERS = ("inverse-dynamics", "pd-gravity:omega-n=20", "adaptive")


def varied(path, low, high, nominal, unit=""):
    """A uniform parameter."""
    return VariedParameter(path, "uniform", (path,), unit, path, low=low, high=high, nominal=nominal)


def study(runs=512, method="random", **changes):
    """A study of payload, masses, centres, friction, delay and reading."""
    centres = tuple(f"arm.com.{i}.{axis}" for i in (1, 2) for axis in "xyz")
    parameters = (
        varied("payload.mass", 0.0, 7.0, 0.0, "kg"),
        varied("arm.mass", 0.8, 1.2, 1.0),
        VariedParameter("arm.com", "uniform", centres, "m", "centres", low=-0.01, high=0.01, nominal=0.0),
        varied("friction.coulomb", 0.0, 0.05, 0.0),
        VariedParameter("loop.delay", "choice", ("loop.delay",), values=(0.0, 1.0, 2.0, 3.0, 4.0), nominal=0.0),
        VariedParameter("reading", "choice", ("reading",), values=("computed", "printed")),
    )  # fmt: skip
    given = {
        "name": "payload and friction", "robot": "lwr4plus", "reading": "computed", "controllers": CONTROLLERS,
        "task": "ist-clear", "method": method, "runs": runs, "parameters": parameters,
        "limits": {"tip_max": 1e-3, "limit_margin": 0.05}, "keep": 2,
    }  # fmt: skip
    return SweepStudy(**{**given, **changes})


def without_divergence(made):
    """The same study with shorter delays, for which no run diverges."""
    values = (0.0, 1.0, 2.0, 3.0)
    shorter = [replace(one, values=values) if one.path == "loop.delay" else one for one in made.parameters]
    return replace(made, parameters=tuple(shorter))


def metrics_of(values, gain):
    """Metrics by formula; runs with a delay of 4 and more than 6.5 kg diverge."""
    values = {path: np.asarray(column) for path, column in values.items()}
    mass, delay, friction = (values[path].astype(float) for path in ("payload.mass", "loop.delay", "friction.coulomb"))
    com = np.abs(values["arm.com"]).sum(axis=1)
    tip = (
        1e-4
        / gain
        * (0.5 + mass * (1.0 + 0.2 * delay) + 40.0 * friction + 5.0 * np.abs(values["arm.mass"] - 1.0) + 9 * com)
    )
    tip = np.where(values["reading"] == "printed", 1.3 * tip, tip)
    tip = np.where((delay >= 4.0) & (mass > 6.5), np.inf, tip)
    margin = np.column_stack(
        [np.where(np.isinf(tip), np.nan, 0.3 - 20.0 * np.minimum(tip, 1.0)), np.full(mass.size, 0.4)]
    )
    cut = np.column_stack([np.maximum(0.0, mass - 6.8), np.zeros(mass.size)])
    return {"tip_max": tip, "tip_rms": 0.4 * tip, "limit_margin": margin, "saturated_s": cut}


def runs_of(made, first=0, stop=None):
    """Controller -> its runs."""
    stop = stop or made.runs
    values, out = made.values(first, stop), {}
    for place, name in enumerate(made.controllers):
        metrics = metrics_of(values, (3.0, 0.8, 4.0)[place % 3])
        flags = np.where(
            np.isinf(metrics["tip_max"]), "not finite", np.where(metrics["limit_margin"].min(axis=1) < 0.27, "stop", "")
        )
        out[name] = ControllerRuns(name, np.arange(first, stop), values, metrics, flags, flags != "")
    return out


def evaluate(controller, values):
    """What makes further runs."""
    place = CONTROLLERS.index(controller)
    return metrics_of(values, (3.0, 0.8, 4.0)[place])
