"""Proofs of the errata in the LWR 4+ paper's equations: each equation exactly as printed against the right one."""

from collections.abc import Collection
from typing import Any

import numpy as np

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Body, Chain, Rotor
from lwr_dyn.reproduction.case import PaperCase, PaperData, Proof, Prove

STATE = {
    "q": np.array([0.3, -0.7, 0.5, 1.1, -0.4, 0.9, 0.2]),
    "dq": np.array([0.5, -0.8, 1.1, 0.7, -1.3, 0.9, 1.7]),
    "ddq": np.array([1.0, 2.0, -1.5, 3.0, 2.5, -4.0, 5.0]),
}
EXACT = 1e-12
"""[N m] Two ways to one torque of a few tens of N m."""


def coriolis_vector(data: PaperData) -> Proof:
    """tau(ddq = 0) - g at dq and 2 dq: quadratic, so multiplied by dq already."""
    recursion = _recursion(data.reading())
    q, dq = STATE["q"], STATE["dq"]
    once, twice = (recursion.velocity_torque(q, k * dq) for k in (1.0, 2.0))
    C = recursion.coriolis_matrix(q, dq)
    declared = data.case().numbers("sizes", "C")
    growth = float(np.linalg.norm(twice) / np.linalg.norm(once))
    return Proof(
        f"the vector tau(ddq = 0) - g is C dq, fourfold at twice the speed; C is {C.shape[0]} x {C.shape[1]},"
        f" printed {declared[0]:g} x {declared[1]:g}",
        abs(growth - 4.0) < 1e-9 and float(np.abs(C @ dq - once).max()) < EXACT and declared != list(C.shape),
        {"growth at twice the speed": growth, "|C dq - (tau - g)| [N m]": float(np.abs(C @ dq - once).max())},
    )


def n_without_dq(data: PaperData) -> Proof:
    """tau - B ddq against C dq + g, and against the nearest that C without dq can be."""
    recursion = _recursion(data.reading())
    q, dq, ddq = STATE["q"], STATE["dq"], STATE["ddq"]
    C, g = recursion.coriolis_matrix(q, dq), recursion.gravity_vector(q)
    rest = recursion.inverse_dynamics(q, dq, ddq) - recursion.mass_matrix(q) @ ddq
    with_dq, without = np.abs(rest - (C @ dq + g)).max(), np.abs(rest - (C.sum(axis=1) + g)).max()
    return Proof(
        "tau - B ddq is C dq + g; C + g, a 7 x 7 matrix and a vector, is not (its rows summed: dq = 1)",
        bool(with_dq < EXACT and without > 1e-2 and C.ndim != g.ndim),
        {"with dq [N m]": float(with_dq), "without [N m]": float(without)},
    )


def _recursion(case: PaperCase, rotors: Any = "full") -> Recursion:
    return Recursion.of(case.arm.require_dynamics(), rotors)


def _as_printed(data: PaperData, erratum: str) -> tuple[float, float, float]:
    """Largest difference of the printed recursion from ours: corrected, with one erratum, and with it at rest."""
    case = data.reading()
    chain, ours = case.arm.require_dynamics(), _recursion(case)
    rest = STATE | {"dq": np.zeros(7)}
    tries = ((STATE, ()), (STATE, (erratum,)), (rest, (erratum,)))
    corrected, printed, at_rest = (
        float(np.abs(printed_torque(chain, **state, errata=errata) - ours.inverse_dynamics(**state)).max())
        for state, errata in tries
    )
    return corrected, printed, at_rest


def moment_omega(data: PaperData) -> Proof:
    """The moment equation with I omega, as printed, at rest and in motion."""
    good, bad, at_rest = _as_printed(data, "moment-omega")
    case = data.reading()
    chain, zero, unit = case.arm.require_dynamics(), np.zeros(7), np.eye(7)[6]
    weight = printed_torque(chain, zero, zero, zero)
    lost = float((printed_torque(chain, zero, zero, unit, ("moment-omega",)) - weight)[6])
    rotor = float(case.arm.armature[6])
    return Proof(
        "with I domega the page is our recursion; with I omega B_77 is the rotor alone",
        good < EXACT and bad > 1e-3 and at_rest > 1e-3 and abs(lost - rotor) < EXACT,
        {"put right [N m]": good, "as printed [N m]": bad, "B_77 as printed [kg m^2]": lost, "k_r^2 I_m": rotor},
    )


def torque_transposes(data: PaperData) -> Proof:
    """The torque equation with R z_0 in place of R^T z_0."""
    good, bad, _ = _as_printed(data, "torque-transposes")
    return Proof(
        "with R^T z_0 the page is our recursion; with R z_0 the torque is taken about another axis",
        good < EXACT and bad > 0.1,
        {"put right [N m]": good, "as printed [N m]": bad},
    )


def outer_loop_q(data: PaperData) -> Proof:
    """Both outer loops on ddq = y for two seconds, from rest at 0 to a constant q_d of 0.5 rad."""
    Kp, Kd = _outer(data)
    goal = 0.5
    read = _state_after(lambda q, dq: -Kp * q - Kd * dq + Kp * goal)
    printed = _state_after(lambda q, dq: -Kp - Kd * dq + Kp * goal)
    drift = Kp * (goal - 1.0) / Kd
    return Proof(
        "with q the arm comes to rest at q_d; without, it drifts at K_P (q_d - 1)/K_D",
        abs(read[0] - goal) < 1e-6 and abs(read[1]) < 1e-6 and abs(printed[1] / drift - 1.0) < 1e-6,
        {"with q: q [rad]": read[0], "without: dq [rad/s]": printed[1], "K_P (q_d - 1)/K_D [rad/s]": drift},
    )


def _outer(data: PaperData) -> tuple[float, float]:
    case = data.case()
    return case.numbers("centralized_gains", "Kp")[0], case.numbers("centralized_gains", "Kd")[0]


def _state_after(acceleration: Any, duration: float = 2.0, steps: int = 4000) -> Array:
    """(q, dq) after `duration` under ddq = acceleration(q, dq), from rest at 0, by RK4."""
    x, h = np.zeros(2), duration / steps

    def rate(s: Array) -> Array:
        return np.array([s[1], acceleration(s[0], s[1])])

    for _ in range(steps):
        a = rate(x)
        b = rate(x + h / 2 * a)
        c = rate(x + h / 2 * b)
        x = x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c))
    return x


def error_second_derivative(data: PaperData) -> Proof:
    """The error of the closed loop put into both equations."""
    Kp, Kd = _outer(data)
    poles = np.roots([1.0, Kd, Kp])
    t = np.linspace(0.0, 0.2, 201)
    rate = float(-poles.real.max())
    e, de = (1 + rate * t) * np.exp(-rate * t), -(rate**2) * t * np.exp(-rate * t)
    dde = -(rate**2) * (1 - rate * t) * np.exp(-rate * t)
    right, printed = np.abs(dde + Kd * de + Kp * e).max(), np.abs(de + Kd * de + Kp * e).max()
    return Proof(
        "the error from rest, (1 + 50 t) exp(-50 t), fulfils the equation with the second derivative alone",
        bool(np.allclose(poles, -rate, atol=1e-4) and right < 1e-6 and printed > 100.0),
        {"residual with second derivative": float(right), "residual as printed": float(printed),
         "pole as printed [1/s]": -Kp / (1 + Kd)},
    )  # fmt: skip


def pid_is_pd(data: PaperData) -> Proof:
    """The printed controller and one with an integral under a constant load on joint 1: the remaining errors."""
    case = data.case()
    Kp, Kd, b = (case.numbers(*x)[0] for x in (("table_vi", "Kp"), ("table_vi", "Kd"), ("table_iv", "b")))
    load, Ki = 10.0, 20.0 * Kp
    x, h = np.zeros(3), 5e-5  # q, dq, integral of the error
    stays = []
    for gain in (0.0, Ki):
        x = np.zeros(3)
        for _ in range(40000):
            ddq = (-Kp * x[0] - Kd * x[1] - gain * x[2] - load) / b
            x = x + h * np.array([x[1] + h * ddq, ddq, x[0]])
        stays.append(float(-x[0]))
    return Proof(
        "under a constant load of 10 N m the printed law keeps the error d/K_P; with an integral none stays",
        abs(stays[0] / (load / Kp) - 1.0) < 1e-6 and abs(stays[1]) < 1e-6,
        {"printed law [rad]": stays[0], "d/K_P [rad]": load / Kp, "with an integral [rad]": stays[1]},
    )


Z0 = np.array([0.0, 0.0, 1.0])


def printed_torque(chain: Chain, q: Array, dq: Array, ddq: Array, errata: Collection[str] = ()) -> Array:
    """tau (n,) [N m] of the paper's Newton-Euler equations for one state (n,).

    `errata` are left as printed, of "moment-omega" and "torque-transposes"; without any it is our recursion.
    """
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
        spun = omega[i] if "moment-omega" in errata else domega[i]
        mu = -np.cross(f, r[i] + body.com) + mu_next + np.cross(f_next, body.com) + body.inertia_com @ spun
        mu = mu + np.cross(omega[i], body.inertia_com @ omega[i])
        if i + 1 < n:
            spin = rotors[i + 1].gear_ratio * rotors[i + 1].inertia
            mu = mu + spin * ddq[i + 1] * Z0 + spin * dq[i + 1] * np.cross(omega[i], Z0)
        axis = R[i] @ Z0 if "torque-transposes" in errata else R[i].T @ Z0
        tau[i] = mu @ axis + rotors[i].gear_ratio * rotors[i].inertia * domega_m[i] @ Z0
    return tau


EQUATIONS: dict[str, Prove] = {
    "coriolis-vector": coriolis_vector,
    "n-without-dq": n_without_dq,
    "moment-omega": moment_omega,
    "torque-transposes": torque_transposes,
    "outer-loop-q": outer_loop_q,
    "error-second-derivative": error_second_derivative,
    "pid-is-pd": pid_is_pd,
}
