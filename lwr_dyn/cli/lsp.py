"""`lwr-dyn lsp`: one language server for KRL, URDF and xacro files; `lwr-dyn krl server` is another name of it."""

import os
import sys
from pathlib import Path

import click

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.editor.protocol.server import serve
from lwr_dyn.krl.editor.urdf_files import UrdfRemark


@click.command("lsp")
@click.option("--names", multiple=True, help="A file of names that options bring, like krl/names/options.toml.")
@click.option("--stdio", is_flag=True, help="No effect; some editors add it.")
def command(names: tuple[str, ...], stdio: bool) -> None:
    """Serve an editor over stdin and stdout, by the Language Server Protocol; the editor starts it.

    KRL (.src, .dat, .sub): diagnoses as you type, without motion; completion, signatures, hover with type and value,
    definitions, references, rename, call hierarchy, layout as `lwr-dyn krl format`, colours by meaning, names of inputs
    and outputs, quick fixes, outline, folding, search over the folder.

    URDF and xacro: the findings of `lwr-dyn lint`, with quick fixes. No code of a .xacro runs.
    """
    if sys.stdin.isatty():
        raise OptionError("stdin", "a terminal", "an editor that speaks the Language Server Protocol")
    serve(names, judged)


def judged(path: Path, text: str | None) -> list[UrdfRemark]:
    """The findings of a URDF or xacro file, without running a xacro's code; raises as `lint_file`."""
    from lwr_dyn.checks.urdf.document import document_of  # numerics: the server answers before they are there
    from lwr_dyn.checks.urdf.lint import lint_document, lint_file

    report = lint_file(path) if text is None else lint_document(document_of(text, str(path)))
    out = []
    for x in report.findings:
        what = f"{x.subject}: {x.what}" if x.subject else x.what
        sure = "" if x.sure == "certain" else f" ({x.sure})"
        lines = [what + sure, x.why, f"instead: {x.instead}" if x.instead else ""]
        message = "\n".join(line for line in lines if line)
        place, tag = x.place, x.instead if x.instead.startswith("<") else ""
        file = os.path.abspath(place.file or path)  # of a xacro, places are relative to where the server was started
        out.append(UrdfRemark(file, place.line, place.column, x.level, x.code, message, tag))
    return out
