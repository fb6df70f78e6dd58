"""What is published: the recipe of conda names our dependencies, and a wheel or sdist that is not whole is seen."""

import re
import tomllib
from email.message import Message
from pathlib import Path

import pytest

from lwr_dyn.foundation.version import VERSION
from scripts.packaging.check_dist import FIELDS, WHOLE, faults

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
CONDA = {"pin": "pinocchio", "meshcat": "meshcat-python"}
"""Name on the index -> another name on conda-forge."""
GOOD = {"lwr_dyn/__init__.py", "lwr_dyn/codegen/emit/fmu.c"}


def metadata(*left_out):
    made = Message()
    for name in FIELDS:
        if name not in left_out:
            made[name] = "x"
    made.set_payload("what it is")
    return made


def test_the_recipe_has_our_version_and_the_first_bounds_of_our_dependencies():
    recipe = (ROOT / "scripts/packaging/recipe.yaml").read_text()
    assert f'version: "{VERSION}"' in recipe
    run = recipe.partition("  run:\n")[2].partition("\n\n")[0].splitlines()
    needed = {"python": PROJECT["requires-python"]}
    for text in PROJECT["dependencies"]:
        name, bound = re.match(r"([\w.-]+)(>=[\d.]+)", text).groups()
        needed.setdefault(CONDA.get(name, name), bound)
    assert dict(re.match(r"    - (\S+) (\S+)", line).groups() for line in run) == needed
    assert f"license: {PROJECT['license']}\n" in recipe
    assert all(f"    - {path}\n" in recipe for path in PROJECT["license-files"])


def test_a_whole_wheel_and_sdist_have_no_fault():
    wheel = GOOD | {"lwr_dyn-1.dist-info/METADATA"}
    assert list(faults(wheel, GOOD | set(WHOLE), metadata())) == []


@pytest.mark.parametrize(
    ("wheel", "sdist", "left_out", "fault"),
    [
        ({"tests/test_x.py"}, set(), (), "wheel: tests/test_x.py is no part of the package"),
        (set(), {"lwr_dyn/new.toml"}, (), "wheel: lwr_dyn/new.toml is missing"),
        ({"lwr_dyn/x.c"}, set(), (), "sdist: lwr_dyn/x.c is missing"),
        (set(), set(), ("Summary",), "metadata: no Summary"),
    ],
)
def test_a_fault_is_named(wheel, sdist, left_out, fault):
    assert list(faults(GOOD | wheel, GOOD | set(WHOLE) | sdist, metadata(*left_out))) == [fault]


def test_each_part_of_the_sdist_is_missed():
    assert list(faults(GOOD, GOOD, metadata())) == [f"sdist: {name} is missing" for name in WHOLE]
    assert all((ROOT / name).is_file() for name in WHOLE)
