"""Every data file of the package is installed with it: a pattern of pyproject.toml names it."""

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_every_data_file_is_installed():
    patterns = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]
    folders = {ROOT / package.replace(".", "/"): globs for package, globs in patterns.items()}
    named = {path for folder, globs in folders.items() for each in globs for path in folder.glob(each)}
    files = {path for path in (ROOT / "lwr_dyn").rglob("*") if path.is_file() and path.suffix != ".py"}
    files = {path for path in files if path.parent.name != "__pycache__"}
    assert {str(path.relative_to(ROOT)) for path in files - named} == set()
