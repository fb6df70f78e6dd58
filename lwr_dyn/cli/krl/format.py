"""`lwr-dyn krl format`: files with their layout in order."""

import sys
from pathlib import Path

import click

from lwr_dyn.foundation.files import write_files
from lwr_dyn.foundation.progress import progress
from lwr_dyn.krl.language.layout import INDENT, changed_lines, formatted
from lwr_dyn.krl.language.source import SourceFile, krl_files, read_source


@click.command("format")
@click.argument("paths", nargs=-1, required=True, metavar="PATH...")
@click.option("--check", "only_check", is_flag=True, help="Write nothing; exit 1 when a file would change.")
@click.option("--indent", type=click.IntRange(0, 8), default=INDENT, show_default=True, help="Spaces for each block.")
def format_files(paths: tuple[str, ...], only_check: bool, indent: int) -> None:
    """Put the layout of files (.src, .dat, .sub), or of all in a folder, in order; what they mean stays the same."""
    changes: dict[Path, tuple[SourceFile, int]] = {}
    files = list(dict.fromkeys(file for path in paths for file in krl_files(path)))
    with progress("formatting") as report:
        for i, path in enumerate(files):
            report(i / len(files))
            before, _ = read_source(path)
            after = formatted(before, indent)
            lines = len(changed_lines(before, after))
            if lines:
                changes[path] = (after, lines)
        if not only_check:
            write_files({path: file.to_bytes() for path, (file, _) in changes.items()})
    verb = "would change" if only_check else "changed"
    for path, (_, lines) in changes.items():
        click.echo(f"{path}: {lines} line{'s' * (lines != 1)} {verb}")
    click.echo(f"{len(files)} file{'s' * (len(files) != 1)}, {len(changes)} {verb}")
    sys.exit(1 if only_check and changes else 0)
