"""`lwr-dyn origin`: which published set the numbers of a model file come from."""

import sys

import click

from lwr_dyn.checks.origin.link_numbers import numbers_of_file
from lwr_dyn.checks.origin.origin_document import origin_document
from lwr_dyn.checks.origin.tracing import trace_origin
from lwr_dyn.cli.options import show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.progress import progress


@click.command("origin")
@click.argument("file")
@with_shared("--json as_json")
def command(file: str, as_json: bool) -> None:
    """Which published set the numbers of FILE (.urdf, .xacro, .xml, .toml) come from, and where they differ.

    Masses, centres and tensors are traced by their digits to the sets of the robots of `lwr-dyn list`, whatever frames,
    axes and units the file has. Exit code 1 where it copies none of them.
    """
    with progress("tracing"):
        links = numbers_of_file(file)
        trace = trace_origin(links)
    show(origin_document(file, links, trace), as_json)
    sys.exit(0 if trace is not None and trace.is_copy else 1)
