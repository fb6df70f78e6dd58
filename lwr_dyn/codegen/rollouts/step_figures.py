"""What a step adds to the figures of its run: sums, largest and smallest values over the samples, on symbols."""

from collections.abc import Mapping
from typing import Any

import casadi

from lwr_dyn.codegen.rollouts.slots import FIGURES
from lwr_dyn.model.vectors import Vector

STARTS = dict.fromkeys(FIGURES, 0.0) | {"margin": float("inf"), "violation": float("inf")}
"""The figures before the first sample."""


def figures(x: Mapping[str, Any], tip: Vector, command: Any, applied: Any) -> dict[str, Any]:
    """The figures after a sample, from those before it (in `x`, by `slots.FIGURES`) and the sample's numbers.

    Largest values keep their first argument where a number is NaN, and `trouble` says so.
    """
    q, dq = x["q"], x["dq"]
    n = q.numel()
    error = x["reference"][:n] - q
    away = casadi.vertcat(tip.x, tip.y, tip.z) - x["tip"]
    square = casadi.dot(away, away)
    margin = casadi.fmin(q - x["lower"], x["upper"] - q)
    cut = casadi.fabs(command) > x["rating"]
    moves = x["sample"] < x["last"]  # the last sample has no duration
    late = casadi.if_else(square > x["tolerance"], x["sample"], 1e300)
    return {
        "tip_squares": x["tip_squares"] + square,
        "tip_worst": casadi.fmax(x["tip_worst"], square),
        "tip_square": square,
        "position_squares": x["position_squares"] + error * error,
        "position_worst": casadi.fmax(x["position_worst"], casadi.fabs(error)),
        "torque_worst": casadi.fmax(x["torque_worst"], casadi.fabs(applied)),
        "command_worst": casadi.fmax(x["command_worst"], casadi.fabs(command)),
        "torque_squares": x["torque_squares"] + applied * applied,
        "speed_worst": casadi.fmax(x["speed_worst"], casadi.fabs(dq)),
        "saturated": x["saturated"] + cut * moves,
        "margin": casadi.fmin(x["margin"], margin),
        "violation": casadi.fmin(x["violation"], late),
        "angle_worst": casadi.fmax(x["angle_worst"], casadi.dot(q, q)),
        "trouble": x["trouble"] + x["nothing"] * (casadi.sum1(q) + casadi.sum1(dq) + casadi.sum1(command)),
    }
