"""The motion of two joints with friction, phase by phase with scipy's DOP853: a reference of its own code.

A phase is a pair of signs; it ends where a speed passes zero or a joint at rest needs more than its static level. It is
written for joints that start and stop one at a time.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


def slip(model, sign, speed):
    """Friction torque of a joint that moves to the side of its sign."""
    side = model.positive if sign > 0 else model.negative
    return sign * side.coulomb + abs(sign) * side.viscous * speed


@dataclass(frozen=True)
class Phases:
    """Dynamics, two friction models, and the torque as a function of time."""

    dynamics: object
    models: list
    torque: object

    def acceleration(self, t, y, signs):
        """ddq with the joints of sign 0 at rest, and what has to resist them."""
        q, dq = y[:2], y[2:]
        tau = self.torque(t) - [slip(*each) for each in zip(self.models, signs, dq, strict=True)]
        B, rest = self.dynamics.mass_matrix(q), tau - self.dynamics.bias_torque(q, dq)
        ddq, moving = np.zeros(2), np.flatnonzero(signs)
        ddq[moving] = np.linalg.solve(B[np.ix_(moving, moving)], rest[moving])
        return ddq, rest - B @ ddq

    def rates(self, t, y, signs):
        """dy/dt in a phase."""
        return np.concatenate([y[2:], self.acceleration(t, y, signs)[0]])

    def watch(self, i, signs):
        """Functions that fall through zero when joint i ends a phase: each with the sign it then has, if it slips."""
        low, high = self.models[i].breakaway
        if signs[i]:
            return [(lambda t, y, signs: signs[i] * y[2 + i], 0)]
        return [
            (lambda t, y, signs: high - self.acceleration(t, y, signs)[1][i], 1),
            (lambda t, y, signs: self.acceleration(t, y, signs)[1][i] - low, -1),
        ]

    def side_of(self, i, t, y, signs):
        """Where joint i at rest goes: nowhere while its static levels hold it."""
        needed = self.acceleration(t, y, [0 if k == i else signs[k] for k in (0, 1)])[1][i]
        low, high = self.models[i].breakaway
        return int(needed > high) - int(needed < low)

    def follow(self, start, duration, signs=(0, 0)):
        """Events (kind, joint, t) and the positions at the end, from rest at `start` into a phase."""
        t, y, out = 0.0, np.concatenate([start, np.zeros(2)]), []
        while True:
            watched = [(i, f, side) for i in (0, 1) for f, side in self.watch(i, signs)]
            for _, f, _ in watched:
                f.terminal, f.direction = True, -1
            part = solve_ivp(
                self.rates, (t, duration), y, "DOP853", args=(signs,), rtol=1e-12, atol=1e-14, max_step=0.01,
                events=[f for _, f, _ in watched],
            )  # fmt: skip
            t, y = part.t[-1], part.y[:, -1]
            if part.status != 1:
                return out, y[:2]
            i, side = next((i, side) for (i, _, side), times in zip(watched, part.t_events, strict=True) if len(times))
            kind = "slip"
            if signs[i]:
                y[2 + i] = 0.0
                side = self.side_of(i, t, y, signs)
                kind = "reverse" if side else "stick"
            out.append((kind, i, t))
            signs = tuple(side if k == i else signs[k] for k in (0, 1))
