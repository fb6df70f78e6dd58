"""The full counts of what the tests only sample: prints a table; exit 1 when a line fails. Takes some minutes."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]  # some counts are those of `tests`

Line = Callable[[], tuple[str, bool] | tuple[str, bool, str]]
"""One count: the result in words, whether it holds, and perhaps a table of its own that is printed at the end."""

LINES = {
    "adaptation": "adaptation:adaptation",
    "base_fits": "identification_fits:base_fits",
    "branch_arrays": "branch_calls:branch_arrays",
    "branch_memory": "branch_calls:branch_memory",
    "branches": "branches:branches",
    "checks": "checks:checks",
    "cluster_kills": "sweeps:cluster_kills",
    "compiled_loop": "compiled_loop:compiled_loop",
    "completion": "krl_editor:completion",
    "consistent": "identification_bodies:consistent",
    "core": "suite:core",
    "coverage": "identification:coverage",
    "data_mutants": "surveys:data_mutants",
    "default_arms": "surveys:default_arms",
    "default_compare": "surveys:default_compare",
    "default_gains": "surveys:default_gains",
    "default_study": "surveys:default_study",
    "editor": "editor:editor",
    "elastic": "elastic:elastic",
    "elastic_ist": "elastic:elastic_ist",
    "elastic_plant": "elastic_plant:elastic_plant",
    "emitted_bits": "emitted_bits:emitted_bits",
    "emitted_closed_form": "emitted_closed_form:emitted_closed_form",
    "emitted_sanitized": "emitted_states:emitted_sanitized",
    "emitted_states": "emitted_states:emitted_states",
    "excitations": "identification_excitation:excitations",
    "false_alarms": "collisions:false_alarms",
    "fits_cover": "identification_fits:fits_cover",
    "gains_cover": "identification_fits:gains_cover",
    "gains_and_loads_cover": "identification_fits:gains_and_loads_cover",
    "load_friction_cover": "identification_fits:load_friction_cover",
    "foreign_arms": "surveys:foreign_arms",
    "foreign_lint": "surveys:foreign_lint",
    "fitted_models": "identification_models:fitted_models",
    "fresh_torques": "identification_fits:fresh_torques",
    "fuzz": "fuzz:fuzz",
    "ik": "inverse_kinematics:ik",
    "impedance": "compliance:impedance",
    "ist_clear": "poses:ist_clear",
    "kernels": "checks:kernels",
    "kills": "kills:kills",
    "krl": "suite:krl",
    "krl_cells": "krl_cells:krl_cells",
    "krl_edits": "krl_editor:krl_edits",
    "krl_large": "large_programs:krl_large",
    "krl_planted": "krl_planted:krl_planted",
    "krl_splines": "krl_motion:krl_splines",
    "krl_projects": "krl_projects:krl_projects",
    "krl_written": "krl_language:krl_written",
    "lint": "audit:lint",
    "linter": "linter:linter",
    "linter_broken": "linter:linter_broken",
    "loads_cover": "identification_slips:loads_cover",
    "log_faults": "identification_logs:log_faults",
    "long_log": "identification:long_log",
    "million_rows": "identification_fits:million_rows",
    "mjcf": "mjcf:public_mjcf",
    "mujoco_logs": "identification_fits:mujoco_logs",
    "mutants": "mutants:mutants",
    "origins": "origins:origins",
    "parity": "checks:parity",
    "passivity": "compliance:passivity",
    "poses": "poses:poses",
    "properties": "suite:properties",
    "pushes": "collisions:pushes",
    "recovery": "audit:recovery",
    "rename": "krl_editor:rename",
    "right_tables": "identification_slips:right_tables",
    "robustness": "robustness:robustness",
    "rollout_laws": "rollout_laws:rollout_laws",
    "rollouts": "rollouts:rollouts",
    "runs": "checks:runs",
    "shares": "suite:shares",
    "single_arrays": "single_states:single_arrays",
    "single_memory": "single_states:single_memory",
    "slips": "identification_slips:slips",
    "special_logs": "identification_special:special_logs",
    "sweep_kills": "sweeps:sweep_kills",
}
"""Name -> "module:function" of `scripts/soak_lines/`, in alphabetical order."""


def line_of(name: str) -> Line:
    """The function of a line; its docstring is what the table says of it."""
    module, _, function = LINES[name].partition(":")
    line: Line = getattr(import_module(f"soak_lines.{module}"), function)
    return line


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("lines", nargs="*", metavar="LINE", help=f"all if not given, or some of: {', '.join(LINES)}")
    options = parser.parse_args()
    if unknown := [name for name in options.lines if name not in LINES]:
        parser.error(f"there is no line {unknown[0]!r}: {', '.join(LINES)}")
    good, tables = True, []
    print("| what | result | verdict | s |\n|---|---|---|---|", flush=True)
    for name in options.lines or LINES:
        start, line = time.perf_counter(), line_of(name)
        result, holds, *more = line()
        good, tables = good and holds, [*tables, *more]
        seconds = time.perf_counter() - start
        print(f"| {line.__doc__} | {result} | {'holds' if holds else 'FAILS'} | {seconds:.0f} |", flush=True)
    print("".join(f"\n{table}\n" for table in tables), end="")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
