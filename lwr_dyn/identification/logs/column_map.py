"""Column maps: what a file calls its columns, where it does not say time, q1, tau1 ...

    time = "stamp"                   # a name
    q = "joint_pos_*"                # the number of the joint, from 0 or 1, or its name, in place of the star
    tau = ["T_base", "T_elbow"]      # names in the order of the joints
    joints = ["base", "elbow"]       # what stands in place of a star, if neither numbers nor the robot's own names

    [units]
    time = "ms"
    q = "deg"

A quantity that is not in the map has our names. The unit of a mapped column stands in its name, `joint_pos_1 [deg]` or
`joint_pos_1 (deg)`, or in the map, or in `--units`; it is asked for, never guessed.
"""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError, LogError, OptionError
from lwr_dyn.foundation.files import read_text
from lwr_dyn.identification.logs.log_columns import UNITS, declared_units

NEEDED = "a map of columns: quantity = name, name with *, or list of names, and [units]"
_UNIT = re.compile(r"\s*[\[(]([^\])]*)[\])]\s*$")


@dataclass(frozen=True, slots=True)
class MappedColumns:
    """The columns of one file: our `names`, for the mapped ones the file's `own` (else ""), units of the map."""

    names: tuple[str, ...]
    own: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ColumnMap:
    """Quantity (time, q, dq, tau, qm, i) -> the names of its columns.

    Parameters
    ----------
    columns : mapping
        Quantity -> a name with a star, or names in the order of the joints (time: one name).
    units : mapping
        Quantity -> unit.
    joints : tuple of str
        What stands in place of the star, in the order of the joints; empty for numbers or the names of the robot.
    source : str
        Where the map is from.
    """

    columns: Mapping[str, tuple[str, ...]]
    units: Mapping[str, str] = field(default_factory=dict)
    joints: tuple[str, ...] = ()
    source: str = "--columns"

    def of(self, file: str, names: Sequence[str], joint_names: Sequence[str] = ()) -> MappedColumns:
        """What the columns of a file (`names`) are called here; `joint_names` are those of the robot, if it is known.

        Raises
        ------
        LogError
            No column has a mapped name, or one name fits two columns, or some joints are numbered from 0, some from 1.

        >>> ColumnMap({"q": ("pos_*",)}).of("run.csv", ["time", "pos_0 [deg]", "pos_1 [deg]", "q1"]).names
        ('time', 'q1 [deg]', 'q2 [deg]', '')
        """
        if not self.columns:
            return MappedColumns(tuple(names))
        bare = [_UNIT.sub("", name).strip() for name in names]
        found = {quantity: self._places(file, quantity, bare, joint_names) for quantity in self.columns}
        counted = [places for quantity, (places, numbers) in found.items() if numbers and quantity != "time"]
        from_zero = any(0 in places for places in counted)
        if from_zero and not all(0 in places for places in counted):
            raise LogError(file, "columns", "joints numbered from 0 and from 1", f"one numbering ({self.source})")
        place = {
            index: quantity if quantity == "time" else f"{quantity}{number + (from_zero and numbers)}"
            for quantity, (places, numbers) in found.items()
            for number, index in places.items()
        }
        ours = [
            place[i] + (f" [{unit[1]}]" if (unit := _UNIT.search(name)) else "") if i in place else self._kept(name)
            for i, name in enumerate(names)
        ]
        own = ["" if place.get(i, "") in ("", bare[i]) else name.strip() for i, name in enumerate(names)]
        return MappedColumns(tuple(ours), tuple(own), self.units)

    def _kept(self, name: str) -> str:
        """A column that is not mapped keeps its name, unless it stands in the way of a mapped quantity."""
        return "" if re.match(rf"^({'|'.join(self.columns)})\d*\s*(\[|$)", name) else name

    def _places(
        self, file: str, quantity: str, bare: Sequence[str], joint_names: Sequence[str]
    ) -> tuple[dict[int, int], bool]:
        """Joint -> index of its column, and whether the joint is a number in the name, counted as the file does."""
        wanted, numbers = self.columns[quantity], False
        if quantity != "time" and len(wanted) == 1 and "*" in wanted[0]:
            before, _, after = wanted[0].partition("*")
            pattern = re.compile(rf"^{re.escape(before)}(.+){re.escape(after)}$")
            stars = [(match[1], i) for i, name in enumerate(bare) if (match := pattern.match(name))]
            known = next((x for x in (self.joints, tuple(joint_names)) if any(star in x for star, _ in stars)), ())
            numbers = not known
            places = [(known.index(star) + 1, i) for star, i in stars if star in known]
            places += [(int(star), i) for star, i in stars if numbers and star.isdecimal()]
        else:
            places = [(k, i) for k, name in enumerate(wanted, 1) for i, other in enumerate(bare) if name == other]
            if len({k for k, _ in places}) < len(wanted):
                places = []
        if not places:
            raise LogError(
                file, f"columns of {quantity}", f"none fits {', '.join(wanted)}; the file has {', '.join(bare)}",
                f"names as in the file ({self.source})",
            )  # fmt: skip
        if len(dict(places)) < len(places):
            raise LogError(file, f"columns of {quantity}", "two for one joint", f"one each ({self.source})")
        return dict(places), numbers


NO_MAP = ColumnMap({})


def column_map(text: str | Path | None) -> ColumnMap:
    """A map from `q=joint_pos_*,tau=effort_*`, or from the file named by a path that ends in .toml.

    Raises
    ------
    OptionError
        A quantity or unit that does not exist, a name that is empty.
    FileAccessError
        The file cannot be read, or is not TOML.

    >>> column_map("time=stamp,q=joint_pos_*").columns["q"]
    ('joint_pos_*',)
    """
    if text is None:
        return NO_MAP
    if str(text).endswith(".toml"):
        return _from_file(str(text))
    parts = [part.partition("=") for part in str(text).split(",") if part.strip()]
    return _checked({quantity.strip(): [name.strip()] for quantity, _, name in parts}, "--columns")


def _from_file(path: str) -> ColumnMap:
    try:
        table = tomllib.loads(read_text(path, NEEDED))
    except tomllib.TOMLDecodeError as fault:
        raise FileAccessError(path, f"not TOML: {' '.join(str(fault).split())}", NEEDED) from None
    units, joints = table.pop("units", {}), table.pop("joints", [])
    if not isinstance(units, dict) or not all(isinstance(unit, str) for unit in units.values()):
        raise OptionError(f"{path}: units", repr(units), "a table of quantity = unit")
    if not isinstance(joints, list) or not all(isinstance(name, str) for name in joints):
        raise OptionError(f"{path}: joints", repr(joints), "a list of names")
    declared = declared_units(",".join(f"{quantity}={unit}" for quantity, unit in units.items()))
    named = {quantity: [names] if isinstance(names, str) else names for quantity, names in table.items()}
    return _checked(named, path, declared, tuple(joints))


def _checked(
    named: Mapping[str, object], source: str, units: Mapping[str, str] | None = None, joints: tuple[str, ...] = ()
) -> ColumnMap:
    columns = {}
    for quantity, names in named.items():
        if quantity not in UNITS:
            raise OptionError(source, repr(quantity), f"QUANTITY=NAME with {', '.join(UNITS)}")
        if not isinstance(names, list) or not names or not all(isinstance(name, str) and name for name in names):
            raise OptionError(f"{source}: {quantity}", repr(names), "a name, a name with *, or a list of names")
        columns[quantity] = tuple(names)
    return ColumnMap(columns, units or {}, joints, source)
