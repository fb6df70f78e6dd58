"""Generates the Python source of an arm's kernel of inverse kinematics: its step, and the loop around it."""

from lwr_dyn.codegen.kernels.kernel_source import body_lines
from lwr_dyn.codegen.kernels.machine_code import lanes_of
from lwr_dyn.codegen.kernels.pose_layout import POSE
from lwr_dyn.codegen.kernels.pose_step import pose_step
from lwr_dyn.codegen.kernels.sincos import sincos
from lwr_dyn.codegen.kernels.straight_line import straight_line_code
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.kinematics.pose_solver import SearchRanges
from lwr_dyn.model.chain import Chain

_TEXT = '''"""Inverse kinematics of {name}: {operations} operations a step, {lanes} starts at once.

Written by lwr_dyn {version}.
"""

from lwr_dyn.codegen.kernels.lowering import straight_line
from lwr_dyn.codegen.kernels.pose_driver import pose_kernel


@straight_line("float64")
def body(b):
    for k in range({lanes}):
{body}


kernel = pose_kernel(body, {lanes})
'''


def pose_source(name: str, chain: Chain, ranges: SearchRanges, lanes: int | None = None) -> str:
    """The source of the kernel of a chain."""
    n, W = chain.n, lanes or lanes_of("float64")
    code = straight_line_code(pose_step(chain, ranges), sincos("float64"))
    widths = (n, POSE, 1)
    slots = {("in", row, j): sum(widths[:row]) + j for row, width in enumerate(widths) for j in range(width)}
    flag = sum(widths)
    body = "\n".join(body_lines(code, slots, flag, flag + 1, W))
    return _TEXT.format(name=name, operations=code.operations, lanes=W, version=VERSION, body=body)
