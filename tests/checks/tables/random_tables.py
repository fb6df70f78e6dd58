"""Random correct tables that measure false alarms.

They look like those of robot papers: gains in proportion to inertias, figures of errors, masses with a total,
mirror-image links, DH rows stated twice, symmetric tensors, limits in round numbers, arithmetic in sentences.
"""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from lwr_dyn.checks.tables.sheet import Declared, Sentence, Sheet, SheetColumn, SheetMatrix, SheetTable


def printed(value: float, digits: int) -> str:
    """A number with so many significant digits, as a paper prints it."""
    if value == 0.0:
        return "0"
    return fixed(value, digits - 1 - int(np.floor(np.log10(abs(value)))))


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals; fewer than none are none."""
    return f"{value:.{max(decimals, 0)}f}"


def correct_sheet(rng: Generator) -> Sheet:
    """A file without a fault."""
    n = int(rng.integers(5, 9))
    tables = [_gains(rng, n), _errors(rng, n), _masses(rng, n), *_links(rng, n), _limits(rng, n), _noise(rng, n)]
    return Sheet("made up", tuple(tables), _tensors(rng, n), tuple(_sums(rng, i) for i in range(3)))


def _gains(rng: Generator, n: int) -> SheetTable:
    b, omega, xi = np.exp(rng.uniform(-6, 1.5, n)), float(rng.integers(10, 80)), float(rng.choice([0.7, 0.8, 1.0]))
    d = int(rng.integers(3, 6))
    lists = {"b": b, "Kp": omega**2 * b, "Kd": 2 * xi * omega * b}
    units = {"b": "kg m^2", "Kp": "N m/rad", "Kd": "N m s/rad"}
    columns = tuple(SheetColumn(k, tuple(printed(x, d) for x in v), units[k]) for k, v in lists.items())
    values = {"omega_n": SheetColumn("omega_n", (f"{omega:g}",), "rad/s"), "xi": SheetColumn("xi", (f"{xi:g}",), "1")}
    formulas = ("Kp = omega_n^2 * b", "Kd = 2 * xi * omega_n * b") if rng.random() < 0.5 else ()
    return SheetTable("gains", columns, values, declared=Declared(formulas=formulas))


def _errors(rng: Generator, n: int) -> SheetTable:
    decimals, absolute = int(rng.integers(1, 4)), rng.random() < 0.5
    columns = []
    for stem, unit in (("position error", "mrad"), ("velocity error", "mrad/s")):
        offset, scale = rng.normal(0, 6, (n, 1)), np.exp(rng.uniform(0, 4, (n, 1)))
        e = offset + scale * rng.normal(0, 1, (n, 60))
        mean = np.abs(e).mean(1) if absolute else e.mean(1)
        for word, v in (("average", mean), ("maximum", e.max(1)), ("minimum", e.min(1))):
            columns.append(SheetColumn(f"{stem} {word}", tuple(fixed(x, decimals) for x in v), unit))
    return SheetTable("errors", tuple(columns), declared=Declared(joints="revolute"))


def _masses(rng: Generator, n: int) -> SheetTable:
    kinds = np.exp(rng.uniform(-1.5, 2.5, n))
    mass = np.where(rng.random(n) < 0.3, kinds[0], kinds)
    decimals = int(rng.integers(2, 5))
    total = fixed(float(mass.sum()), decimals)
    cells = tuple(fixed(m, decimals) for m in mass)
    return SheetTable("masses", (SheetColumn("mass", cells, "kg"),), declared=Declared(totals={"mass": total}))


def _links(rng: Generator, n: int) -> list[SheetTable]:
    """DH rows, the same lengths as vectors, centres of mass with mirror images."""
    d = np.where(rng.random(n) < 0.4, 0.0, np.round(rng.uniform(0.05, 0.9, n), int(rng.integers(2, 5))))
    turn = rng.integers(0, 3, n)
    origin = [[f"{d[i] * rng.choice([1, -1]) if turn[i] == k else 0.0:g}" for k in range(3)] for i in range(n)]
    dh = SheetTable("dh", (SheetColumn("d", tuple(f"{x:g}" for x in d), "m"),))
    vectors = tuple(SheetColumn(f"r.{a}", tuple(row[k] for row in origin), "m", "r") for k, a in enumerate("xyz"))
    digits = int(rng.integers(4, 9))
    com = rng.normal(0, 0.08, (n, 3)) * (rng.random((n, 3)) < 0.8)
    texts = [[printed(x, digits) for x in row] for row in com]
    for i in range(1, n):
        if rng.random() < 0.3:
            texts[i] = [t if rng.random() < 0.5 or t == "0" else negated(t) for t in texts[i - 1]]
    centres = tuple(SheetColumn(f"c.{a}", tuple(row[k] for row in texts), "m", "c") for k, a in enumerate("xyz"))
    return [dh, SheetTable("frames", vectors), SheetTable("links", centres)]


def _limits(rng: Generator, n: int) -> SheetTable:
    upper = rng.choice([90, 110, 120, 130, 170, 180, 185, 350], n)
    lower = np.where(rng.random(n) < 0.7, -upper, -rng.choice([30, 45, 60, 135], n))
    effort, ratio = rng.choice([38, 100, 176, 200], n), rng.choice([50, 100, 110, 120, 160], n)
    lists = (("lower", lower, "deg"), ("upper", upper, "deg"), ("effort", effort, "N m"), ("gear_ratio", ratio, "1"))
    return SheetTable("limits", tuple(SheetColumn(k, tuple(str(x) for x in v), unit) for k, v, unit in lists))


def _noise(rng: Generator, n: int) -> SheetTable:
    """Columns that have nothing to do with each other, with few digits and many accidents."""
    lists = [[printed(x, int(digits)) for x in rng.lognormal(0, 1.5, n)] for digits in rng.integers(1, 5, 3)]
    return SheetTable("noise", tuple(SheetColumn(f"w{k}", tuple(cells)) for k, cells in enumerate(lists)))


def _tensors(rng: Generator, n: int) -> tuple[SheetMatrix, ...]:
    out = []
    for i in range(n):
        root = rng.normal(0, 0.1, (3, 3))
        tensor, d = root @ root.T, int(rng.integers(3, 7))
        cells = [[printed(x, d) for x in row] for row in tensor]
        upper = tuple(tuple(cells[min(r, c)][max(r, c)] for c in range(3)) for r in range(3))
        out.append(SheetMatrix(f"inertia, row {i + 1}, ", upper, symmetric=True))
    return tuple(out)


def _sums(rng: Generator, i: int) -> Sentence:
    a, b, c = (float(f"{x:.3g}") for x in rng.uniform(0.1, 90, 3))
    forms: tuple[tuple[str, float], ...] = (
        (f"{a:g} + {b:g} + {c:g}", a + b + c),
        (f"{a:g} x {b:g}^2 / {c:g}", a * b**2 / c),
        (f"hypot({a:g}, {b:g})", float(np.hypot(a, b))),
        (f"atan2({a:g}, {b:g} - {c:g})", float(np.degrees(np.arctan2(a, b - c)))),
    )
    text, value = forms[int(rng.integers(len(forms)))]
    return Sentence(f"sentence {i + 1}", f"so the value is {text} = {printed(value, int(rng.integers(2, 6)))} here")


def negated(text: str) -> str:
    """The number with the other sign."""
    return text[1:] if text.startswith("-") else f"-{text}"
