"""An arm, or a control law at samples, as an FMU: C sources with the functions of FMI 2.0 or 3.0 around them.

A plant has the states q and dq and follows B(q) ddq = tau - tau_f - C dq - g, in model exchange and co-simulation (by
Runge and Kutta's fourth order). A controller is sampled: at each step of co-simulation it takes its inputs and gives
the torque. A master that steps all FMUs in parallel therefore adds a delay of one sample; one that steps plant and
controller in turn does not.
"""

import hashlib
import platform
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from lwr_dyn.codegen.emit.c_file import c_files
from lwr_dyn.codegen.emit.emission import EmittedArm, emitted_arm, identifier, provenance_lines
from lwr_dyn.codegen.emit.fmu_description import FmuVariable, build_description, model_description
from lwr_dyn.codegen.emit.functions import EMITTED
from lwr_dyn.codegen.emit.tangents import with_tangents
from lwr_dyn.codegen.rollouts.law_forms import law_form
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.foundation.errors import MissingPackageError, OptionError, UnknownNameError
from lwr_dyn.model.arm import Arm

VERSIONS = ("2", "3")
STEP = "step_"
"""Names of the functions of laws begin with it."""
RATE = 1000.0
"""Of a controller, where nothing else is said [Hz]."""
UNLIMITED = 1e9
"""Stands for a torque limit that is not known [N m or N]."""
LARGEST_STEP = 1e-4
"""Of the plant's own integration in co-simulation [s], where nothing else is set."""
FRICTION_WIDTH = 0.01
"""Of tanh(dq / width), where nothing else is set [rad/s or m/s]."""
NOT_IN_IT = (
    "position stops and impacts", "sticking friction (its sign is tanh(dq / friction_width))", "elastic joints",
)  # fmt: skip
"""What simulate has and an FMU of a plant has not."""
_FLAGS = ("-O2", "-std=c99", "-ffp-contract=off", "-fPIC", "-shared")
_COMPILERS = ("cc", "gcc", "clang")
_PATIENCE = 300
_JOINT = {"q": "rad", "dq": "rad/s", "ddq": "rad/s2", "tau": "N.m"}
_ARGUMENTS = {"q": "q", "dq": "dq", "q_ref": "q", "dq_ref": "dq", "ddq_ref": "ddq"}


def laws() -> tuple[str, ...]:
    """The control laws that can be written."""
    return tuple(name.removeprefix(STEP).replace("_", "-") for name in EMITTED.names if name.startswith(STEP))


@dataclass(frozen=True, slots=True, eq=False)
class Fmu:
    """The files of an FMU, without a binary."""

    name: str
    """Its model identifier."""
    version: str
    files: Mapping[str, bytes]
    """Path in the archive -> content."""
    variables: tuple[FmuVariable, ...]

    def archive(self, binary: bool = False) -> bytes:
        """The `.fmu`, the same bytes at each writing; with a binary for this machine if asked, which a compiler makes.

        Raises `MissingPackageError` without a C compiler, `OptionError` where this machine has no name in FMI.
        """
        every, out = dict(self.files), BytesIO()
        if binary:
            folder, ending = _place(self.version)
            every[f"binaries/{folder}/{self.name}{ending}"] = self._compiled()
        with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in sorted(every):
                entry = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))
                entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
                archive.writestr(entry, every[path])
        return out.getvalue()

    def _compiled(self) -> bytes:
        compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
        if compiler is None:
            raise MissingPackageError("a C compiler (cc, gcc or clang)", "", "write the FMU without --binary")
        with tempfile.TemporaryDirectory() as place:
            for path, content in self.files.items():
                (Path(place) / Path(path).name).write_bytes(content)
            sources = [x for x in map(lambda p: Path(p).name, self.files) if x.endswith(".c")]
            done = subprocess.run(
                [compiler, *_FLAGS, *sources, "-lm", "-o", "binary"], cwd=place, capture_output=True, text=True,
                timeout=_PATIENCE, check=False,
            )  # fmt: skip
            if done.returncode:
                raise OptionError("--binary", f"{compiler}: {done.stderr.strip()[:300]!r}", "a compiler of C99")
            return (Path(place) / "binary").read_bytes()


def _place(version: str) -> tuple[str, str]:
    """The folder of a binary and its ending, for this machine."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    system = {"linux": "linux", "darwin": "darwin"}.get(platform.system().lower())
    old = {("x86_64", "linux"): "linux64", ("x86_64", "darwin"): "darwin64"}.get((machine, str(system)))
    if system is None or (version == "2" and old is None):
        allowed = "Linux or macOS on x86_64, or with FMI 3 on aarch64"
        raise OptionError("--binary", f"{platform.system()} on {platform.machine()}", allowed)
    return (str(old) if version == "2" else f"{machine}-{system}"), ".dylib" if system == "darwin" else ".so"


def plant_fmu(arm: Arm, version: str = "3") -> Fmu:
    """The arm as a plant.

    Torques are inputs, limited to the arm's; positions, speeds, accelerations and the pose of the flange are outputs;
    gravity, a load at the flange, friction, the state at the start and the largest step are parameters.

    Raises `OptionError` for another version, `MissingDataError` for an arm without dynamics, `MissingPackageError`
    without the extra `batch`.

    >>> import lwr_dyn
    >>> made = plant_fmu(lwr_dyn.load("lwr4plus"))
    >>> made.name, [x.name for x in made.variables if x.causality == "output"]
    ('lwr4plus_plant', ['q', 'dq', 'ddq', 'tip'])
    """
    names = ["forward_dynamics", "flange_pose", *(["smooth_friction_torque"] if arm.has_friction else [])]
    emitted = emitted_arm(arm, names, inputs=("payload", "gravity"), prefix=f"{identifier(arm.name)}_plant")
    emitted, variables = with_tangents(emitted), _plant_variables(arm)
    lines = ["#define PLANT", *(["#define FRICTION"] if arm.has_friction else [])]
    return _fmu(emitted, version, variables, lines, None)


def controller_fmu(arm: Arm, law: str, version: str = "3", rate: float = RATE) -> Fmu:
    """A control law at `rate` samples a second, with its tuned gains as parameters that can be changed.

    Raises `UnknownNameError` for a law that cannot be written, `OptionError` for another version or a rate that is not
    above 0, `MissingDataError`, `MissingPackageError` as `plant_fmu`.
    """
    if law not in laws():
        raise UnknownNameError("control law that can be written", law, laws())
    if not (np.isfinite(rate) and rate > 0.0):
        raise OptionError("--rate", rate, "a number above 0, in Hz")
    function = f"{STEP}{law.replace('-', '_')}"
    emitted = emitted_arm(arm, [function], prefix=f"{identifier(arm.name)}_{function.removeprefix(STEP)}")
    form, arguments = law_form(make_controller(law, arm), arm), emitted.codes[0].function.arguments
    values, rows = form.values(), list[FmuVariable]()
    for argument in arguments:
        name, kind = argument.name, _ARGUMENTS.get(argument.name)
        if kind:
            rows.append(_joint(arm, name, kind, "input", "discrete", np.zeros(arm.n), ""))
        elif name not in ("memory", "h"):
            rows.append(FmuVariable(name, "parameter", "tunable", np.ravel(values[name]), about=argument.unit))
    rows.append(_joint(arm, "tau", "tau", "output", "discrete", None, "joint torques, not limited"))
    memory = np.ravel(form.start())
    if form.memory:
        rows.append(
            FmuVariable("memory", "local", "discrete", memory, about="kept from sample to sample", calculated=True)
        )
    places = {"h": "&h", "memory": "at(m, MEMORY_VALUE)"}
    call = ", ".join(places.get(a.name, f"at(m, {a.name.upper()}_VALUE)") for a in arguments)
    lines = [
        f"#define LAW(m, h, out) {emitted.name_of(function)}({call}, out)",
        f"#define SAMPLE_TIME {1.0 / rate!r}", f"#define MEMORY {form.memory}",
    ]  # fmt: skip
    return _fmu(emitted, version, tuple(rows), lines, 1.0 / rate)


def _joint(arm: Arm, name: str, kind: str, causality: str, variability: str, start: object, about: str) -> FmuVariable:
    """A variable with a number a joint; its unit where all joints are of a kind."""
    unit, turning = _JOINT[kind], arm.chain.turning
    if not turning.any():
        unit = {"N.m": "N"}.get(unit, unit.replace("rad", "m"))
    elif not turning.all():
        about = "; ".join(filter(None, [about, "unit of each joint: rad or m, N m or N"]))
        unit = ""
    values = np.zeros(arm.n) if start is None else np.asarray(start, dtype=np.float64)
    return FmuVariable(name, causality, variability, values, unit, about, calculated=start is None)


def _plant_variables(arm: Arm) -> tuple[FmuVariable, ...]:
    n = arm.n
    limit = np.where(np.isfinite(arm.effort), arm.effort, UNLIMITED)
    load = "of a load at the flange"
    rows = [
        _joint(arm, "tau", "tau", "input", "continuous", np.zeros(n), "joint torques"),
        FmuVariable("gravity", "parameter", "tunable", np.array(arm.chain.gravity), "m/s2", "in the base"),
        FmuVariable("payload_mass", "parameter", "tunable", np.zeros(1), "kg", load),
        FmuVariable("payload_com", "parameter", "tunable", np.zeros(3), "m", f"{load}, in the flange"),
        FmuVariable(
            "payload_inertia", "parameter", "tunable", np.zeros(6), "kg.m2",
            f"{load}: xx, xy, xz, yy, yz, zz about its centre of mass, axes of the flange",
        ),
        _joint(
            arm, "torque_limit", "tau", "parameter", "tunable", limit,
            f"tau counts up to it; {UNLIMITED:g} where the arm's is not known",
        ),
        _joint(arm, "q_start", "q", "parameter", "fixed", _inside(arm), "positions at the start"),
        _joint(arm, "dq_start", "dq", "parameter", "fixed", np.zeros(n), "speeds at the start"),
        FmuVariable("step", "parameter", "fixed", np.array([LARGEST_STEP]), "s", "largest step in co-simulation"),
    ]  # fmt: skip
    if arm.has_friction:
        about = "its sign is tanh(dq / width)"
        rows += [
            FmuVariable("friction_width", "parameter", "fixed", np.array([FRICTION_WIDTH]), about=about),
            FmuVariable("friction_scale", "parameter", "tunable", np.ones(1), about="of the arm's friction; 0: none"),
        ]
    return (
        *rows,
        _joint(arm, "q", "q", "output", "continuous", None, "positions"),
        _joint(arm, "dq", "dq", "output", "continuous", None, "speeds"),
        _joint(arm, "der_q", "dq", "local", "continuous", None, "derivative of q").derived_from("q"),
        _joint(arm, "ddq", "ddq", "output", "continuous", None, "accelerations").derived_from("dq"),
        FmuVariable(
            "tip", "output", "continuous", np.zeros(16), "", "pose of the flange in the base, row by row, m",
            calculated=True, shape=(4, 4),
        ),
    )  # fmt: skip


def _inside(arm: Arm) -> np.ndarray:
    """0, or the position limit next to it."""
    return np.clip(np.zeros(arm.n), arm.lower, arm.upper)


def _fmu(
    emitted: EmittedArm, version: str, variables: tuple[FmuVariable, ...], lines: list[str], sample: float | None
) -> Fmu:
    if version not in VERSIONS:
        raise OptionError("--fmi", repr(version), " or ".join(VERSIONS))
    name, glue = emitted.prefix, files("lwr_dyn.codegen.emit")
    sources = {path.name: text for path, text in c_files(emitted, Path(f"{name}.c")).items()}
    parts = ("fmu.c", f"fmu_functions{version}.h")
    sources |= {part: glue.joinpath(part).read_text(encoding="utf-8") for part in parts}
    said = "; ".join([*provenance_lines(emitted)[:2], *(() if sample else (f"not in it: {', '.join(NOT_IN_IT)}",))])
    body = _config(emitted, version, variables, lines)
    token = hashlib.sha256("".join([*sources.values(), body, said, repr(variables)]).encode()).hexdigest()[:32]
    sources["fmu_config.h"] = f'{body}#define TOKEN "{_token(token, version)}"\n'
    headers = [x for x in glue.joinpath("fmi_headers").iterdir() if x.name.startswith(f"fmi{version}")]
    sources |= {x.name: x.read_text(encoding="utf-8") for x in headers}
    units = ("fmu.c", f"{name}.c")
    texts = {f"sources/{path}": text for path, text in sources.items()}
    texts["modelDescription.xml"] = model_description(
        version, name, _token(token, version), said, variables, units, sample
    )
    texts["documentation/index.html"] = _page(emitted, sample is None)
    if version == "3":
        texts["sources/buildDescription.xml"] = build_description(name, units)
    return Fmu(name, version, {path: text.encode() for path, text in texts.items()}, variables)


def _token(digest: str, version: str) -> str:
    return f"{{{digest}}}" if version == "2" else digest


def _config(emitted: EmittedArm, version: str, variables: tuple[FmuVariable, ...], lines: list[str]) -> str:
    """What fmu.c needs to know; blocks of a controller end in _VALUE, since gains may be called as C's macros."""
    widths = [x.start.size for x in variables]
    suffix = "" if "#define PLANT" in lines else "_VALUE"
    names = [f"{x.name.upper()}{suffix}" for x in variables]
    offsets = np.cumsum([0, *widths]).tolist()
    numbers = ", ".join(repr(float(v)) for x in variables for v in x.start)
    tables = {"int offset[BLOCKS + 1]": offsets, "size_t width[BLOCKS]": widths}
    return "\n".join([
        f'#include "{emitted.prefix}.h"', f"#define FMI {version}", f"#define N {emitted.arm.n}",
        f"#define ARM(name) {emitted.prefix}_##name", f"#define SIZE {offsets[-1]}", f"#define BLOCKS {len(names)}",
        *lines, f"enum {{ {', '.join(names)} }};",
        *(f"static const {key} = {{ {', '.join(map(str, row))} }};" for key, row in tables.items()),
        f"#define START {{ {numbers} }}", "",
    ])  # fmt: skip


def _page(emitted: EmittedArm, plant: bool) -> str:
    lines = [*provenance_lines(emitted), *(f"not in it: {x}" for x in (NOT_IN_IT if plant else ()))]
    body = escape("\n".join(lines))
    head = f'<!DOCTYPE html>\n<html lang="en"><meta charset="utf-8"><title>{emitted.prefix}</title>'
    return f"{head}<pre>\n{body}\n</pre></html>\n"
