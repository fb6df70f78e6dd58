"""Constants that cannot be meant: an index outside of its array, a speed in mm/s, over 100 %."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import Severity
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.names.known_names import Type
from lwr_dyn.krl.project.program import Scope

FASTEST = 3.0
"""[m/s] $VEL_MA.CP, the largest path speed, as the robots are delivered."""
_SPEEDS = frozenset({"$VEL.CP", "LDAT.VEL", "BAS.VEL_CP", "BAS.CP_PARAMS", "SVEL_CP.1"})

_PERCENTS = frozenset({
    "$VEL_AXIS", "$ACC_AXIS", "$OV_PRO", "$OV_ROB", "$APO.CPTP", "$APO.CVEL", "PDAT.VEL", "PDAT.ACC", "LDAT.ACC",
    "BAS.VEL_PTP", "BAS.ACC_PTP", "BAS.PTP_PARAMS", "SVEL_JOINT.1",
})  # fmt: skip


def check_indices(scope: Scope, of: Type, x: e.Index) -> None:
    """Report constant indices before the first or after the last element."""
    for i, index in enumerate(x.indices):
        value = e.number_of(index)
        last = of.sizes[i] if i < len(of.sizes) else 0
        if value is not None and (value < 1 or (last and value > last)):
            name = place_of(scope, x.of)
            message = f"index {value:g} of {name}"
            scope.report(index.column or x.column, "index-range", message, f"1 to {last}" if last else "from 1")


def place_of(scope: Scope, x: e.Reference) -> str:
    """`$VEL.CP` for a component of a system variable, `LDAT.VEL` for one of another structure, else the name."""
    if isinstance(x, e.Index):
        return place_of(scope, x.of)
    if isinstance(x, e.Name):
        return x.name.upper()
    if isinstance(x.of, e.Name) and x.of.name.startswith("$"):
        return f"{x.of.name}.{x.name}".upper()
    whole = scope.variable(x.of.name) if isinstance(x.of, e.Name) else None
    return f"{'?' if whole is None else whole.name}.{x.name}".upper()


def check_value(scope: Scope, place: str, x: e.Expression | None) -> None:
    """Report a constant that is too large for a place such as `$VEL.CP`; of a structure, each component."""
    if isinstance(x, e.Aggregate):
        for item in x.items:
            check_value(scope, f"{place}.{item.name.upper()}", item.value)
        return
    value = e.number_of(x)
    if value is None or x is None:
        return
    name = place.removesuffix(".1")
    if place in _PERCENTS and value > 100.0:
        # bas.src multiplies what stands in PDAT and LDAT: more than 100 may work
        severity: Severity = "warning" if "DAT." in place else "error"
        scope.report(x.column, "percent-range", f"{name} = {value:g} %", "at most 100", severity)
    elif place in _SPEEDS and value > FASTEST:
        hint = f"in m/s, at most {FASTEST:g} as delivered"
        if value >= 10.0:
            hint += f"; {value:g} mm/s is {value / 1e3:g}"
        scope.report(x.column, "speed-unit", f"{name} = {value:g} m/s", hint, "warning")
