"""The loop of a batch kernel: blocks of W states are copied to a buffer, the body works on its lanes, results go out.

Buffer b, rows of W lanes: the inputs, a flag that is not 0 for a state whose results are not finite, not determined, or
of an angle too large, then room for the results of one block.
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.codegen.kernels.loop_code import KernelLoop, LaneBody
from lwr_dyn.codegen.kernels.loop_helpers import Helper
from lwr_dyn.codegen.kernels.lowering import NUMBERS
from lwr_dyn.codegen.kernels.transposes import begins_on_vector, block_past_caches, rows_to_lanes
from lwr_dyn.kinematics.closed_forms import tree
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

_TEXT = """
/* rows start to stop; the number of states with a flag */
int blocks({arguments}, double *out, double *b, int start, int stop)
{{
    int trouble = 0;
    const int is_large = stop - start > MANY && begins(out);
    for (int s = start; s < stop; s += W) {{
        const int lanes = W < stop - s ? W : stop - s;
        const int whole = s + 2 * W <= stop;
{copies}
{give}
        for (int k = 0; k < lanes; k++) {{
            trouble += !(b[FLAG * W + k] == 0.0);
        }}
    }}
    return trouble;
}}
"""

_GIVE_ROWS = """        if (whole && is_large) {
            body(b, b, TAIL);
            stream(b, out, s * STEP);
        } else if (whole) {
            body(b, out, s * STEP);
        } else {
            body(b, b, TAIL);
            for (int k = 0; k < lanes; k++) {
                for (int j = 0; j < WIDTH; j++) {
                    out[(s + k) * STEP + j] = b[TAIL + k * STEP + j];
                }
            }
        }"""

_GIVE_BLOCKS = """        if (is_large) {
            streamed(b, out, s * WIDTH);
        } else {
            body(b, out, s * WIDTH);
        }"""

_COPY = """        if (whole && {name}_step >= {width}) {{
            {take}
        }} else if ({name}_step != 0 || s == start) {{
            for (int k = 0; k < W; k++) {{
                const int row = (s + k < stop ? s + k : stop - 1) * {name}_step;
                for (int j = 0; j < {width}; j++) {{
                    b[({first} + j) * W + k] = {name}[row + j];
                }}
            }}
        }}"""

_CACHE_BYTES = 1 << 21
"""Results of more bytes leave a core's cache before they are read: they are written past it."""


@dataclass(frozen=True, slots=True)
class BlockLoop:
    """Of one kernel: names and widths of its inputs, W, how `width` results of a state lie, `step` apart in rows."""

    names: tuple[str, ...]
    widths: tuple[int, ...]
    lanes: int
    layout: str
    width: int
    step: int
    dtype: str

    @property
    def _flag(self) -> int:
        return sum(self.widths)

    @property
    def _tail(self) -> int:
        return (self._flag + 1) * self.lanes

    @property
    def _inputs(self) -> list[tuple[str, int, int]]:
        """Name and width of each input, and its first row in the buffer."""
        return list(zip(self.names, self.widths, np.cumsum([0, *self.widths[:-1]]).tolist(), strict=True))

    @property
    def buffer(self) -> int:
        """Numbers in the buffer."""
        return self._tail + (0 if self.layout == "blocks" else self.step * self.lanes)

    def text(self) -> tree.CText:
        """The loop, a function `blocks`: each input and its step, then results, buffer, and the states from and to."""
        text = _TEXT.format(
            arguments=", ".join(f"const double *{name}, int {name}_step" for name in self.names),
            copies="\n".join(self._copy(*x) for x in self._inputs),
            give=_GIVE_BLOCKS if self.layout == "blocks" else _GIVE_ROWS,
        )  # fmt: skip
        many = _CACHE_BYTES // (self.step * np.dtype(self.dtype).itemsize)
        places = {"FLAG": self._flag, "TAIL": self._tail, "WIDTH": self.width, "STEP": self.step, "MANY": many}
        return parsed(text, places | {"W": self.lanes})

    def _copy(self, name: str, width: int, first: int) -> str:
        """Rows of one input into the buffer, by a transpose for every W columns; the last one ends with the row."""
        call = f"take_{name}({name}, s * {name}_step, {name}_step, b, {{}});"
        take, last = call.format(0), width - self.lanes
        if last > 0:
            each = call.format(f"c < {last} ? c : {last}")
            take = f"for (int c = 0; c < {width}; c += W) {{\n                {each}\n            }}"
        return _COPY.format(name=name, width=width, first=first, take=take)

    def _helpers(self) -> tuple[Helper, ...]:
        number = NUMBERS[self.dtype]
        found = [rows_to_lanes(f"take_{name}", number, self.lanes, *place) for name, *place in self._inputs]
        found.append(begins_on_vector("begins", number, self.lanes))
        if self.layout != "blocks":
            found.append(block_past_caches("stream", number, self.lanes, self.step, self._tail))
        return tuple(found)

    def around(self, body: str) -> KernelLoop:
        """The loop around a body, which is also there to write past the caches where whole blocks are the results."""
        streamed = (LaneBody("streamed", body, is_streaming=True),) if self.layout == "blocks" else ()
        return KernelLoop(self.text(), "blocks", (LaneBody("body", body), *streamed), self._helpers(), dtype=self.dtype)
