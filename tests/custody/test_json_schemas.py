"""Each command's `--json` has a published JSON Schema, and what it prints agrees with it."""

import json
from importlib.resources import files

import click
import pytest
from jsonschema import Draft202012Validator

from lwr_dyn.cli.help_text import help_texts, schema_file
from scripts import build_schemas
from tests.custody.test_help_text import SINGLE, SLOW, WITH_JSON, arguments, example_of_json, make
from tests.json_schemas import disagreement, faults
from tests.optional import need

HOLD = "simulate lwr4plus --task hold --from-deg 0,30,0,-60,0,30,0 --duration 0.05"
RUNS = {
    "list": ("list",),
    "dh": ("dh kr30ha --convention modified",),
    "check": ("check lwr4",),
    "fk": ("fk lwr4 --q-deg 0,90,90,-90,0,90,0",),
    "margins": ("margins lwr4plus --poses 20",),
    "ik": ("ik kr30ha --xyz-mm 91,-1139,1392 --abc-deg 0,0,0",),
    "simulate": (f"{HOLD} --payload 3 --controller pid --encoder-bits 16 --mount ceiling --friction none",),
    "identify friction": ("identify friction wam7 moves_*.csv",),
    "krl check": ("krl check .",),
    "krl diff": ("krl diff two_points.src two_points.dat",),
    "parity": ("parity lwr4 --only mujoco",),
}
"""Records of other forms than those of the examples, which `test_help_text.py` prints."""
FILES = {"krl check": "two_points.src", "krl diff": "two_points.src", "identify friction": "moves_*.csv"}
ELSEWHERE = {"sensitivity", "reproduce", "sweep"}
"""Slow: tests of their packages look at what they print."""


def test_every_command_with_json_has_a_schema():
    need("llvmlite")  # of kernels, sweep, tune
    assert {path for path in WITH_JSON if schema_file(path).is_file()} == set(WITH_JSON)
    assert {path.replace(" ", "-") for path in WITH_JSON} == {
        entry.name.removesuffix(".json") for entry in (files("lwr_dyn.cli") / "schemas").iterdir()
    }
    by_example = {path for path in help_texts() if path not in SLOW and example_of_json(path)}
    assert set(WITH_JSON) - ELSEWHERE == by_example | set(RUNS)


@pytest.mark.parametrize("path", WITH_JSON)
def test_each_schema_is_one_and_demands_something(path, lwr_dyn_command):
    schema = json.loads(schema_file(path).read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    assert schema["title"] == f"lwr-dyn {path} --json"
    assert schema["required"]
    assert faults(path, {}) != []
    assert str(schema_file(path)) in lwr_dyn_command(*path.split(), "--help")[1]


@pytest.mark.slow
@pytest.mark.parametrize("path", RUNS)
def test_what_is_printed_agrees_with_the_schema(path, lwr_dyn_command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if path in FILES:
        make(FILES[path], lwr_dyn_command)
    for line in RUNS[path]:
        assert disagreement(path, lwr_dyn_command(*arguments(f"lwr-dyn {line}"), "--json")[1]) == []


def test_every_schema_is_generated():
    assert build_schemas.unlisted() == []


def test_commands_without_json_have_no_line_on_it(lwr_dyn_command):
    assert "Schema of --json" not in lwr_dyn_command("replay", "--help")[1]
    assert isinstance(SINGLE["replay"], click.Command)
