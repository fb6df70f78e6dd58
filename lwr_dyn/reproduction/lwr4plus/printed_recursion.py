"""The LWR 4+ paper's Newton-Euler recursion written out from its page, with its slips to be switched on one by one.

Without slips it is the hand-written recursion with whole rotors, and must agree with it; with one, it is the page to
the letter in that place.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.model.chain import Body, Chain, Rotor

SLIPS = ("moment-omega", "torque-transposes")
Z0 = np.array([0.0, 0.0, 1.0])


def printed_torque(chain: Chain, q: Array, dq: Array, ddq: Array, slips: Collection[str] = ()) -> Array:
    """tau (n,) [N m] of the printed equations for one state (n,); `slips` names what is taken to the letter."""
    n = chain.n
    R = [link.pose(x).rotation for link, x in zip(chain.links, q, strict=True)]
    r = [rotation.T @ link.pose(x).position for rotation, link, x in zip(R, chain.links, q, strict=True)]
    bodies = [link.body or Body.massless() for link in chain.links]
    rotors = [link.rotor or Rotor(0.0, 0.0) for link in chain.links]
    w, dw, ddp = np.zeros(3), np.zeros(3), -chain.gravity
    omega, domega, ddp_com, domega_m = [], [], [], []
    for i in range(n):
        k = rotors[i].gear_ratio
        domega_m.append(dw + k * ddq[i] * Z0 + k * dq[i] * np.cross(w, Z0))
        dw = R[i].T @ (dw + ddq[i] * Z0 + dq[i] * np.cross(w, Z0))
        w = R[i].T @ (w + dq[i] * Z0)
        ddp = R[i].T @ ddp + np.cross(dw, r[i]) + np.cross(w, np.cross(w, r[i]))
        c = bodies[i].com
        omega.append(w)
        domega.append(dw)
        ddp_com.append(ddp + np.cross(dw, c) + np.cross(w, np.cross(w, c)))
    tau, f, mu = np.zeros(n), np.zeros(3), np.zeros(3)
    for i in reversed(range(n)):
        body, after = bodies[i], R[i + 1] if i + 1 < n else np.eye(3)
        f_next, mu_next = after @ f, after @ mu
        f = f_next + body.mass * ddp_com[i]
        spun = omega[i] if "moment-omega" in slips else domega[i]
        mu = -np.cross(f, r[i] + body.com) + mu_next + np.cross(f_next, body.com) + body.inertia_com @ spun
        mu = mu + np.cross(omega[i], body.inertia_com @ omega[i])
        if i + 1 < n:
            spin = rotors[i + 1].gear_ratio * rotors[i + 1].inertia
            mu = mu + spin * ddq[i + 1] * Z0 + spin * dq[i + 1] * np.cross(omega[i], Z0)
        axis = R[i] @ Z0 if "torque-transposes" in slips else R[i].T @ Z0
        tau[i] = mu @ axis + rotors[i].gear_ratio * rotors[i].inertia * domega_m[i] @ Z0
    return tau
