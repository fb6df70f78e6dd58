"""One step of RK4 under a held torque as a single call at C level: the method of `simulation.integrators.held_rk4`.

The text of forward dynamics stands in it once and is called four times. The numbers of the tableau come with each call,
so that one code serves every step of time; a step that would end outside the bounds writes nothing.
"""

from collections.abc import Callable, Sequence

import numpy as np

from lwr_dyn.codegen.kernels.scalar_code import fused_lines
from lwr_dyn.codegen.kernels.single_state import Call, Signature, closed_because, single_call
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.integrators import BoundedStep, held_rk4, second_order_tables

_STAGES = len(second_order_tables(1.0))

_TEXT = """{forward}

define internal double @body(ptr %now, ptr %tau, ptr %table, ptr %bounds, ptr %after) noinline {{
  %state = alloca [{two} x double]
  %dq.now = getelementptr double, ptr %now, i64 {n}
  %dq.state = getelementptr double, ptr %state, i64 {n}
{lines}
  %known = fcmp oeq double %flag{last}, 0.0
  %is.good = and i1 %known, {inside}
  br i1 %is.good, label %good, label %bad
good:
{stores}
  ret double 0.0
bad:
  ret double 1.0
}}"""


def held_step_text(n: int, forward: str) -> str:
    """The body for `single_state.module_text`; `forward` is the text of a function @forward of (q, dq, tau)."""
    two = [("0", "now", j) for j in range(2 * n)]
    lines = [line for name, of, j in two for line in _load(f"x{name}.{j}", of, j)]
    places, stores, inside = 0, list[str](), "true"
    for stage, table in enumerate(second_order_tables(1.0), start=1):
        state, dq = ("%now", "%dq.now") if stage == 1 else ("%state", "%dq.state")
        lines += [
            f"  %k{stage} = alloca [{n} x double]",
            f"  %f{stage} = call double @forward(ptr {state}, ptr {dq}, ptr %tau, ptr %k{stage})",
            f"  %flag{stage} = fadd double {f'%flag{stage - 1}' if stage > 1 else '0.0'}, %f{stage}",
        ]
        lines += [line for j in range(n) for line in _load(f"a{stage}.{j}", f"k{stage}", j)]
        for row, coefficients in enumerate(table):
            columns = (np.flatnonzero(coefficients[row + 1 :]) + row + 1).tolist()
            used = {column: place for place, column in enumerate(columns, start=places)}
            places += len(used)
            lines += [x for place in used.values() for x in _load(f"c{place}", "table", place)]
            for j in range(n):
                made, value = _combination(f"s{stage}.{row}.{j}", used, row, j, n)
                lines += made
                if stage < _STAGES:
                    lines += _store(f"e{stage}.{row}.{j}", "state", row * n + j, value)
                    continue
                stores += _store(f"e{row}.{j}", "after", row * n + j, value)
                made, inside = _inside(row * n + j, 2 * n, value, inside)
                lines += made
    return _TEXT.format(
        forward=forward, two=2 * n, n=n, lines="\n".join(lines), stores="\n".join(stores), last=_STAGES, inside=inside
    )


def step_table(d: float) -> Array:
    """The numbers of a step of d [s] in the order in which the text takes them; ones and zeros stand in the text."""
    rows = [
        full[row + 1 :][unit[row + 1 :] != 0.0]
        for full_table, unit_table in zip(second_order_tables(d), second_order_tables(1.0), strict=True)
        for row, (full, unit) in enumerate(zip(full_table, unit_table, strict=True))
    ]
    return np.concatenate(rows)


def _combination(name: str, used: dict[int, int], row: int, j: int, n: int) -> tuple[list[str], str]:
    """The j-th entry of q (row 0) or dq (row 1) of a stage: the start, and what is known times the table's numbers."""
    value, lines = f"%x0.{row * n + j}", list[str]()
    for column, place in used.items():
        known = f"%x0.{n + j}" if column == 1 else f"%a{column - 1}.{j}"
        lines += [f"  {line}" for line in fused_lines(f"{name}.{place}", f"%c{place}", known, value)]
        value = f"%{name}.{place}"
    return lines, value


def _inside(j: int, width: int, value: str, others: str) -> tuple[list[str], str]:
    """Whether entry j of the end, and all others, are within their bounds; NaN is not."""
    lines = [*_load(f"low{j}", "bounds", j), *_load(f"high{j}", "bounds", width + j)]
    lines += [
        f"  %above{j} = fcmp oge double {value}, %low{j}", f"  %below{j} = fcmp ole double {value}, %high{j}",
        f"  %both{j} = and i1 %above{j}, %below{j}", f"  %inside{j} = and i1 {others}, %both{j}",
    ]  # fmt: skip
    return lines, f"%inside{j}"


def _load(name: str, of: str, j: int) -> list[str]:
    return [f"  %{name}.p = getelementptr double, ptr %{of}, i64 {j}", f"  %{name} = load double, ptr %{name}.p"]


def _store(name: str, of: str, j: int, value: str) -> list[str]:
    return [f"  %{name} = getelementptr double, ptr %{of}, i64 {j}", f"  store double {value}, ptr %{name}"]


def held_step(
    n: int,
    parts: Sequence[str],
    forward_text: Call,
    forward: Call,
    h: float,
    substeps: int,
    bounds: tuple[Array, Array],
) -> BoundedStep | None:
    """RK4 over h [s] without friction; None where there are no calls at C level.

    Parameters
    ----------
    n : int
        Joints.
    parts : sequence of str
        All on which forward dynamics depend.
    forward_text : callable
        Gives the text of @forward.
    forward : callable
        The same function of single states, which serves a state whose flag is not zero.
    bounds : two (2, n) arrays
        The least and the largest state with which a step may end.
    """
    if closed_because():
        return None
    d = h / substeps
    table = step_table(d)
    slow, _ = held_rk4(forward, n, d)
    signature = Signature(((2, n), (n,), table.shape, (2, 2, n), (2, n)), None)

    def behind(now: Array, tau: Array, table: Array, bounds: Array, after: Array) -> bool | None:
        slow(0.0, now, tau, after)
        return None if ((after >= bounds[0]) & (after <= bounds[1])).all() else False

    one: Callable[..., bool | None] = single_call(
        "held_step", signature, parts, lambda: held_step_text(n, forward_text()), behind
    )
    limits, free = np.array(bounds, dtype=np.float64), np.full((2, 2, n), np.inf)
    free[0] = -np.inf
    if substeps == 1:
        return lambda now, tau, after: one(now, tau, table, limits, after)

    def step(now: Array, tau: Array, after: Array) -> bool | None:
        last = now
        for _ in range(substeps - 1):
            if one(last, tau, table, free, after) is not None:
                return False
            last = after
        return one(last, tau, table, limits, after)

    return step
