"""`lwr-dyn kernels`: the generated source of a batch function, its number of operations, the folder of kernels."""

import click

from lwr_dyn.cli.options import load_robot, print_json, robot_options
from lwr_dyn.codegen.kernel import require_packages
from lwr_dyn.codegen.kernel_spec import FUNCTIONS, function_shape, kernel_spec
from lwr_dyn.errors import OptionError
from lwr_dyn.files import cache_folder


@click.command("kernels")
@robot_options
@click.option("--emit", metavar="F", help=f"Print the source of one function: {', '.join(FUNCTIONS)}.")
@click.option("--inputs", default="", help="Inputs of the kernel: inertia,payload,gravity,friction.")
@click.option("--friction", default="none", show_default=True, help="none, or arm for the arm's own as constants.")
@click.option("--dtype", default="float64", show_default=True, help="float64 or float32.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(
    robot: str, reading: str | None, tip: str | None, locks: tuple[str, ...], emit: str | None, inputs: str,
    friction: str, dtype: str, as_json: bool,
) -> None:  # fmt: skip
    """Batch functions of ROBOT with their operations a state, or with --emit F the generated source of one."""
    if emit is not None and as_json:
        raise OptionError("--json", "with --emit", "one of them")
    if emit is not None:
        function_shape(emit)
    chosen = [name.strip() for name in inputs.split(",") if name.strip()]
    spec = kernel_spec(load_robot(robot, reading, tip, locks), chosen, friction, "armature", dtype)
    require_packages()
    from lwr_dyn.codegen.kernel_source import generate

    if emit is not None:
        click.echo(generate(spec, emit).text, nl=False)
        return
    interfaces = {name: generate(spec, name).interface for name in FUNCTIONS}
    if as_json:
        records = [
            {"name": name, "operations": x.operations, "fused": x.fused, "inputs": list(x.inputs), "result": x.width}
            for name, x in interfaces.items()
        ]
        print_json({"robot": spec.name, "dtype": dtype, "cache": str(cache_folder()), "functions": records})
        return
    from lwr_dyn.tables import aligned

    rows = [(n, str(x.operations), str(x.fused), FUNCTIONS[n].formula) for n, x in interfaces.items()]
    click.echo(f"{spec.name}, {dtype}; kept in {cache_folder()}")
    click.echo(aligned(rows, ("function", "operations", "with fused multiply-add", "gives")))
