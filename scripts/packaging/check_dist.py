"""Look into a built wheel and sdist: does the wheel hold the package alone, and the sdist the whole project?

    python -m build && python scripts/packaging/check_dist.py dist

A file of lwr_dyn/ that is in one of the two and not in the other is a fault, as is a folder of the project that the
sdist lacks, a test in the wheel, or a field of the metadata that is empty (author and address are the owner's:
docs/releasing.md). Exit code 1 with a line a fault.
"""

import sys
import tarfile
import zipfile
from collections.abc import Iterator
from email.message import Message
from email.parser import Parser
from pathlib import Path, PurePosixPath

FIELDS = (
    "Name", "Version", "Summary", "License-Expression", "License-File", "Requires-Python", "Keywords", "Classifier",
    "Requires-Dist", "Provides-Extra", "Description-Content-Type",
)  # fmt: skip
"""What the metadata must say."""
WHOLE = (
    "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "README.md", "pyproject.toml", ".importlinter",
    "docs/index.md", "models/lwr4plus/lwr4plus.urdf", "scripts/build_models.py", "tests/conftest.py",
    "tests/model/test_arm.py",
)  # fmt: skip
"""Of the sdist: a file of each part of the project."""
PACKAGE = "lwr_dyn"


def names_in_sdist(path: Path) -> set[str]:
    """The files of an sdist, without its first folder."""
    with tarfile.open(path) as archive:
        return {str(PurePosixPath(*PurePosixPath(x.name).parts[1:])) for x in archive if x.isfile()}


def faults(wheel: set[str], sdist: set[str], metadata: Message) -> Iterator[str]:
    """A line each, of the names in both archives and the metadata of the wheel."""
    for name in sorted(wheel):
        top = PurePosixPath(name).parts[0]
        if top != PACKAGE and not top.endswith(".dist-info"):
            yield f"wheel: {name} is no part of the package"
    ours = [{x for x in names if x.startswith(f"{PACKAGE}/")} for names in (wheel, sdist)]
    for where, lacking in (("wheel", ours[1] - ours[0]), ("sdist", ours[0] - ours[1])):
        yield from (f"{where}: {name} is missing" for name in sorted(lacking))
    yield from (f"sdist: {name} is missing" for name in WHOLE if name not in sdist)
    yield from (f"metadata: no {name}" for name in FIELDS if not metadata.get(name))
    if not str(metadata.get_payload()).strip():
        yield "metadata: no description"


def main() -> None:
    """Command line."""
    folder = Path(sys.argv[1])
    (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        (place,) = (x for x in names if x.endswith(".dist-info/METADATA"))
        metadata = Parser().parsestr(archive.read(place).decode())
    found = list(faults(names, names_in_sdist(sdist), metadata))
    print("\n".join(found) or f"{wheel.name}, {sdist.name}: whole")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
