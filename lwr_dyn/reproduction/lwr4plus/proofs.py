"""Proofs of the errata in the LWR 4+ paper: tables against what they must be, equations exactly as printed."""

import itertools
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, Chain, Rotor, with_bodies
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.reproduction.case import CONTRADICTION, PaperCase, PaperData, Proof, Prove
from lwr_dyn.reproduction.lwr4plus.formulas import origin_miss
from lwr_dyn.reproduction.lwr4plus.worst_cases import at_printed, largest

ROWS, SWAPPED, C5Z = "table2-rows", "table1-swapped-yz", "table2-c5z"


def table2_rows(data: PaperData) -> Proof:
    """Table II's left column against the DH rows, as printed and one row lower."""
    case = data.case()
    before, after = (float(np.max(origin_miss(c, c.block("table_ii"))["miss"])) for c in (case, data.case(ROWS)))
    last = case.values("inertial", "com")[6]
    return Proof(
        "r_{i-1,i} = (a_i, d_i sin alpha_i, d_i cos alpha_i) holds for every row only one row lower; row 7 of r_{i,Ci}"
        f" is {last!r}",
        before > 0.05 and after < 1e-12 and last == "-",
        {"largest miss as printed [m]": before, "largest miss as read [m]": after},
    )


def table1_swapped(data: PaperData) -> Proof:
    """All 36 orders of the axes of I_2 and I_4 against b11 - b22 and b33 - b44 of Table IV.

    Each pair of joints lies square to the other where its b is largest, with the same bodies beyond the elbow or the
    wrist: what is wrong in links 5 to 7 (erratum table2-c5z) changes all four b alike, and not these differences.
    """
    case, named = data.case(ROWS), list[str]()
    second, fourth = (case.bodies[i] for i in (1, 3))
    printed = [float(text) for text in _b(case)[:4]]
    last_digits = (1e-3, 1e-4)  # of a difference of two rounded numbers
    for pair in itertools.product(itertools.permutations(range(3)), repeat=2):
        two, four = (x.inertia_com[np.ix_(o, o)] for x, o in zip((second, fourth), pair, strict=True))
        arm = _with(case.arm, {1: replace(second, inertia_com=two), 3: replace(fourth, inertia_com=four)})
        if all(
            abs(largest(arm, i) - largest(arm, i + 1) - (printed[i] - printed[i + 1])) < within
            for i, within in ((2, last_digits[1]), (0, last_digits[0]))
        ):
            named.append(" ".join("".join("xyz"[k] for k in order) for order in pair))
    return Proof(
        "of the 36 orders of the axes of I_2 and I_4 one gives b11 - b22 and b33 - b44 of Table IV: y and z exchanged"
        " in both; no number of links 5 to 7 enters",
        named == ["xzy xzy"],
        {"orders that give both": str(named)},
    )


def _with(arm: Arm, other: Mapping[int, Body]) -> Arm:
    """The arm with other bodies of some links (0-based)."""
    return arm.with_chain(with_bodies(arm.chain, [other.get(i, x) for i, x in enumerate(arm.chain.bodies or ())]))


def _b(case: PaperCase) -> list[str]:
    return list(case.block("table_iv").printed["b"])


def table2_c5z(data: PaperData) -> Proof:
    """The printed number against link 6's; every c5z on a grid of 1e-4 m against b55, the best against b11 to b44."""
    case = data.case(ROWS, SWAPPED)
    body = case.bodies[4]
    fifth, sixth = (float(case.bodies[i].com[2]) for i in (4, 5))

    def with_c5z(z: float) -> Arm:
        return _with(case.arm, {4: replace(body, com=np.array([*body.com[:2], z]))})

    grid = [round(-1e-4 * k, 4) for k in range(501)]
    fitting = [z for z in grid if agrees(_b(case)[4], largest(with_c5z(z), 4, from_known_maxima=True))]
    read = float(data.case(ROWS, SWAPPED, C5Z).values("inertial", "com")[4][2])
    followers = [agrees(_b(case)[i], largest(with_c5z(read), i)) for i in range(5)]
    same = abs(fifth - sixth) < 1e-8
    return Proof(
        f"the printed c5z repeats link 6's; of {len(grid)} values {len(fitting)} give b55, and with {read} b11 to b44"
        " follow to every printed digit, with the printed one none does",
        same and read in fitting and fifth not in fitting and all(followers)
        and not any(agrees(_b(case)[i], largest(case.arm, i)) for i in (0, 2, 4)),
        {"printed c5z - c6z [m]": fifth - sixth, "fitting from [m]": min(fitting, default=0.0),
         "fitting to [m]": max(fitting, default=0.0)},
    )  # fmt: skip


def rotor_power(data: PaperData) -> Proof:
    """The formula's own numbers against its result, and which of both Table IV's b77 was computed with."""
    block = data.results.blocks["rotor_inertia"].printed
    formula, printed = 0.5 * block["m"] * block["r"] ** 2, float(block["I_m"][0])
    case = data.case(ROWS)
    used = float(case.values("rotors", "inertia")[6])
    b77, k = case.values("inertial", "inertia")[6][2][2], case.values("rotors", "gear_ratio")[6]
    with_printed, with_formula = b77 + k**2 * printed, b77 + k**2 * formula
    return Proof(
        "1/2 m r^2 is a hundred times the printed result; b77 shows that the authors computed with the printed one",
        abs(formula / printed - 100.0) < 1e-9 and used == printed and agrees(_b(case)[6], with_printed)
        and not agrees(_b(case)[6], with_formula),
        {"1/2 m r^2 [kg m^2]": formula, "printed": printed, "b77 with printed": with_printed,
         "b77 with formula": with_formula},
    )  # fmt: skip


def table6_exchanged(data: PaperData) -> Proof:
    """All fourteen gains from the printed b; the two that differ are exchanged."""
    case = data.case()
    table = case.block("table_vi").printed
    gains = second_order_gains([float(x) for x in _b(case)], table["omega_n"], table["xi"])
    names = itertools.product(("Kp", "Kd"), range(7))
    wrong = [(K, i) for K, i in names if not agrees(table[K][i], float(getattr(gains, K)[i]))]
    crossed = agrees(table["Kp"][6], float(gains.Kd[5])) and agrees(table["Kd"][5], float(gains.Kp[6]))
    return Proof(
        "twelve of fourteen gains follow from b; K_P7 as printed is K_D6's value and K_D6 as printed is K_P7's",
        wrong == [("Kp", 6), ("Kd", 5)] and crossed,
        {"K_P7": float(gains.Kp[6]), "K_D6": float(gains.Kd[5])},
    )


def table4_configurations(data: PaperData) -> Proof:
    """B_ii over what the printed and the read configurations leave free, against the arm's own maximum."""
    own = data.reading()
    name, case = "table_iv_configurations", data.case(ROWS, SWAPPED)
    shown = (c.block(name).printed["q"] for c in (own, data.reading("", "table4-configurations")))
    spans = [[at_printed(case.arm, i, q[i]) for i in range(5)] for q in shown]
    most = [largest(case.arm, i) for i in range(5)]
    as_printed, as_read = ([min(x / b for x in span) for span, b in zip(half, most, strict=True)] for half in spans)
    numbers = {f"B_{i + 1}{i + 1} as printed": f"{lo:.4g} to {up:.4g}" for i, (lo, up) in enumerate(spans[0])}
    return Proof(
        "the printed configurations of rows 1 to 5 leave the largest B_ii, those read keep it whatever is free",
        max(as_printed) < 0.999 and all(abs(x - 1.0) < 1e-6 for x in as_read),
        dict(numbers),
    )


def com_from(data: PaperData) -> Proof:
    """r_{i,Ci} taken from the origin of link i-1, as the heading states, against b11 to b44 of Table IV."""
    case = data.case(ROWS, SWAPPED)
    ends = [link.after.rotation.T @ link.after.position for link in case.arm.chain.links]
    other = _with(case.arm, {i: replace(x, com=x.com - ends[i]) for i, x in enumerate(case.bodies)})
    right, wrong = ([largest(a, i) for i in range(4)] for a in (case.arm, other))
    off = [max(abs(x / float(b) - 1.0) for b, x in zip(_b(case)[:4], values, strict=True)) for values in (right, wrong)]
    return Proof(
        "b11 to b44 of Table IV follow to 0.3 % with centres of mass from the origin of frame i, what is wrong in links"
        " 5 to 7 left as it is; from that of frame i-1 they are up to a third off",
        off[0] < 0.003 and off[1] > 0.25,
        {"b11 from frame i": right[0], "b11 from frame i-1": wrong[0], "largest part off from frame i": off[0],
         "from frame i-1": off[1]},
    )  # fmt: skip


def table8_velocity_order(data: PaperData) -> Proof:
    """Rows of Table VIII whose printed maximum velocity error is below the printed minimum."""
    case = data.case()
    most, least = (case.numbers("table_viii", f"velocity_{x}") for x in ("maximum", "minimum"))
    rows = (1 + np.flatnonzero(np.less(most, least))).tolist()
    return Proof("the printed maximum is below the printed minimum in these rows", rows == [2, 3, 4, 5, 6],
                 {"rows": str(rows)}, CONTRADICTION)  # fmt: skip


def largest_error_side(data: PaperData) -> Proof:
    """Maxima of joints 2 and 4 in Table VII against their minima."""
    case = data.case()
    most, least = (case.numbers("table_vii", x) for x in ("maximum", "minimum"))
    named = case.numbers("text_vii", "maximum")
    sizes = [max(abs(most[i]), abs(least[i])) / 1e3 for i in (1, 3)]
    return Proof(
        "the errors of joints 2 and 4 are larger on the negative side than the maxima that the text names",
        all(size > value for size, value in zip(sizes, named, strict=True)) and least[1] < -most[1] < 0,
        {"joint 2": sizes[0], "joint 4": sizes[1], "named in the text": str(named)},
        CONTRADICTION,
    )


def conclusion_errors(data: PaperData) -> Proof:
    """Average position errors of Table VIII against Table VII, joint by joint."""
    before, after = (np.array(data.case().numbers(t, "average")) for t in ("table_vii", "table_viii"))
    worse, better = ((1 + np.flatnonzero(side)).tolist() for side in (after > before, after < before))
    return Proof("the average error grows in these joints, against 'consistently reduced'", worse == [2, 3, 5],
                 {"grows in joints": str(worse), "shrinks in joints": str(better)}, CONTRADICTION)  # fmt: skip


STATE = {
    "q": np.array([0.3, -0.7, 0.5, 1.1, -0.4, 0.9, 0.2]),
    "dq": np.array([0.5, -0.8, 1.1, 0.7, -1.3, 0.9, 1.7]),
    "ddq": np.array([1.0, 2.0, -1.5, 3.0, 2.5, -4.0, 5.0]),
}
EXACT = 1e-12
"""[N m] Two ways to one torque of a few tens of N m."""


def coriolis_vector(data: PaperData) -> Proof:
    """tau(ddq = 0) - g at dq and 2 dq: quadratic, so multiplied by dq already."""
    recursion = Recursion.of(data.reading().arm.require_dynamics(), "full")
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
    recursion = Recursion.of(data.reading().arm.require_dynamics(), "full")
    q, dq, ddq = STATE["q"], STATE["dq"], STATE["ddq"]
    C, g = recursion.coriolis_matrix(q, dq), recursion.gravity_vector(q)
    rest = recursion.inverse_dynamics(q, dq, ddq) - recursion.mass_matrix(q) @ ddq
    with_dq, without = np.abs(rest - (C @ dq + g)).max(), np.abs(rest - (C.sum(axis=1) + g)).max()
    return Proof(
        "tau - B ddq is C dq + g; C + g, a 7 x 7 matrix and a vector, is not (its rows summed: dq = 1)",
        bool(with_dq < EXACT and without > 1e-2 and C.ndim != g.ndim),
        {"with dq [N m]": float(with_dq), "without [N m]": float(without)},
    )


def _as_printed(data: PaperData, erratum: str) -> tuple[float, float, float]:
    """Largest difference of the printed recursion from ours: corrected, with one erratum, and with it at rest."""
    chain, rest = data.reading().arm.require_dynamics(), STATE | {"dq": np.zeros(7)}
    ours = Recursion.of(chain, "full")

    def miss(state: Any, *errata: str) -> float:
        return float(np.abs(printed_torque(chain, **state, errata=errata) - ours.inverse_dynamics(**state)).max())

    return miss(STATE), miss(STATE, erratum), miss(rest, erratum)


def moment_omega(data: PaperData) -> Proof:
    """The moment equation with I omega, as printed, at rest and in motion."""
    good, bad, at_rest = _as_printed(data, "moment-omega")
    arm, zero = data.reading().arm, np.zeros(7)
    chain, rotor = arm.require_dynamics(), float(arm.armature[6])
    weight = printed_torque(chain, zero, zero, zero)
    lost = float((printed_torque(chain, zero, zero, np.eye(7)[6], ("moment-omega",)) - weight)[6])
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
    Kp, Kd = (data.case().numbers("centralized_gains", gain)[0] for gain in ("Kp", "Kd"))
    goal = 0.5
    read = _state_after(lambda x: np.array([x[1], -Kp * x[0] - Kd * x[1] + Kp * goal]))
    printed = _state_after(lambda x: np.array([x[1], -Kp - Kd * x[1] + Kp * goal]))
    drift = Kp * (goal - 1.0) / Kd
    return Proof(
        "with q the arm comes to rest at q_d; without, it drifts at K_P (q_d - 1)/K_D",
        abs(read[0] - goal) < 1e-6 and abs(read[1]) < 1e-6 and abs(printed[1] / drift - 1.0) < 1e-6,
        {"with q: q [rad]": read[0], "without: dq [rad/s]": printed[1], "K_P (q_d - 1)/K_D [rad/s]": drift},
    )


def _state_after(rate: Callable[[Array], Array]) -> Array:
    """(q, dq) after 2 s of d(q, dq)/dt = rate((q, dq)), from rest at 0, by RK4."""
    x, h = np.zeros(2), 2.0 / 4000
    for _ in range(4000):
        a = rate(x)
        b = rate(x + h / 2 * a)
        c = rate(x + h / 2 * b)
        x = x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c))
    return x


def error_second_derivative(data: PaperData) -> Proof:
    """The error of the closed loop put into both equations."""
    Kp, Kd = (data.case().numbers("centralized_gains", gain)[0] for gain in ("Kp", "Kd"))
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
    load, h, stays = 10.0, 5e-5, []
    for gain in (0.0, 20.0 * Kp):
        x = np.zeros(3)  # q, dq, integral of the error
        for _ in range(40000):
            ddq = (-Kp * x[0] - Kd * x[1] - gain * x[2] - load) / b
            x = x + h * np.array([x[1] + h * ddq, ddq, x[0]])
        stays.append(float(-x[0]))
    return Proof(
        "under a constant load of 10 N m the printed law keeps the error d/K_P; with an integral none stays",
        abs(stays[0] / (load / Kp) - 1.0) < 1e-6 and abs(stays[1]) < 1e-6,
        {"printed law [rad]": stays[0], "d/K_P [rad]": load / Kp, "with an integral [rad]": stays[1]},
        CONTRADICTION,
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


PROOFS: dict[str, Prove] = {
    "table2-rows": table2_rows,
    "table1-swapped-yz": table1_swapped,
    "table2-c5z": table2_c5z,
    "rotor-inertia-power": rotor_power,
    "table6-exchanged": table6_exchanged,
    "table4-configurations": table4_configurations,
    "com-from": com_from,
    "table8-velocity-order": table8_velocity_order,
    "largest-error-side": largest_error_side,
    "conclusion-errors": conclusion_errors,
    "coriolis-vector": coriolis_vector,
    "n-without-dq": n_without_dq,
    "moment-omega": moment_omega,
    "torque-transposes": torque_transposes,
    "outer-loop-q": outer_loop_q,
    "error-second-derivative": error_second_derivative,
    "pid-is-pd": pid_is_pd,
}
