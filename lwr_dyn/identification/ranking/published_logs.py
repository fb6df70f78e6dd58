"""Logs of real robots by address and digest, two of them here in small form; the others are fetched by the user.

A file is recognised by its SHA-256, whatever its name. `logs.toml` says who published a log, under
which licence, what its columns are, what load was on, and whether its torques were measured or computed.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, LogError, UnknownNameError
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.foundation.files import check_readable, read_text
from lwr_dyn.identification.logs.joint_log import JointLog, read_log
from lwr_dyn.identification.logs.ros_bags import joint_states

LARGEST = 64_000_000
"""Bytes of a file that is looked at for its digest."""
_NEEDED = "a log by its name, or a file of one"
_FOLDER = files("lwr_dyn.identification.ranking")
MEASURED, COMPUTED = "measured", "computed"


@dataclass(frozen=True, slots=True)
class LogFile:
    """A file of a published log: its path in the repository, its digest, and what stands where in it."""

    path: str
    sha256: str
    form: str
    width: int = 0
    header: int = 0
    columns: Mapping[str, tuple[int, int]] | None = None
    rows: tuple[int, int] | None = None
    joints: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class PublishedLog:
    """A log by its address; the fields are those of `logs.toml`.

    `step` [s] is that of its even clock; `cutoff` [Hz] and `spacing` [s] are of the filter under which sets are
    compared on it. `factors` (n,) take its torque columns to N m; `ratios` (n, n) and `home` (n,) [rad] take motors to
    joints.
    """

    name: str
    robot: str
    about: str
    address: str
    commit: str
    licence: str
    torques: str
    gains: str
    load: str
    step: float
    cutoff: float
    rows: int
    files: tuple[LogFile, ...]
    spacing: float = 0.01
    committed: str = ""
    sha256: str = ""
    factors: Array | None = None
    ratios: Array | None = None
    home: Array | None = None

    @property
    def source(self) -> str:
        """Whose it is, in a line."""
        return f"{self.address} {self.commit[:7]}, {self.licence}"

    def require_measured(self) -> None:
        """Raise `LogError` where its torques were computed: whoever computed them would win."""
        if self.torques != MEASURED:
            found = f"computed, not measured ({self.about}): they rank the table that they were computed from first"
            raise LogError(self.name, "torques", found, "a log of measured torques or currents")


@cache
def published_logs() -> Mapping[str, PublishedLog]:
    """Name -> log, in the order of `logs.toml`.

    >>> published_logs()["panda_gaz"].licence
    'GPL-3.0'
    """
    top = Fields(parse_toml((_FOLDER / "logs.toml").read_text("utf-8"), "logs.toml"), "logs.toml")
    logs = [_log(one) for one in top.tables("log")]
    top.refuse_unknown()
    return {log.name: log for log in logs}


def _log(of: Fields) -> PublishedLog:
    texts = {key: of.text(key) for key in ("name", "robot", "about", "address", "commit", "licence", "gains", "load")}
    optional = {key: of.text(key, "") for key in ("committed", "sha256")}
    numbers = {key: of.number(key, above=0.0) for key in ("step", "cutoff")}
    factors, motors = of.numbers("factors", ()), of.table("motors", {})
    ratios, home = None, None
    if motors.unread():
        ratios = np.array(motors.take("ratios", list), dtype=np.float64)
        home = np.radians(motors.row("home_deg", len(ratios)))
    out = PublishedLog(
        **texts, **optional, **numbers, torques=of.choice("torques", (MEASURED, COMPUTED)),
        rows=of.take("rows", int), files=tuple(_file(one) for one in of.tables("files")),
        spacing=of.number("spacing", 0.01, above=0.0), factors=np.array(factors) if factors else None,
        ratios=ratios, home=home,
    )  # fmt: skip
    of.refuse_unknown()
    return out


def _file(of: Fields) -> LogFile:
    form, rows, columns = of.choice("form", ("bag", "numbers")), of.take("rows", list, None), of.table("columns", {})
    out = LogFile(
        of.text("path"), of.text("sha256"), form, of.take("width", int, 0), of.take("header", int, 0),
        {key: _pair(columns.row(key, 2)) for key in columns.unread()}, None if rows is None else _pair(rows),
        of.texts("joints", ()),
    )  # fmt: skip
    of.refuse_unknown()
    return out


def _pair(values: Iterable[Any]) -> tuple[int, int]:
    first, last = map(int, values)
    return first, last


def digest_of_file(path: Path) -> str:
    """SHA-256 of a file; raises `FileAccessError`."""
    check_readable(path, _NEEDED, LARGEST)
    try:
        return sha256(path.read_bytes()).hexdigest()
    except OSError as fault:
        raise FileAccessError(str(path), str(fault.strerror).lower(), _NEEDED) from None


def recognised(path: str | Path) -> PublishedLog | None:
    """The published log that a file belongs to, by its digest; of a file of several the one with measured torques."""
    place = Path(path)
    if not place.is_file() or place.stat().st_size > LARGEST:
        return None
    digest = digest_of_file(place)
    found = [log for log in published_logs().values() if digest in (log.sha256, *(one.sha256 for one in log.files))]
    return next(iter(sorted(found, key=lambda log: log.torques != MEASURED)), None)


def published_log(name: str, folder: str | Path | None = None) -> tuple[PublishedLog, JointLog]:
    """A published log by its name, or by the path of a file of it, read in SI at the joints.

    Parameters
    ----------
    name : str
        Of `published_logs`, or a path.
    folder : str or path, optional
        Where its files lie, under any name; that of the given file, or the current one if not given.

    Raises
    ------
    UnknownNameError
        Neither a name nor a file of a published log.
    LogError
        Its torques are computed, or files of it are not in the folder: with their addresses.
    FileAccessError, MissingPackageError
        A file cannot be read; a bag without rosbags.
    """
    known = published_logs()
    log = known.get(name) or recognised(name)
    if log is None:
        raise UnknownNameError("log", name, known)
    log.require_measured()
    place = Path(name) if name not in known else None
    if place is not None and folder is None:
        folder = place.parent
    small = place is None and folder is None and log.committed
    if small or (place is not None and digest_of_file(place) == log.sha256):
        return log, replace(read_log(str(_FOLDER / "logs" / log.committed)), source=log.name)
    return log, _read(log, _found(log, Path("." if folder is None else folder)))


def _found(log: PublishedLog, folder: Path) -> Mapping[str, Path]:
    """Digest -> path of the files of a log in a folder."""
    digests: dict[str, Path] = {}
    if folder.is_dir():
        for path in sorted(folder.iterdir()):
            if path.is_file() and path.stat().st_size <= LARGEST:
                digests[digest_of_file(path)] = path
    missing = [one.path for one in log.files if one.sha256 not in digests]
    if missing:
        found = f"not in {folder}: {', '.join(missing)}"
        raise LogError(log.name, "files", found, f"them from {log.address} at {log.commit} ({log.licence})")
    return digests


def _read(log: PublishedLog, digests: Mapping[str, Path]) -> JointLog:
    """The log on its even clock: rows with a repeated time dropped, the others interpolated linearly."""
    columns: dict[str, Array] = {}
    for one in log.files:
        columns |= _FORMS[one.form](one, digests[one.sha256])
    q, tau = columns["q"], columns["tau"]
    if log.ratios is not None and log.home is not None:
        q, tau = np.linalg.solve(log.ratios, q.T).T + log.home, tau @ log.ratios
    if log.factors is not None:
        tau = tau * log.factors
    t = columns.get("time", np.arange(len(q))[:, None] * log.step)[:, 0]
    rises = np.concatenate([[True], np.diff(t) > 0.0])
    clock = np.arange(t[0], t[-1], log.step)
    q, tau = (np.column_stack([np.interp(clock, t[rises], x) for x in of[rises].T]) for of in (q, tau))
    return JointLog(log.name, tuple(range(1, q.shape[1] + 1)), clock - clock[0], q, tau)


def _numbers(one: LogFile, path: Path) -> dict[str, Array]:
    text = read_text(path, _NEEDED, "utf-8", LARGEST)
    lines = text.split("\n", one.header)[-1] if one.header else text
    table = np.array(lines.replace(",", " ").split(), dtype=np.float64).reshape(-1, one.width)
    first, last = one.rows or (1, len(table))
    return {key: table[first - 1 : last, a - 1 : b] for key, (a, b) in (one.columns or {}).items()}


def _bag(one: LogFile, path: Path) -> dict[str, Array]:
    """The topic of a bag with the joints."""
    states = next(states for states in joint_states(path) if set(one.joints) <= set(states.names))
    order = [states.names.index(name) for name in one.joints]
    position, effort = (states.fields[name][:, order] for name in ("position", "effort"))
    return {"time": (states.t - states.t[0])[:, None] * 1e-9, "q": position, "tau": effort}


_FORMS: Mapping[str, Callable[[LogFile, Path], dict[str, Array]]] = {"numbers": _numbers, "bag": _bag}
