"""Copies of published sets as URDFs: digits changed, frames moved, units exchanged; and arms that copy nothing."""

from itertools import pairwise, permutations

import numpy as np

from lwr_dyn.model.spatial import from_rpy
from tests.random_arms import random_body

FRAMES = ("kept", "inertial turned", "axes exchanged", "turned", "moved")
UNITS = ((1.0, 1.0), (1e3, 1.0), (1.0, 1e3), (1e3, 1e2))
"""Factors of masses and lengths: SI, g, mm, g and cm."""
LINK = """<link name="{name}"><inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="{mass}"/>
<inertia ixx="{t[0]}" ixy="{t[1]}" ixz="{t[2]}" iyy="{t[3]}" iyz="{t[4]}" izz="{t[5]}"/></inertial></link>"""


def changed(text, rng):
    """One digit of a number exchanged, not the first."""
    places = [i for i, c in enumerate(text) if c.isdigit()][1:]
    if not places:
        return text
    at = places[rng.integers(len(places))]
    return text[:at] + str((int(text[at]) + rng.integers(1, 10)) % 10) + text[at + 1 :]


def right_turn(rng):
    """A rotation that exchanges axes."""
    while True:
        R = np.eye(3)[list(list(permutations(range(3)))[rng.integers(6)])] * rng.choice([-1.0, 1.0], 3)
        if np.linalg.det(R) > 0:
            return R


def moved(com, tensor, frames, rng):
    """Centre, tensor and rpy of the inertial frame in another frame of the link."""
    if frames == "inertial turned":
        rpy = rng.uniform(-1.5, 1.5, 3)
        R = from_rpy(rpy)
        return com, R.T @ tensor @ R, rpy
    R = {"kept": np.eye(3), "axes exchanged": right_turn(rng)}.get(frames)
    R = from_rpy(rng.uniform(-3, 3, 3)) if R is None else R
    shift = rng.uniform(-0.3, 0.3, 3) if frames == "moved" else np.zeros(3)
    return R @ com + shift, R @ tensor @ R.T, np.zeros(3)


def urdf_of(links, rng, frames="kept", units=(1.0, 1.0), digits=9, share=0.0):
    """A URDF: links (name, mass, com, tensor) in other frames and units, with a share of its numbers changed."""
    out = []
    mass_unit, length_unit = units

    def put(x):
        text = f"{x:.{digits}g}"
        return changed(text, rng) if rng.random() < share else text

    for name, mass, com, tensor in links:
        c, T, rpy = moved(com, tensor, frames, rng)
        entries = [put(T[at] * mass_unit * length_unit**2) for at in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
        xyz = " ".join(put(x * length_unit) for x in c)
        rpy = " ".join(f"{x:.12g}" for x in rpy)
        out.append(LINK.format(name=name, xyz=xyz, rpy=rpy, mass=put(mass * mass_unit), t=entries))
    names = [link[0] for link in links]
    joints = "".join(
        f'<joint name="{b}_joint" type="continuous"><parent link="{a}"/><child link="{b}"/><axis xyz="0 0 1"/></joint>'
        for a, b in pairwise(names)
    )
    return f'<robot name="planted">{"".join(out)}{joints}</robot>'


def links_of(numbers):
    """The links of `LinkNumbers` as rows."""
    return list(zip(numbers.names, numbers.mass, numbers.com, numbers.tensor, strict=True))


def planted_copy(known, rng):
    """A copy of a set: its links, a base before or a hand behind them, and what was done to it, as words."""
    frames = FRAMES[rng.integers(len(FRAMES))]
    units = UNITS[rng.integers(len(UNITS))] if rng.random() < 0.4 else UNITS[0]
    digits, share = int(rng.choice([4, 6, 9])), float(rng.choice([0.0, 0.1, 0.25]))
    own = [(f"x_{name}", *rest) for name, *rest in links_of(known.links if rng.random() < 0.5 else known.native)]
    body = random_body(rng)
    more = [[(name, body.mass, body.com, body.inertia_com)][: rng.integers(2)] for name in ("extra_0", "hand_extra_0")]
    links = [*more[0], *own, *more[1]]
    words = f"{known.name}, frames {frames}, units {units}, {digits} digits, {share:.0%} of the digits changed"
    return urdf_of(links, rng, frames, units, digits, share), words


def foreign_arm(rng):
    """An arm that copies nothing: bodies of random mass points, rounded as a table is."""
    digits = int(rng.choice([2, 3, 4, 6]))
    bodies = [random_body(rng) for _ in range(rng.integers(5, 9))]
    rows = [(f"link_{i}", b.mass, b.com, b.inertia_com) for i, b in enumerate(bodies)]
    return urdf_of(rows, rng, digits=digits)
