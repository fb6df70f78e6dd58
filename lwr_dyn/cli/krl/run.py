"""`lwr-dyn krl run`: cycle time, motions, speeds and torques of a program."""

import sys

import click

from lwr_dyn.cli.krl.options import SharedOptions, shared_options
from lwr_dyn.cli.krl.run_report import run_record, run_text
from lwr_dyn.cli.options import print_json
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable
from lwr_dyn.foundation.progress import progress
from lwr_dyn.krl.diagnostics import has_no_error
from lwr_dyn.krl.running.run import run_program


@click.command("run")
@click.argument("file")
@shared_options
@click.option("--out", help="The run file, .npz.")
@click.option("--html", help="A page that replays the run beside the program.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def run(file: str, shared: SharedOptions, out: str | None, html: str | None, as_json: bool) -> None:
    """Run FILE.src on the model: cycle time, a line for each motion, peak speeds, static and dynamic torque."""
    for path, ending in ((out, ".npz"), (html, ".html")):
        if path is not None:
            if not path.endswith(ending):
                raise FileAccessError(path, f"does not end in {ending}", f"a path that ends in {ending}")
            check_writable(path)
    program = shared.program(file)
    arm = shared.arm(program)
    with progress(f"running {file}"):
        result = run_program(program, arm, shared.machine(arm), shared.inputs, shared.cell)
    if out is not None:
        result.to_run().save(out)
    if html is not None:
        from lwr_dyn.krl.page.program_page import write_program_page

        write_program_page(html, result, program)
    if as_json:
        print_json(run_record(result))
    else:
        click.echo(run_text(result))
        for path in filter(None, (out, html)):
            click.echo(f"wrote {path}")
    sys.exit(0 if has_no_error(result.diagnostics) else 1)
