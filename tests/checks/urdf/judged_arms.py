"""The public arms of three files, judged by hand: where their files lie on this machine, and their URDF texts.

An arm comes from an installed package (`example-robot-data==6.0.0`) or from a commit of a repository, whose checkout is
looked for as `OWNER+NAME/` in the folder that the environment variable LWR_DYN_ARMS names. The arms are not committed.
"""

import hashlib
import os
import re
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from lwr_dyn.arms.urdf.xacro_files import expand_xacro
from lwr_dyn.checks.urdf.hulls import mesh_path

ARMS_FILES = tuple(Path(__file__).parent / name for name in ("arms.toml", "newest_arms.toml", "last_arms.toml"))
ARMS_FOLDER = "LWR_DYN_ARMS"
_MESH = re.compile(r"""(<mesh\b[^>]*?\bfilename\s*=\s*["'])([^"']+)(["'])""")
_NAME = re.compile(r"<name>\s*([^<\s]+)")


@dataclass(frozen=True, slots=True, eq=False)
class JudgedArm:
    """A row of one of the files."""

    name: str
    source: str
    file: str
    arguments: Mapping[str, str]
    """Of a xacro."""
    sha256: str
    half: str
    """tuning | unused | fresh | latest | newest | last."""
    judgement: str
    """good | faulty."""
    moving: int
    faults: Mapping[str, str]
    """Link -> what is truly wrong there, as the numbers show."""

    @property
    def path(self) -> Path | None:
        """The file on this machine; None where it is not."""
        folder = _source_folder(self.source)
        path = None if folder is None else folder / self.file
        return path if path is not None and path.is_file() else None

    @property
    def is_as_judged(self) -> bool:
        """Whether the file on this machine is the one that was judged."""
        return self.path is not None and hashlib.sha256(self.path.read_bytes()).hexdigest() == self.sha256

    def text(self) -> str:
        """Its URDF, with the meshes that are there named by their full paths: they are not looked for at each plant."""
        if self.path.suffix == ".xacro":
            with _packages_beside(_source_folder(self.source)):
                text = expand_xacro(self.path, dict(self.arguments))
        else:
            text = self.path.read_text(encoding="utf-8")
        return _MESH.sub(self._full, text)

    def _full(self, found: re.Match[str]) -> str:
        place = mesh_path(found[2], self.path).path
        return found[0] if place is None else f"{found[1]}{place.resolve()}{found[3]}"


def judged_arms() -> tuple[JudgedArm, ...]:
    """The arms of all files."""
    names = ("name", "source", "file", "sha256", "half", "judgement", "moving")
    return tuple(
        JudgedArm(**{x: row[x] for x in names}, **{x: row.get(x, {}) for x in ("arguments", "faults")})
        for row in arm_rows()
    )


def arm_rows() -> list[dict]:
    """The rows of all files, as they stand there."""
    return [row for file in ARMS_FILES for row in tomllib.loads(file.read_text(encoding="utf-8"))["arm"]]


def _source_folder(source: str) -> Path | None:
    """The folder of a package, or of a repository's checkout."""
    if "@" in source:
        folder = os.environ.get(ARMS_FOLDER)
        return Path(folder) / source.partition("@")[0].replace("/", "+") if folder else None
    try:
        return Path(str(distribution(source.partition("==")[0]).locate_file("")))
    except PackageNotFoundError:
        return None


@contextmanager
def _packages_beside(folder: Path) -> Iterator[None]:
    """ROS_PACKAGE_PATH leads to the packages of a checkout, and of others of its owner, under their own names."""
    owner = folder.name.partition("+")[0]
    before = os.environ.get("ROS_PACKAGE_PATH")
    with tempfile.TemporaryDirectory() as links:
        for checkout in (folder, *sorted(folder.parent.glob(f"{owner}+*"))):
            for file in checkout.rglob("package.xml"):
                name = _NAME.search(file.read_text(encoding="utf-8", errors="replace"))
                if name and not (Path(links) / name[1]).exists():
                    (Path(links) / name[1]).symlink_to(file.parent)
        os.environ["ROS_PACKAGE_PATH"] = links
        try:
            yield
        finally:
            os.environ.pop("ROS_PACKAGE_PATH") if before is None else os.environ.update(ROS_PACKAGE_PATH=before)
