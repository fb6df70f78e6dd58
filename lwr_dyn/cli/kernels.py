"""`lwr-dyn kernels`: functions of an arm as C or JavaScript; the generated source and the cost of a batch function."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from lwr_dyn.cli.options import Loading, caveats, robot_options, say_caveats, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.codegen.emit.emission import EmittedArm
from lwr_dyn.codegen.kernels.kernel import require_packages
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS, KernelSpec, function_shape, kernel_spec
from lwr_dyn.foundation.document import Document, Fact, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import cache_folder, check_writable, write_files
from lwr_dyn.foundation.tables import Heading, Table, aligned
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True)
class WhereWritten:
    """The options that belong to --language."""

    language: str | None
    out: str | None
    prefix: str | None
    sincos: str | None
    vectors: str | None

    def check(self) -> None:
        """Raise `OptionError` where one is missing or stands alone."""
        for name in ("out", "prefix", "sincos", "vectors"):
            if self.language is None and getattr(self, name) is not None:
                raise OptionError(f"--{name}", "without --language", "--language c with --out FILE")
        if self.language is not None and self.out is None:
            raise OptionError("--language", "without --out", "--out FILE, the file to write")


@click.command("kernels")
@robot_options
@click.option("--language", metavar="L", help="Write functions of one state as c or js, into --out.")
@with_shared("--out", " FILE.c (and FILE.h), .js, .mjs, with --language")
@click.option("--emit", metavar="F,...", help="Functions for --language (all if not given); without, one to print.")
@click.option("--prefix", metavar="NAME", help="Names in the file begin with it; the robot's name if not given.")
@click.option("--sincos", metavar="own|libm", help="Sine and cosine in the file: own (the default) or the library's.")
@click.option("--vectors", metavar="FILE", help="Write states and results to test with, as JSON.")
@click.option("--inputs", default="", help="Inputs of the kernel: inertia,payload,gravity,friction.")
@click.option("--own-friction", is_flag=True, help="With the friction of the arm's file, as constants.")
@click.option("--dtype", default="float64", show_default=True, help="float64 or float32.")
@with_shared("--json as_json")
def command(
    robot: str,
    loading: Loading,
    emit: str | None,
    inputs: str,
    own_friction: bool,
    dtype: str,
    as_json: bool,
    **given: Any,
) -> None:
    """Functions of ROBOT as C or JavaScript; or those of a batch with their operations a state, or one's source."""
    where, language = WhereWritten(**given), given["language"]
    where.check()
    friction = "arm" if own_friction else "none"
    if (emit is not None or language is not None) and as_json:
        raise OptionError("--json", "with --emit" if language is None else "with --language", "one of them")
    chosen = _names(inputs)
    if language is not None:
        _write(loading.arm(robot), where, _names(emit or ""), chosen, friction, dtype)
        return
    if emit is not None:
        function_shape(emit)
    spec = kernel_spec(loading.arm(robot), chosen, friction, "armature", dtype)
    require_packages()
    if emit is not None:
        from lwr_dyn.codegen.kernels.kernel_source import generate

        click.echo("".join(f"# {line}\n" for line in caveats()) + generate(spec, emit).text, nl=False)
        return
    show(costs(spec), as_json)


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",") if name.strip()]


def _write(arm: Arm, where: WhereWritten, functions: list[str], inputs: list[str], friction: str, dtype: str) -> None:
    require_packages()
    from lwr_dyn.codegen.emit.emission import LANGUAGES, emitted_arm, vectors_text

    files_of = LANGUAGES.load(str(where.language))
    for path in filter(None, (where.out, where.vectors)):
        check_writable(path)
    emitted = emitted_arm(
        arm, functions, inputs=inputs, friction=friction, dtype=dtype, kind=where.sincos or "own",  # type: ignore[arg-type] # checked there
        prefix=where.prefix,
    )  # fmt: skip
    files: dict[Path, str | bytes] = {**files_of(emitted, Path(str(where.out)))}
    if where.vectors is not None:
        if Path(where.vectors).resolve() in {path.resolve() for path in files}:
            raise OptionError("--vectors", repr(where.vectors), "another file than those of --out")
        files[Path(where.vectors)] = vectors_text(emitted)
    write_files(files)
    say_caveats()
    click.echo(f"{', '.join(map(str, files))}: {emitted.spec.name}, {dtype}, {emitted.kind} sine and cosine")
    _print_written(emitted, arm.name if where.prefix is None else where.prefix, "_" if where.language == "c" else ".")


def _print_written(emitted: EmittedArm, asked: str, joined: str) -> None:
    """What the file holds, gains of laws left to it; `asked` is the name that functions should begin with."""
    from lwr_dyn.codegen.emit.further_functions import TUNED

    begin = f"{emitted.prefix}{joined}"
    if emitted.prefix != asked:
        click.echo(f"names begin with {begin}: {asked!r} is no identifier")
    straight = [(c.function, str(c.operations)) for c in emitted.codes]
    rows = [(f"{begin}{made.name}", operations, made.text.partition(TUNED)[0]) for made, operations in straight]
    rows += [(f"{begin}{t.name}", "", t.text.partition("\n")[0]) for t in emitted.templates]
    click.echo(aligned(rows, ("function", "operations", "gives")))
    for name, why in emitted.left_out:
        click.echo(f"left out: {name}: {why.removeprefix(f'{name}: ')}")


def costs(spec: KernelSpec) -> Document:
    """The functions of a batch and their operations a state."""
    from lwr_dyn.codegen.kernels.kernel_source import generate

    headings = (
        Heading("function", key="name"), Heading("operations", key="operations", says="Of one state."),
        Heading("with fused multiply-add", key="fused", says="The same where a product and a sum count as one."),
        Heading("gives", key=None), Heading(key="inputs", says="Names of its inputs, joint vectors first."),
        Heading(key="result", says="Numbers stored for one state."),
    )  # fmt: skip
    made = [(name, shape, generate(spec, name).interface) for name, shape in FUNCTIONS.items()]
    rows = [(name, x.operations, x.fused, shape.formula, x.inputs, x.width) for name, shape, x in made]
    cache = str(cache_folder())
    facts = [
        Fact("robot", spec.name, "Name of the robot."), Fact("dtype", spec.dtype, "Of all numbers."),
        Fact("cache", cache, "Folder in which compiled functions are kept."),
    ]  # fmt: skip
    table = Table("", headings, rows, key="functions", says="The functions of a batch.")
    title = f"{spec.name}, {spec.dtype}; kept in {cache}"
    return Document(title, "", [Section("", [table])], "lwr-dyn kernels", "kernels", facts)
