"""The metrics of a run of a study by name: unit, words, and which side of a bound is bad."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from lwr_dyn.foundation.errors import UnknownNameError


@dataclass(frozen=True, slots=True)
class MetricRow:
    """One metric; `per_joint` where it has one number a joint, `at_least` where a bound is a lower one."""

    unit: str
    words: str
    per_joint: bool = False
    at_least: bool = False
    signed: bool = False
    """Whether it can be negative."""


METRICS: Mapping[str, MetricRow] = MappingProxyType(
    {
        "tip_rms": MetricRow("m", "error of the tip, RMS over the samples"),
        "tip_max": MetricRow("m", "error of the tip, largest"),
        "tip_final": MetricRow("m", "error of the tip at the end"),
        "position_rms": MetricRow("rad or m", "error of a joint, RMS over the samples", per_joint=True),
        "position_max": MetricRow("rad or m", "error of a joint, largest", per_joint=True),
        "peak_torque": MetricRow("N m or N", "largest torque that acts", per_joint=True),
        "peak_command": MetricRow("N m or N", "largest torque that the law asks for", per_joint=True),
        "torque_rms": MetricRow("N m or N", "torque that acts, RMS over the samples", per_joint=True),
        "peak_speed": MetricRow("rad/s or m/s", "largest speed", per_joint=True),
        "saturated_s": MetricRow("s", "time beyond the torque limit", per_joint=True),
        "limit_margin": MetricRow("rad or m", "least distance from a position limit", True, at_least=True, signed=True),
        "first_violation": MetricRow("s", "when the tip first leaves the tolerance, inf if never", at_least=True),
    }
)
"""Metrics of every run, in SI units; `tip_q95` and the like come with the quantiles of a study."""


def metric_row(name: str, quantiles: tuple[float, ...] = ()) -> MetricRow:
    """The metric of a name; raises `UnknownNameError`, which says what is near.

    >>> metric_row("tip_rms").unit
    'm'
    """
    shares = _names(quantiles)
    if name in shares:
        return MetricRow("m", f"error of the tip, {100 * shares[name]:g} % quantile over time")
    if name not in METRICS:
        raise UnknownNameError("metric", name, (*METRICS, *(shares or ("tip_q95 with quantiles = [0.95]",))))
    return METRICS[name]


def _names(quantiles: tuple[float, ...]) -> dict[str, float]:
    """Metric -> share of time; the rollouts, which name them, are imported where there is one."""
    if not quantiles:
        return {}
    from lwr_dyn.codegen.rollouts.figures import quantile_name

    return {quantile_name(share): share for share in quantiles}
