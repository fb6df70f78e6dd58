"""Run a page: its commands and its Python in a fresh folder, the output held against what the page shows.

`python -m tests.docs.console PAGE...` runs pages and prints how long each command took; `--update` writes the real
output into them. What a page may hold stands in CONTRIBUTING.md.
"""

from __future__ import annotations

import argparse
import atexit
import contextlib
import difflib
import doctest
import os
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from tests.docs import ready_command
from tests.docs.blocks import Block, Command, PageError, blocks, check_marks, matches, updated

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = "python scripts/examples/"
LIMIT = 300
"""Seconds after which a command is stopped."""
READY = "LWR_DYN_READY"
"""The variable that names the socket of a ready process which is there."""
CLOSED_PIPE = 141
"""Exit code (128 + SIGPIPE) of a command that still writes when `head` has what it wants: no fault, but a race."""


@cache
def ready() -> str:
    """The socket of the process that has loaded what commands load; it ends with this one, or is that of who asks."""
    if READY in os.environ:
        return os.environ[READY]
    folder = Path(tempfile.mkdtemp(prefix="ready_"))
    command = [sys.executable, ready_command.__file__, ready_command.SERVE, str(folder / "socket")]
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=surroundings(), start_new_session=True
    )
    assert process.stdin
    assert process.stdout
    atexit.register(shutil.rmtree, folder)
    atexit.register(process.wait)
    atexit.register(process.stdin.close)
    if process.stdout.readline() != b"ready\n":
        raise RuntimeError(f"{shlex.join(command)} did not start")
    return str(folder / "socket")


def environment(programs: Path, text: str) -> dict[str, str]:
    """The surroundings of a page's commands: `lwr-dyn` and `python` are this working tree and this interpreter.

    A warning that a program in Python causes is an error.
    """
    python = shlex.quote(sys.executable)
    begins = {"python": f"{python} -W error", "python3": python}
    if "lwr-dyn" in text:
        begins["lwr-dyn"] = f"{python} -IS {shlex.quote(ready_command.__file__)} {shlex.quote(ready())}"
    for name, begin in begins.items():
        program = programs / name
        program.write_text(f'#!/bin/sh\nexec {begin} "$@"\n', encoding="utf-8")
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return surroundings() | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}


def surroundings() -> dict[str, str]:
    """The variables of a command without the path of its programs."""
    path = os.pathsep.join(part for part in (str(ROOT), os.environ.get("PYTHONPATH")) if part)
    # a command that opens a page opens nothing here
    return os.environ | {"PYTHONPATH": path, "COLUMNS": "100", "TERM": "dumb", "BROWSER": "true"}


def run_command(command: Command, folder: Path, variables: dict[str, str]) -> tuple[list[str], int]:
    """What a command prints, stderr included, and its exit code.

    Raises `PageError` when it takes too long, or is an example that writes elsewhere than to `out/`.
    """
    there = {*os.listdir(folder), "out"}
    script = f"set -o pipefail\n{command.text}"
    try:
        done = subprocess.run(
            ["bash", "-c", script], cwd=folder, env=variables, text=True, timeout=LIMIT,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise PageError(f"line {command.line}: `{command.text}` ran longer than {LIMIT} s") from None
    if EXAMPLES in command.text and not there.issuperset(os.listdir(folder)):
        raise PageError(f"line {command.line}: `{command.text}` writes elsewhere than to out/")
    lines = done.stdout.rstrip("\n").splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    closed = done.returncode == CLOSED_PIPE and "| head" in command.text
    return lines, 0 if closed else done.returncode


def compare(command: Command, actual: list[str], code: int) -> None:
    """Raises `PageError` with a difference when output or exit code is not as the page shows."""
    if code != command.code or not matches(command.output, actual):
        difference = "\n".join(difflib.unified_diff(command.output, actual, "page", "real", lineterm="", n=3))
        raise PageError(
            f"line {command.line}: $ {command.text}\n"
            f"exit code {code}, the page says {command.code}\n{difference}\n"
            "if the real output is right: python -m tests.docs.console --update PAGE"
        )


class Session:
    """The Python blocks of one page: one namespace, in the page's folder."""

    def __init__(self, page: str) -> None:
        self.page = page
        self.names: dict[str, Any] = {"__name__": "__main__"}

    def execute(self, block: Block) -> None:
        """Run a `python` block; lines of a traceback are those of the page."""
        source = "\n" * (block.line - 1) + "\n".join(block.lines)
        exec(compile(source, self.page, "exec"), self.names)

    def examine(self, block: Block) -> None:
        """Run a `pycon` block as a doctest; raises `PageError` with what differs."""
        examples = doctest.DocTestParser().get_doctest(
            "\n".join(block.lines) + "\n", self.names, self.page, self.page, block.line - 1
        )
        said: list[str] = []
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
        if runner.run(examples, out=said.append, clear_globs=False).failed:
            raise PageError(f"line {block.line}:\n{''.join(said)}")
        self.names.update(examples.globs)


def write_file(block: Block, folder: Path) -> None:
    """The file that a block is."""
    path = folder / block.file
    if folder.resolve() not in path.resolve().parents:
        raise PageError(f"line {block.line}: {block.file} is outside the page's folder")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(block.lines) + "\n", encoding="utf-8")


def steps(text: str) -> Iterator[Block]:
    """The blocks of a page that do something; raises `PageError` for a mark without a reason."""
    for block in blocks(text):
        if block.reason == "":
            raise PageError(f"line {block.line}: no-run without a reason")
        if block.reason is None and (block.file or block.language in ("console", "python", "pycon")):
            yield block


def run_page(text: str, folder: Path, update: bool = False, report: Any = None, page: str = "page") -> str:
    """Run a page in an empty folder; returns its text, with the real output when `update`."""
    variables = environment(Path(tempfile.mkdtemp(prefix="programs_", dir=folder.parent)), text)
    session = Session(page)
    changes: list[tuple[Command, list[str], int]] = []
    (folder / "scripts").symlink_to(ROOT / "scripts")  # a page may run the examples of a clone
    with contextlib.chdir(folder):
        for block in steps(text):
            if block.file:
                write_file(block, folder)
            elif block.language == "console":
                for command in block.commands():
                    if not update:
                        check_marks(command)
                    start = time.perf_counter()
                    actual, code = run_command(command, folder, variables)
                    if report:
                        report(f"{time.perf_counter() - start:6.1f} s  {command.text.splitlines()[0]}")
                    if update:
                        changes.append((command, actual, code))
                    else:
                        compare(command, actual, code)
            else:
                (session.execute if block.language == "python" else session.examine)(block)
    return rewritten(text, changes) if update else text


def rewritten(text: str, changes: list[tuple[Command, list[str], int]]) -> str:
    """A page with the output of its commands replaced; blank lines after a command's output stay."""
    lines = text.split("\n")
    for command, actual, code in reversed(changes):
        start = command.first
        length = len(command.output) + bool(command.code)
        shown = updated(command.output, actual) + ([f"[{code}]"] if code else [])
        lines[start : start + length] = [f"{command.indent}{line}".rstrip() for line in shown]
    return "\n".join(lines)


def main() -> int:
    """Run the pages named; exit code 1 when one says what does not come true."""
    parser = argparse.ArgumentParser(description="Run the commands and the Python of Markdown pages.")
    parser.add_argument("pages", nargs="+", type=Path, metavar="PAGE")
    parser.add_argument("--update", action="store_true", help="Write the real output into the pages.")
    chosen = parser.parse_args()
    failed = 0
    for page in chosen.pages:
        text = page.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "page"
            folder.mkdir()
            try:
                new = run_page(text, folder, chosen.update, print, str(page))
            except PageError as error:
                print(f"{page}: {error}", file=sys.stderr)
                failed += 1
                continue
        if new != text:
            page.write_text(new, encoding="utf-8")
            print(f"updated {page}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
