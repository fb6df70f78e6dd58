"""Try an installed wheel: the examples that the wheel itself carries, and the help of commands without one.

    python -m build && python -m venv fresh && fresh/bin/pip install dist/*.whl
    python scripts/wheel_smoke.py fresh

The commands run in empty folders without this checkout on their path. Helps and the example of the first page are
programs of their own; the others are forks of one process that has loaded the wheel. Where the extra that a command or
an option needs is not installed, it must say so in one line, with exit code 2; what needs none must do without. Exit
code 1 when something fails.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

READY = Path(__file__).resolve().parents[1] / "tests" / "docs" / "ready_command.py"
"""`lwr-dyn` as a fork of a process that has loaded it; it imports nothing of this checkout."""
LEFT_OUT = ("sensitivity", "reproduce", "gains", "new paper")
"""Slow commands, of which only the help is tried."""
FACTS = """
import json, lwr_dyn
from importlib.metadata import version
from lwr_dyn.cli.help_text import help_texts, schema_file
from lwr_dyn.cli.main import COMMANDS
print(json.dumps({
    "file": lwr_dyn.__file__, "versions": [version("lwr_dyn"), lwr_dyn.__version__],
    "commands": {name: COMMANDS[name].extra for name in COMMANDS.names},
    "texts": help_texts(), "schema": schema_file("simulate").is_file(), "robots": list(lwr_dyn.robots()),
}))
"""
OF_WORDS = {"--plot": "plots", "cell": "krl"}
"""Words of examples that need an extra."""
Run = Callable[[str, list[str]], tuple[int, str, str]]
"""(folder, words of a command) -> exit code, stdout, stderr."""


def is_missing(code: int, err: str, extra: str) -> bool:
    """Whether a command says in one line that it needs this extra."""
    says = f"is not installed; install it with: pip install 'lwr_dyn[{extra}]'"
    return bool(extra) and code == 2 and says in err and err.count("\n") == 1


def extra_of(line: str, commands: dict[str, str]) -> str:
    """The extra that an example needs, by its command or a word of it; empty for none."""
    words = line.split()
    return next((OF_WORDS[word] for word in words if word in OF_WORDS), commands[words[1]])


def examples(path: str, text: dict[str, Any]) -> list[tuple[str, int]]:
    """The examples of a command, with their exit codes; none where it is slow or needs a file of the user."""
    if path in LEFT_OUT or "files" in text:
        return []
    return [(each["run"], each.get("exit", 0)) for each in text["examples"]]


def faults(facts: dict[str, Any], run: Run) -> list[str]:
    """What fails, one line each; commands run two at a time, each in a folder of its own."""
    commands, texts = facts["commands"], facts["texts"]
    shown = {line.split()[1] for path, text in texts.items() for line, _ in examples(path, text)}
    others = [name for name in commands if name not in shown]
    with ThreadPoolExecutor(2) as pool:
        helps = pool.map(lambda name: _has_help(*run(name, ["lwr-dyn", name, "--help"]), commands[name]), others)
        out = [f"help of {name}" for name, holds in zip(others, helps, strict=True) if not holds]
        for found in pool.map(lambda path: _example_faults(path, texts[path], commands, run), texts):
            out += found
    return out


def _example_faults(path: str, text: dict[str, Any], commands: dict[str, str], run: Run) -> list[str]:
    out = []
    for line, expected in examples(path, text):
        code, _, err = run(path, line.split())
        if is_missing(code, err, extra_of(line, commands)):
            break  # later examples may take what this one would have written
        if code != expected:
            out.append(f"{line}: exit code {code}, not {expected}: {err[-300:]}")
    return out


def _has_help(code: int, out: str, err: str, extra: str) -> bool:
    return (code == 0 and out.startswith("Usage: lwr-dyn")) or is_missing(code, err, extra)


@contextmanager
def loaded(python: Path, folder: Path, variables: dict[str, str]) -> Iterator[list[str]]:
    """A process that has loaded all commands of the wheel; gives the words that begin a command which it forks."""
    door = folder / "ready"
    command = [str(python), "-P", str(READY), "serve", str(door)]
    with subprocess.Popen(command, env=variables, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        if process.stdout.readline() != b"ready\n":
            raise RuntimeError(f"{' '.join(command)} did not start")
        yield [str(python), "-IS", str(READY), str(door)]
        process.communicate()  # closes its stdin, with which it ends


def main(environment: Path) -> int:
    """Try the wheel of a virtual environment; gives the exit code."""
    programs, began = environment.resolve() / "bin", time.monotonic()
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with (
        tempfile.TemporaryDirectory() as folder,
        loaded(programs / "python", Path(folder), variables) as fork,
    ):

        def run(place: str, words: list[str]) -> tuple[int, str, str]:
            own = Path(folder, f"in {place}")
            own.mkdir(exist_ok=True)
            started = not place or words[0] != "lwr-dyn" or words[-1] == "--help"
            command = [str(programs / words[0]), *words[1:]] if started else [*fork, *words[1:]]
            done = subprocess.run(command, cwd=own, env=variables, capture_output=True, text=True)
            return done.returncode, done.stdout, done.stderr

        code, out, err = run("facts", ["python", "-c", FACTS])
        if code != 0:
            print(err)
            return 1
        facts = json.loads(out)
        found = faults(facts, run)
    if not Path(facts["file"]).is_relative_to(environment.resolve()):
        found.append(f"lwr_dyn comes from {facts['file']}")
    if len(set(facts["versions"])) != 1 or not facts["schema"] or not facts["robots"]:
        found.append(f"incomplete: {facts['versions']}, schema {facts['schema']}, robots {facts['robots']}")
    print("\n".join(found) or f"{len(facts['commands'])} commands hold, {time.monotonic() - began:.0f} s")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
