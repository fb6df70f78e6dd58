"""What `--help` shows: examples that run, options in groups, and near names of misspelt commands."""

import re
import shlex
from glob import glob

import click
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.urdf import parse, xacro_bounds
from lwr_dyn.checks.tables import rules
from lwr_dyn.checks.urdf import hulls
from lwr_dyn.cli import main
from lwr_dyn.cli.help_text import FEW, ROBOT, help_texts
from lwr_dyn.foundation import column_files, files
from lwr_dyn.foundation.document import Document
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.foundation.registry import Row
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.krl.language import lexer, source
from lwr_dyn.krl.running import motions, running_program
from lwr_dyn.model import run
from lwr_dyn.model.chain import with_payload
from tests.cli.krl.test_write import TASK
from tests.identification.conftest import START, _fourier
from tests.identification.elastic_plants import elastic_log
from tests.identification.plants import perturbed_plant, random_motion
from tests.identification.simulated import ideal_cruise
from tests.json_schemas import disagreement
from tests.optional import missing_packages, skipped_for

SLOW = {"sensitivity", "reproduce", "sweep", "krl server", "lsp"}
"""Half a minute and more, or until an editor ends it; tests of their packages run them."""


def all_commands():
    """Command path -> command, those inside groups too; without those whose package a test may lack."""
    found = {}
    for name in main.COMMANDS.names:
        try:
            command = main.COMMANDS.load(name)
        except MissingPackageError as fault:
            if skipped_for(missing_packages(fault)) is None:
                raise
            continue
        found[name] = command
        if isinstance(command, click.Group):
            context = click.Context(command)
            found |= {f"{name} {each}": command.get_command(context, each) for each in command.list_commands(context)}
    return found


SINGLE = {path: command for path, command in all_commands().items() if not isinstance(command, click.Group)}
WITH_JSON = [path for path, command in SINGLE.items() if any("--json" in p.opts for p in command.params)]
NO_JSON = {"dh --out", "identify friction --plot", "kernels --emit", "kernels --language", "margins --plot"}
"""Options of examples that have no record, or say more beside it."""


def example_of_json(path):
    """The example of a command that is run with `--json`: its last one that can, None if it has no record."""
    own = [each for each in help_texts()[path]["examples"] if each["run"].startswith(f"lwr-dyn {path} ")]
    can = [each for each in own if NO_JSON.isdisjoint(f"{path} {word}" for word in each["run"].split())]
    return can[-1] if can and path in WITH_JSON else None


def make(name, lwr_dyn_command):
    """A file of the user that an example reads."""
    wam = lwr_dyn.load("wam7")
    if name == "moves_*.csv":
        for i, speed in enumerate((-0.3, -0.1, 0.1, 0.3)):
            write_log(f"moves_{i}.csv", ideal_cruise(wam.friction, speed * np.eye(7)[0], wam, START))
    elif name == "any_motion.csv":
        write_log(name, _fourier(wam, wam.friction))
    elif name == "both_sides.csv":
        lwr, rng = lwr_dyn.load("lwr4plus", "physical"), np.random.default_rng(0)
        plant, motion = perturbed_plant(TorqueColumns(lwr.chain), lwr, rng), random_motion(lwr, 5.0, rng, rate=500.0)
        write_log(name, elastic_log(plant, lwr.elasticity, motion, 0.1, rng, 1e-5))
    elif name == "with_load.csv":
        write_log(name, _fourier(wam.with_chain(with_payload(wam.chain, 1.5, (0.0, 0.02, 0.06))), wam.friction))
    else:
        with open("task.toml", "w", encoding="utf-8") as file:
            file.write(TASK.replace("TwoPoint", "two_points"))
        if name != "task.toml":
            assert lwr_dyn_command("krl", "write", "task.toml")[0] == 0


def arguments(line):
    """The words after `lwr-dyn`, with files for patterns."""
    words = shlex.split(line)
    assert words[0] == "lwr-dyn"
    return [each for word in words[1:] for each in (sorted(glob(word)) if "*" in word else [word])]


@pytest.mark.slow
@pytest.mark.parametrize("path", [path for path in help_texts() if path not in SLOW])
def test_the_examples_run(path, lwr_dyn_command, tmp_path, monkeypatch):
    """One of them with `--json`: its record agrees with the schema, and what it describes has a text too."""
    monkeypatch.chdir(tmp_path)
    described, record = [], Document.record
    monkeypatch.setattr(Document, "record", lambda self: described.append(self) or record(self))
    for name in help_texts()[path].get("files", ()):
        make(name, lwr_dyn_command)
    for example in help_texts()[path]["examples"]:
        as_json = example == example_of_json(path)
        code, out, err = lwr_dyn_command(*arguments(example["run"]), *["--json"] * as_json)
        assert code == example.get("exit", 0), (example, err)
        assert "Traceback" not in err
        assert out or code
        if as_json:
            assert disagreement(path, out) == []
            assert [bool(each.text()) for each in described] == [True] or path == "lint"  # whose text is not of it


@pytest.mark.parametrize("path", SINGLE)
def test_every_command_has_one_to_three_examples_of_itself(path, lwr_dyn_command):
    examples = help_texts()[path]["examples"]
    assert 1 <= len(examples) <= 3
    assert any(example["run"].startswith(f"lwr-dyn {path}") for example in examples)
    text = lwr_dyn_command(*path.split(), "--help")[1]
    for example in examples:
        assert f"  $ {example['run']}" in text


def test_the_table_names_only_commands():
    loaded = {path.split()[0] for path in SINGLE}
    lacking = {name for name in main.COMMANDS.names if name not in loaded}
    assert set(help_texts()) - lacking == {"", *SINGLE}


MB, GB = 10**6, 10**9
KRL = {200 * MB: source.LARGEST, 8192: lexer.LONGEST, 100: lexer.DEEPEST}
LIMITS = {
    "": {64 * MB: files.LARGEST},
    "check": {64 * MB: files.LARGEST, 100: parse._DEEPEST, 256 * MB: hulls._LARGEST},
    "lint": {
        64 * MB: files.LARGEST,
        100: parse._DEEPEST,
        256 * MB: hulls._LARGEST,
        20 * MB: rules.LARGEST,
        1 * MB: xacro_bounds.LARGEST_FILE,
    },
    "replay": {2 * GB: run.LARGEST},
    "compare": {2 * GB: run.LARGEST},
    "identify friction": {2 * GB: column_files.LARGEST},
    "identify motion": {2 * GB: column_files.LARGEST},
    "identify table": {2 * GB: column_files.LARGEST},
    "identify elastic": {2 * GB: column_files.LARGEST},
    "identify payload": {2 * GB: column_files.LARGEST},
    "krl check": KRL,
    "krl run": KRL | {40: running_program.DEEPEST, 100_000: running_program.LARGEST_ARRAY, 10**7: motions.LONGEST_WAIT},
}
"""Command -> the numbers that its help states, and those of the code."""


def test_limits_in_the_help_are_those_of_the_code(lwr_dyn_command):
    assert {path for path, texts in help_texts().items() if "limits" in texts} == set(LIMITS)
    for path, limits in LIMITS.items():
        words = help_texts()[path]["limits"]
        stated = [int(x) * {"MB": MB, "GB": GB, "": 1}[unit] for x, unit in re.findall(r"(\d+)(?: (MB|GB))?", words)]
        assert stated == list(limits) == list(limits.values())
        shown = " ".join(lwr_dyn_command(*path.split(), "--help")[1].split())
        assert f"Limits: {words} " in shown


@pytest.mark.parametrize("path", SINGLE)
def test_each_option_is_in_one_group(path, lwr_dyn_command):
    options = [p for p in SINGLE[path].params if isinstance(p, click.Option)]
    text = lwr_dyn_command(*path.split(), "--help-all" if "short" in help_texts()[path] else "--help")[1]
    sections = [line.rstrip(":") for line in text.splitlines() if line.endswith(":") and not line.startswith(" ")]
    for option in options:
        assert sum(line.split(" ")[2] == option.opts[0] for line in text.splitlines() if line.startswith("  -")) == 1
    if len(options) >= 2 * FEW:
        assert len(sections) >= 4
        assert ("Options" in sections, ROBOT in sections) == (False, "--reading" in text or "--robot" in text)
    starts = help_texts()[path].get("groups", {})
    assert set(starts.values()) <= {option.opts[0] for option in options}
    assert set(starts) <= set(sections)


def test_simulate_has_the_groups_of_its_parts(lwr_dyn_command):
    text = lwr_dyn_command("simulate", "--help-all")[1]
    parts = ("Task", "Controller", "Plant", "Sensors", "Solver", "Output", ROBOT)
    places = [text.index(f"\n{part}:\n") for part in parts]
    assert places == sorted(places)
    of_task, of_controller = (text[places[i] : places[i + 1]] for i in (0, 1))
    assert ("--duration" in of_task, "--ki" in of_task) == (True, False)
    assert ("--duration" in of_controller, "--ki" in of_controller) == (False, True)


@pytest.mark.parametrize(
    ("words", "near"),
    [
        (("simulat",), "simulate"),
        (("new", "controler"), "controller"),
        (("krl", "chek"), "check"),
        (("identify", "frction"), "friction"),
    ],
)
def test_a_misspelt_command_is_answered_with_the_name_it_resembles(words, near, lwr_dyn_command):
    code, out, err = lwr_dyn_command(*words, "x")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"no command named '{words[-1]}' (did you mean {near}?)" in err


def completed(line, monkeypatch, capsys):
    monkeypatch.setenv("_LWR_DYN_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(line.split(" ")) - 1))
    with pytest.raises(SystemExit):
        main.main([])
    out, err = capsys.readouterr()
    assert err == ""
    return {entry.split(",")[1] for entry in out.split()}


def test_a_shell_completes_nothing_where_an_extra_is_missing(monkeypatch, capsys):
    monkeypatch.setitem(main.COMMANDS.rows, "dream", Row("lwr_dyn.cli.main:dream", "Of a module that is broken."))
    assert completed("lwr-dyn dream x", monkeypatch, capsys) == set()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("lwr-dyn simu", {"simulate"}),
        ("lwr-dyn krl wr", {"write"}),
        ("lwr-dyn simulate lwr4plus --controller inv", {"inverse-dynamics"}),
        ("lwr-dyn nonsense x", set()),
        ("lwr-dyn check lwr4p", {"lwr4plus"}),
    ],
)
def test_a_shell_completes(line, words, monkeypatch, capsys):
    assert completed(line, monkeypatch, capsys) == words
