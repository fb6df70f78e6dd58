"""The kinds of planted faults, each with the codes that name it rightly; fixed before the first count.

`KINDS` are slips of any language; `REFUSED` is what the pendant refuses at once and version 0.2.0 of the check passed.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass

from tests.krl.planting import block_faults as b
from tests.krl.planting import line_faults as w
from tests.krl.planting import number_faults as n
from tests.krl.planting import refused_lines as r
from tests.krl.planting import refused_places as p
from tests.krl.planting.site import PlantedFault, PlantSite


@dataclass(frozen=True, slots=True)
class FaultKind:
    """A kind of fault: how it is planted in a line (None where it cannot be), and the codes that name it rightly."""

    plant: Callable[[PlantSite, random.Random], PlantedFault | None]
    codes: frozenset[str]

    @property
    def name(self) -> str:
        return self.plant.__name__.replace("_", " ")


def _kind(plant: Callable[[PlantSite, random.Random], PlantedFault | None], codes: str) -> FaultKind:
    return FaultKind(plant, frozenset(codes.split()))


KINDS = (
    _kind(w.variable_misspelt, "undeclared"),
    _kind(w.subprogram_misspelt, "unknown-call undeclared"),
    # PTP misspelt reads as a declaration: "PPT P1: neither a statement nor a type"
    _kind(w.keyword_misspelt, "unknown-keyword syntax unknown-type"),
    _kind(w.component_misspelt, "no-component"),
    _kind(w.constant_misspelt, "no-constant"),
    _kind(w.bracket_lost, "open-bracket syntax"),
    _kind(w.string_open, "open-string"),
    _kind(w.then_lost, "syntax"),
    _kind(w.sec_lost, "syntax"),
    _kind(w.assigned_for_compared, "syntax"),
    _kind(w.truth_to_number, "type"),
    _kind(w.joint_blend_on_line, "blend"),
    # in a call or between square brackets a comma makes two of one
    _kind(w.decimal_comma, "syntax arguments no-array"),
    _kind(w.foreign_letter, "bad-character"),
    _kind(w.one_argument_more, "arguments"),
    _kind(w.operand_lost, "syntax open-bracket"),
    _kind(n.index_past_array, "index-range"),
    _kind(n.signal_zero, "index-range"),
    _kind(n.speed_in_millimetres, "speed-unit"),
    _kind(n.over_hundred, "percent-range"),
    _kind(b.declared_twice, "duplicate-name"),
    _kind(b.late_declaration, "late-declaration"),
    _kind(b.jump_to_nowhere, "undeclared"),
    _kind(b.wrong_end, "stray-end missing-end"),
    _kind(b.end_lost, "missing-end"),
    _kind(b.declaration_lost, "undeclared"),
)

REFUSED = (
    _kind(r.system_name_slip, "system-name"),
    _kind(p.parameter_undeclared, "parameter-type undeclared"),
    _kind(r.input_written, "read-only"),
    _kind(r.read_only_written, "read-only"),
    _kind(r.input_signal_written, "read-only"),
    _kind(r.interrupt_undeclared, "interrupt"),
    _kind(r.forbidden_priority, "interrupt"),
    _kind(p.global_twice, "global-twice"),
    _kind(p.global_variable_twice, "global-twice"),
    _kind(p.output_in_spline, "in-spline"),
    _kind(p.pause_in_spline, "in-spline"),
    _kind(p.motion_in_spline, "in-spline"),
    _kind(p.switch_on_real, "switch type"),
    _kind(p.before_first_case, "switch"),
    _kind(p.case_after_default, "switch"),
    _kind(p.jump_into_loop, "goto"),
    _kind(r.text_without_brackets, "text-brackets"),
    _kind(r.constant_for_out, "arguments"),
)
