"""Proofs of the errata in the LWR 4+ paper's tables: the printed numbers against what they must be."""

import itertools
from dataclasses import replace

import numpy as np

from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.reproduction.case import PaperCase, PaperData, Proof, Prove
from lwr_dyn.reproduction.lwr4plus.formulas import origin_miss
from lwr_dyn.reproduction.lwr4plus.proofs_of_equations import EQUATIONS
from lwr_dyn.reproduction.lwr4plus.worst_cases import at_printed, largest

ROWS, SWAPPED, C5Z = "table2-rows", "table1-swapped-yz", "table2-c5z"


def table2_rows(data: PaperData) -> Proof:
    """Table II's left column against the DH rows, as printed and one row lower."""
    before, after = (float(np.max(origin_miss(c, c.block("table_ii"))["miss"])) for c in (data.case(), data.case(ROWS)))
    last = data.case().values("inertial", "com")[6]
    return Proof(
        "r_{i-1,i} = (a_i, d_i sin alpha_i, d_i cos alpha_i) holds for every row only one row lower; row 7 of r_{i,Ci}"
        f" is {last!r}",
        before > 0.05 and after < 1e-12 and last == "-",
        {"largest miss as printed [m]": before, "largest miss as read [m]": after},
    )


def table1_swapped(data: PaperData) -> Proof:
    """All 36 orders of the axes of I_2 and I_4 against b11 to b44 of Table IV."""
    case = data.case(ROWS, C5Z)
    orders = list(itertools.permutations(range(3)))
    fits = [
        pair for pair in itertools.product(orders, repeat=2) if _b_agree(case, dict(zip((1, 3), pair, strict=True)))
    ]
    named = [" ".join("".join("xyz"[k] for k in order) for order in pair) for pair in fits]
    return Proof(
        "of the 36 orders of the axes of I_2 and I_4 one gives b11 to b44 of Table IV: y and z exchanged in both",
        named == ["xzy xzy"],
        {"orders that give b11 to b44": str(named)},
    )


def _b_agree(case: PaperCase, orders: dict[int, tuple[int, ...]]) -> bool:
    """b44 to b11 follow when the axes of some links are put in another order."""
    bodies = list(case.arm.chain.bodies or ())
    for i, order in orders.items():
        bodies[i] = replace(bodies[i], inertia_com=bodies[i].inertia_com[np.ix_(order, order)])
    arm = case.arm.with_chain(with_bodies(case.arm.chain, bodies))
    return all(agrees(_b(case)[joint], largest(arm, joint)) for joint in (3, 2, 1, 0))


def _b(case: PaperCase) -> list[str]:
    return list(case.block("table_iv").printed["b"])


def table2_c5z(data: PaperData) -> Proof:
    """The printed number against link 6's; every c5z on a grid of 1e-4 m against b55, the best against b11 to b44."""
    case = data.case(ROWS, SWAPPED)
    fifth, sixth = (float(case.arm.chain.bodies[i].com[2]) for i in (4, 5))  # type: ignore[index]
    grid = [round(-1e-4 * k, 4) for k in range(501)]
    fitting = [z for z in grid if agrees(_b(case)[4], largest(_with_c5z(case.arm, z), 4, from_known_maxima=True))]
    read = float(data.case(ROWS, SWAPPED, C5Z).values("inertial", "com")[4][2])
    followers = [agrees(_b(case)[i], largest(_with_c5z(case.arm, read), i)) for i in range(5)]
    same = abs(fifth - sixth) < 1e-8
    return Proof(
        f"the printed c5z repeats link 6's; of {len(grid)} values {len(fitting)} give b55, and with {read} b11 to b44"
        " follow to every printed digit, with the printed one none does",
        same and read in fitting and fifth not in fitting and all(followers)
        and not any(agrees(_b(case)[i], largest(case.arm, i)) for i in (0, 2, 4)),
        {"printed c5z - c6z [m]": fifth - sixth, "fitting from [m]": min(fitting, default=0.0),
         "fitting to [m]": max(fitting, default=0.0)},
    )  # fmt: skip


def _with_c5z(arm: Arm, z: float) -> Arm:
    bodies = list(arm.chain.bodies or ())
    old = bodies[4]
    bodies[4] = Body(old.mass, np.array([old.com[0], old.com[1], z]), old.inertia_com)
    return arm.with_chain(with_bodies(arm.chain, bodies))


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
    wrong = [("Kp", i) for i in range(7) if not agrees(table["Kp"][i], float(gains.Kp[i]))]
    wrong += [("Kd", i) for i in range(7) if not agrees(table["Kd"][i], float(gains.Kd[i]))]
    crossed = agrees(table["Kp"][6], float(gains.Kd[5])) and agrees(table["Kd"][5], float(gains.Kp[6]))
    return Proof(
        "twelve of fourteen gains follow from b; K_P7 as printed is K_D6's value and K_D6 as printed is K_P7's",
        wrong == [("Kp", 6), ("Kd", 5)] and crossed,
        {"K_P7": float(gains.Kp[6]), "K_D6": float(gains.Kd[5])},
    )


def table4_configurations(data: PaperData) -> Proof:
    """B_ii over what the printed and the read configurations leave free."""
    own = data.reading()
    read = data.reading("", "table4-configurations")
    name = "table_iv_configurations"
    spans = [[at_printed(own.arm, i, c.block(name).printed["q"][i]) for i in range(5)] for c in (own, read)]
    b = _b(own)
    as_printed, as_read = ([agrees(b[i], x) for i, span in enumerate(half) for x in span] for half in spans)
    wrong = [i + 1 for i in range(5) if not all(as_printed[2 * i : 2 * i + 2])]
    numbers = {f"b{i + 1}{i + 1} as printed": f"{lo:.4g} to {up:.4g}" for i, (lo, up) in enumerate(spans[0])}
    return Proof(
        "the printed configurations of rows 1 to 5 leave the printed value, those read keep it whatever is free",
        wrong == [1, 2, 3, 4, 5] and all(as_read),
        dict(numbers),
    )


def com_from(data: PaperData) -> Proof:
    """r_{i,Ci} taken from the origin of link i-1, as the heading states, against Table IV."""
    case = data.reading()
    bodies, moved = list(case.arm.chain.bodies or ()), []
    for link, body in zip(case.arm.chain.links, bodies, strict=True):
        moved.append(replace(body, com=body.com - link.after.rotation.T @ link.after.position))
    other = case.arm.with_chain(with_bodies(case.arm.chain, moved))
    right, wrong = ([largest(a, i) for i in range(7)] for a in (case.arm, other))
    fits = [[agrees(b, x) for b, x in zip(_b(case), values, strict=True)] for values in (right, wrong)]
    return Proof(
        "Table IV follows with centres of mass from the origin of frame i, and not from that of frame i-1",
        all(fits[0]) and sum(fits[1]) <= 2,
        {"b11 from frame i": right[0], "b11 from frame i-1": wrong[0], "rows that follow from frame i-1": sum(fits[1])},
    )


def velocity_limits(data: PaperData) -> Proof:
    """The columns of the data file that come from Table III."""
    columns = data.tables["limits"]
    printed = sorted(name for name, column in columns.items() if column["kind"] == "printed")
    return Proof(
        f"from Table III come {', '.join(printed)}; speed limits are from elsewhere ({columns['velocity']['where']})",
        printed == ["effort", "lower", "upper"] and columns["velocity"]["kind"] != "printed",
    )


def table8_caption(data: PaperData) -> Proof:
    """Tables VII and VIII side by side: one trajectory, two tables, one caption."""
    case = data.case()
    pairs = [[case.numbers(t, c) for c in ("average", "maximum", "minimum")] for t in ("table_vii", "table_viii")]
    rows = np.array(pairs)
    equal = int(sum(np.array_equal(a, b) for a, b in zip(rows[0].T, rows[1].T, strict=True)))
    largest_gap = float(np.abs(rows[0] - rows[1]).max())
    return Proof(
        "no row of Table VIII is that of Table VII, so not both can be the errors of the decentralised controller",
        equal == 0 and largest_gap > 10.0,
        {"rows alike": equal, "largest difference [mrad]": largest_gap},
    )


def table8_velocity_order(data: PaperData) -> Proof:
    """Rows of Table VIII whose printed maximum velocity error is below the printed minimum."""
    case = data.case()
    most, least = (case.numbers("table_viii", f"velocity_{x}") for x in ("maximum", "minimum"))
    rows = [i + 1 for i, (a, b) in enumerate(zip(most, least, strict=True)) if a < b]
    return Proof("the printed maximum is below the printed minimum in these rows", rows == [2, 3, 4, 5, 6],
                 {"rows": str(rows)})  # fmt: skip


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
    )


def conclusion_errors(data: PaperData) -> Proof:
    """Average position errors of Table VIII against Table VII, joint by joint."""
    before, after = (data.case().numbers(t, "average") for t in ("table_vii", "table_viii"))
    worse = [i + 1 for i, (b, a) in enumerate(zip(before, after, strict=True)) if a > b]
    better = [i + 1 for i, (b, a) in enumerate(zip(before, after, strict=True)) if a < b]
    return Proof("the average error grows in these joints, against 'consistently reduced'", worse == [2, 3, 5],
                 {"grows in joints": str(worse), "shrinks in joints": str(better)})  # fmt: skip


PROOFS: dict[str, Prove] = {
    "table2-rows": table2_rows,
    "table1-swapped-yz": table1_swapped,
    "table2-c5z": table2_c5z,
    "rotor-inertia-power": rotor_power,
    "table6-exchanged": table6_exchanged,
    "table4-configurations": table4_configurations,
    "com-from": com_from,
    "velocity-limits": velocity_limits,
    "table8-caption": table8_caption,
    "table8-velocity-order": table8_velocity_order,
    "largest-error-side": largest_error_side,
    "conclusion-errors": conclusion_errors,
    **EQUATIONS,
}
