"""The torque regressor by its distinct numbers, and the map from them to all of it.

Of n x 10 n numbers about half are always 0, and many others are equal up to their sign.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi
import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.emit.functions import (
    RESULT_UNITS,
    Argument,
    EmittedFunction,
    TemplateCase,
    TemplateFunction,
    of_batch,
)
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.codegen.kernels.result_form import compact
from lwr_dyn.codegen.kernels.sincos import sincos
from lwr_dyn.codegen.kernels.straight_line import straight_line_code
from lwr_dyn.codegen.kernels.symbolic_functions import symbolic_function
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm

DENSE = "torque_regressor"
COMPACT, EXPANDED = f"{DENSE}_compact", f"{DENSE}_expanded"
_C = """\
static const short @NAME@_map[{wide}] = {{
    {numbers}}};

int @NAME@_index(int place)
{{
    return @NAME@_map[place];
}}

void @NAME@(const @NUMBER@ values[{narrow}], @NUMBER@ out[{wide}])
{{
    int i;
    for (i = 0; i < {wide}; i++) {{
        const int k = @NAME@_map[i];
        out[i] = 0;
        if (k > 0) {{
            out[i] = values[k - 1];
        }} else if (k < 0) {{
            out[i] = -values[-k - 1];
        }}
    }}
}}
"""
_JS = """\
const map = new Int16Array([{numbers}]);
function @NAME@_index(place) {{
    return map[place];
}}
function @NAME@(values, out = new Float64Array({wide})) {{
    for (let i = 0; i < {wide}; i++) {{
        const k = map[i];
        out[i] = k > 0 ? values[k - 1] : k < 0 ? -values[-k - 1] : 0;
    }}
    return out;
}}
"""


@dataclass(frozen=True, slots=True, eq=False)
class CompactResult:
    """The distinct numbers of a result, those that are not always 0, each once up to its sign."""

    function: Any
    """casadi.Function of the same arguments, which gives them."""
    index: NDArray[np.int64]
    """For each place of the whole result: 0 where it is 0, k for number k - 1, -k for that number negated."""


@lru_cache(maxsize=16)
def compact_regressor(spec: KernelSpec) -> CompactResult:
    """Of the torque regressor."""
    return compact_result(symbolic_function(spec, DENSE))


def compact_result(function: Any) -> CompactResult:
    """Of a casadi.Function with one output vector; raises `OptionError` where one is a constant other than 0."""
    _, entries, constants = compact(straight_line_code(function, sincos("float64"), is_flagged=False))
    if any(constants):
        raise OptionError(COMPACT, "a number that is always the same, but not 0", "numbers that are 0 or change")
    index = np.array(entries)
    symbols = [casadi.SX.sym(f"x{i}", function.size1_in(i)) for i in range(function.n_in())]
    out = casadi.SX(function(*symbols))
    places = [int(np.argmax(np.abs(index) == k)) for k in range(1, int(np.abs(index).max()) + 1)]
    values = [float(np.sign(index[place])) * out[place] for place in places]
    return CompactResult(casadi.Function(function.name(), symbols, [casadi.densify(casadi.vertcat(*values))]), index)


def compact_function(spec: KernelSpec, name: str, arm: Arm) -> EmittedFunction:
    """The row "torque_regressor_compact" of `EMITTED`; raises as that of the regressor."""
    dense, function = of_batch(spec, DENSE, arm), compact_regressor(spec).function
    width = int(function.size1_out(0))
    text = f"the {width} distinct numbers of {DENSE}, to be placed by {EXPANDED}"
    return EmittedFunction(name, text, dense.arguments, (width,), RESULT_UNITS[DENSE].partition(";")[0], function)


def expanding_function(spec: KernelSpec, name: str, arm: Arm) -> TemplateFunction:
    """The row "torque_regressor_expanded" of `EMITTED`; raises as that of the regressor."""
    of_batch(spec, DENSE, arm)
    made, n = compact_regressor(spec), arm.n
    width, places = int(made.function.size1_out(0)), made.index.size
    words = {"wide": places, "narrow": width}
    rows = [", ".join(map(str, row)) for row in made.index.reshape(-1, 10).tolist()]
    text = "\n".join([
        f"{DENSE} ({n} x {10 * n}, row by row) from the {width} numbers of {COMPACT}",
        "_index: which number stands at a place: 0 for none (it is 0), k for values[k - 1], -k for -values[k - 1]",
    ])  # fmt: skip
    c = _C.format(**words, numbers=",\n    ".join(rows))
    head = f"void @NAME@(const @NUMBER@ values[{width}], @NUMBER@ out[{places}]);\nint @NAME@_index(int place)"
    js = _JS.format(**words, numbers=",\n".join(rows))
    names = {"c": head, "js": f"{name}, {name}_index"}
    return TemplateFunction(name, text, names, {"c": c, "js": js}, cases=lambda: (_placed(name, made.index, width),))


def _placed(name: str, index: NDArray[np.int64], width: int) -> TemplateCase:
    """Its test vector: 1, 2, 3 ... in their places."""
    values = [[float(k + 1) for k in range(width)]]
    argument = Argument("values", width, RESULT_UNITS[DENSE].partition(";")[0])
    return TemplateCase(name, ((argument, values),), argument.unit, [index.astype(float).tolist()], None, 0.0)
