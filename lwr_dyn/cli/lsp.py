"""`lwr-dyn lsp`: one language server for KRL, URDF and xacro files; `lwr-dyn krl server` is another name of it."""

import sys

import click

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.editor.server import serve


@click.command("lsp")
@click.option("--names", multiple=True, help="A file of names that options bring, like krl/names/options.toml.")
@click.option("--stdio", is_flag=True, help="No effect; some editors add it.")
def command(names: tuple[str, ...], stdio: bool) -> None:
    """Serve an editor over stdin and stdout, by the Language Server Protocol; the editor starts it.

    Diagnoses as you type, without motion; hover with type and value; definitions, references, outline and folding.
    """
    if sys.stdin.isatty():
        raise OptionError("stdin", "a terminal", "an editor that speaks the Language Server Protocol")
    serve(names)
