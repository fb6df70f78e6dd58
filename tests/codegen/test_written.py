"""What is generated stays: digests of texts and test vectors, with their numbers rounded.

A change that is meant raises the generator's number (`kernel_spec.GENERATOR`, `pose_kernel.GENERATOR`,
`step.GENERATOR`), so that kernels on disk are made again, and its digest here: `python -m tests.codegen.test_written`.
"""

import hashlib
import re
import struct
import tomllib
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.c_file import c_files
from lwr_dyn.codegen.emit.emission import emitted_arm, provenance_lines, vectors_text
from lwr_dyn.codegen.emit.functions import EMITTED
from lwr_dyn.codegen.emit.javascript_file import js_files
from lwr_dyn.codegen.kernels import kernel_spec, lowering, pose_kernel
from lwr_dyn.codegen.kernels.kernel_source import generate
from lwr_dyn.codegen.kernels.pose_source import pose_loop
from lwr_dyn.codegen.rollouts import philox_code, step
from lwr_dyn.codegen.rollouts.compiled_loop import whole_loop
from lwr_dyn.codegen.rollouts.kernel import rollout_loop
from lwr_dyn.codegen.rollouts.law_forms import unchecked_form
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.kinematics.pose_solver import search_ranges
from lwr_dyn.model.arm import JointLimits
from tests.codegen.rollouts import beside
from tests.random_arms import random_arm

KNOWN = Path(__file__).with_name("written.toml")
ARM = beside.first_joints(2)
SLIDING = replace(random_arm(5, "PR"), limits=(JointLimits(-1.0, 1.5), JointLimits(upper=0.5)))
INPUTS = ("inertia", "payload", "gravity", "friction")
KERNELS = {
    "rows": ({}, kernel_spec.FUNCTIONS),
    "padded": ({"layout": "padded", "friction": "arm"}, ("inverse_dynamics", "forward_dynamics")),
    "blocks": ({"layout": "blocks", "structure": "compact"}, ("mass_matrix", "torque_regressor")),
    "inputs": ({"inputs": INPUTS, "dtype": "float32"}, ("inverse_dynamics",)),
}
LAWS = ("pd-gravity", "pid", "inverse-dynamics", "robust", "motor-pd", "adaptive", "inverse-dynamics+friction")
PLANS = {
    "plain": {},
    "all": {
        "varies_plant": True, "varies_model": True, "friction_width": 0.05, "pole": 0.5, "noise": "philox",
        "most_delay": 2, "substeps": 2,
    },
    "whole": {"whole": True, "noise": "table", "pole": 0.5},
}  # fmt: skip
SHORT = ("inverse_dynamics", "jacobian", "friction_torque", "smooth_friction_torque", "step_pid", "step_adaptive")
FILES = {
    "rotary": ({}, ()),
    "sliding": ({}, (), SLIDING),
    "closed form": ({}, ("inverse_kinematics",), lwr_dyn.load("lwr4plus", "computed")),
    "closed form, six joints": ({}, ("inverse_kinematics",), lwr_dyn.load("kr30ha")),
    "libm": ({"kind": "libm", "inputs": ("payload", "gravity"), "friction": "arm", "prefix": "2 x"}, SHORT[:2]),
    "single": ({"dtype": "float32", "inputs": INPUTS}, SHORT[:2]),
}


def rounded(text, digits=7):
    """Without the version; long numbers to some digits, those below 1e-12 as 0."""

    def short(number):
        x = float(number.group())
        return number.group() if len(number.group()) < 10 else f"{0.0 if abs(x) < 1e-12 else x:.{digits}g}"

    def of_bits(bits):
        """LLVM writes a number by its bits; the last ones depend on the processor's BLAS."""
        return repr(struct.unpack(">d", bytes.fromhex(bits[1]))[0])

    text = re.sub(r"\b0x([0-9a-f]{16})\b", of_bits, text.replace(VERSION, "VERSION"))
    return re.sub(r"(?<![\w.])\d+\.\d*(?:e[-+]?\d+)?", short, text)


def kernel_texts():
    for name, (options, functions) in KERNELS.items():
        spec = kernel_spec.kernel_spec(SLIDING if name == "rows" else ARM, **options)
        for function in functions:
            source = generate(spec, function, 2)
            yield f"{name} {function}", source.text + repr(source.interface)
            if function in ("jacobian", "forward_dynamics", "mass_matrix") and (name, function) != ("rows", "jacobian"):
                loop = source.loop.around(source.body)
                yield f"loop {name} {function}", loop.assembly() + "".join(x.assembly for x in loop.helpers)
                for body in loop.bodies:
                    text = lowering.body_assembly(body.text, "body", spec.dtype, body.is_streaming)
                    yield f"assembly {name} {function} {body.is_streaming}", text
    for lanes in (1, 4):
        yield f"numbers {lanes}", philox_code.uniform_code("fill", lanes, 5, 3).assembly


def rollout_texts(kind):
    for name in LAWS:
        if kind == "plain" or name in LAWS[-2:]:
            form = unchecked_form(beside.made(name, ARM), ARM)
            plan = step.StepPlan(ARM, ARM, form, **PLANS[kind])
            loop = whole_loop(plan).loop if kind == "whole" else rollout_loop(plan, 2).loop
            yield name, "".join([loop.assembly(), *(body.text for body in loop.bodies)])


def pose_texts():
    for arm in (ARM, SLIDING):
        loop = pose_loop(arm.chain, search_ranges(arm, True, 1, 0), 2)
        yield f"pose {arm.name}", loop.assembly() + loop.bodies[0].text


def emitted_texts(name):
    options, functions, *arm = FILES[name]
    emitted = emitted_arm(arm[0] if arm else ARM, functions, **options)
    yield "left out", repr((emitted.left_out, EMITTED.names))
    yield "about", "\n".join(provenance_lines(emitted))
    yield "vectors", rounded(vectors_text(emitted), 5)  # near a singularity angles lose digits
    for files in (c_files, js_files) if emitted.dtype == "float64" else (c_files,):
        for path, text in files(emitted, Path("arm.c" if files is c_files else "arm.js")).items():
            yield str(path), text


MAKERS = {
    "kernels": kernel_texts,
    "poses": pose_texts,
    **{f"rollouts {kind}": partial(rollout_texts, kind) for kind in PLANS},
    **{f"emitted {name}": partial(emitted_texts, name) for name in FILES},
}
GENERATORS = {"kernels": kernel_spec.GENERATOR, "poses": pose_kernel.GENERATOR, "rollouts": step.GENERATOR}


def digests(subject):
    """The digest of each text, by its name."""
    return {name: hashlib.sha256(rounded(text).encode()).hexdigest()[:12] for name, text in MAKERS[subject]()}


def written(subject):
    """The generator's number, and the digest of all digests."""
    found = hashlib.sha256(repr(sorted(digests(subject).items())).encode()).hexdigest()[:16]
    return f"{GENERATORS.get(subject.split()[0], 0)} {found}"


@pytest.mark.parametrize("subject", MAKERS)
def test_what_is_written_is_what_this_generator_wrote(subject):
    assert written(subject) == tomllib.loads(KNOWN.read_text(encoding="utf-8"))[subject]


if __name__ == "__main__":
    KNOWN.write_text("".join(f'"{x}" = "{written(x)}"\n' for x in MAKERS), encoding="utf-8")
