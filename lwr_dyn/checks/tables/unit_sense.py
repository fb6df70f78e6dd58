"""Units that do not fit the quantity of a column: a joint's error in millimetres, a mass in metres."""

from collections.abc import Iterator

from lwr_dyn.checks.tables.dimensions import NUMBER, Powers, in_words, unit_of
from lwr_dyn.checks.tables.roles import words_of
from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetTable

_LENGTH, _ANGLE, _TIME, _MASS = "m", "rad", "s", "kg"
QUANTITIES: dict[str, tuple[str, ...]] = {
    "mass": (_MASS,), "masses": (_MASS,), "weight": (_MASS, "N"), "payload": (_MASS,),
    "inertia": ("kg m^2",), "armature": ("kg m^2", _MASS), "torque": ("N m",), "effort": ("N m", "N"), "force": ("N",),
    "length": (_LENGTH,), "distance": (_LENGTH,), "radius": (_LENGTH,), "height": (_LENGTH,), "reach": (_LENGTH,),
    "com": (_LENGTH,), "angle": (_ANGLE,), "alpha": (_ANGLE,), "theta": (_ANGLE,), "roll": (_ANGLE,), "yaw": (_ANGLE,),
    "time": (_TIME,), "duration": (_TIME,), "gravity": ("m/s^2",), "ratio": ("1",),
    "velocity": ("m/s", "rad/s"), "speed": ("m/s", "rad/s"), "acceleration": ("m/s^2", "rad/s^2"),
    "stiffness": ("N/m", "N m/rad"), "damping": ("N s/m", "N m s/rad"),
}  # fmt: skip
"""Word of a heading -> the units of what it names; the last such word of a heading counts."""
ERRORS = ("error", "errors", "err", "deviation")
_ALONG, _AROUND = (1.0, 0.0), (0.0, 1.0)
"""Powers of metre and radian of an error along and around a joint."""
ANGULAR_ALONE = {"rad", "rad/s", "rad/s^2"}
"""Units that differ from a number by the radian alone."""


def unit_sense(sheet: Sheet) -> Iterator[Finding]:
    """Rule 9: a column whose unit is not one of its quantity."""
    for table in sheet.tables:
        errors: dict[str, list[SheetColumn]] = {}
        for column in (*table.columns, *table.values.values()):
            if column.unit and _is_error_of_joints(table, column):
                errors.setdefault(column.unit, []).append(column)
            elif column.unit:
                yield from _quantity(table, column)
        for unit, columns in errors.items():
            yield from _joint_errors(table, unit, columns)


def _words(column: SheetColumn) -> list[str]:
    return words_of(column.group or column.name)


def _is_error_of_joints(table: SheetTable, column: SheetColumn) -> bool:
    """The heading or the table's title contains a word for errors, and the rows are joints."""
    words = set(_words(column)) | set(words_of(table.where))
    labelled = any({"joint", "joints"} & set(words_of(c.name)) for c in table.columns if c is not column)
    return bool(words & set(ERRORS)) and (bool(table.declared.joints) or labelled) and column.numeric


def _joint_errors(table: SheetTable, text: str, columns: list[SheetColumn]) -> Iterator[Finding]:
    unit, sliding, known = unit_of(text), table.declared.joints == "prismatic", bool(table.declared.joints)
    if unit is None or unit.powers[1] or (unit.powers[0], unit.powers[3]) not in (_ALONG, _AROUND):
        return
    if (unit.powers[0], unit.powers[3]) == (_ALONG if sliding else _AROUND):
        return
    right = text.replace("rad", "m") if sliding else text.replace("mm", "mrad") if "mm" in text else "rad or deg"
    why = "these joints slide" if sliding else "these joints turn" if known else "right for joints that slide only"
    cells = tuple(f"{table.name}, {column.name}" for column in columns)
    yield Finding(
        "unit", "error" if known else "warning", "certain" if known else "likely", cells, text, right,
        f"errors of joints are given in {text}: {why}, so {right} is expected",
        {"powers": list(unit.powers)}, f"{table.name}, {', '.join(c.name for c in columns)}",
    )  # fmt: skip


def _quantity(table: SheetTable, column: SheetColumn) -> Iterator[Finding]:
    words = [w for w in _words(column) if w in QUANTITIES]
    unit = unit_of(column.unit)
    if not words or unit is None or unit.powers == NUMBER:  # a share or a count of anything has the unit 1
        return
    allowed = QUANTITIES[words[-1]]
    if any(_fits(unit.powers, text) for text in allowed):
        return
    yield Finding(
        "unit", "error", "likely", (f"{table.name}, {column.name}",), column.unit, " or ".join(allowed),
        f"{column.name} is given in {column.unit} ({in_words(unit.powers)}); {words[-1]}: {' or '.join(allowed)}",
        {"powers": list(unit.powers)},
    )  # fmt: skip


def _fits(powers: Powers, text: str) -> bool:
    wanted = unit_of(text)
    if wanted is None:
        return False
    if text in ANGULAR_ALONE or (powers[3] and not any(powers[:2])):
        return powers == wanted.powers
    return powers[:3] == wanted.powers[:3]
