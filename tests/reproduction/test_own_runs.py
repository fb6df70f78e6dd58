"""Runs of a user's own paper: their figures are those of `lwr_dyn.simulate`, and one line for each bad input."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.reproduction.compare import compare_numbers
from lwr_dyn.reproduction.named_results import METRICS
from lwr_dyn.reproduction.own_paper import own_study
from lwr_dyn.reproduction.reproduce import reproduce
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.studies.sweep.vocabulary import METRICS as OF_STUDIES
from tests.reproduction.pages import lost
from tests.reproduction.two_links import TEXT, writer

MOVE = """
[run.move]
controller = "pd-gravity:omega-n=20"
rate = 500
payload = 0.5
[run.move.task]
name = "point-to-point"
from-deg = [0, 0]
to-deg = [60, -30]
duration = 2
"""


def result(name, compute, unit, printed):
    text = json.dumps(printed)
    return (
        f'[[result]]\nid = "{name}"\nwhere = "Table V, {name}"\nprinted = {text}\nunit = "{unit}"\n'
        f'compute = "{compute}"\nrun = "move"\n'
    )


RESULTS = (
    result("tip", "tip_max", "mm", "0") + result("rms", "position_rms", "mrad", ["0", "0"])
    + result("torque", "peak_torque", "N m", ["0", "0"])
    + result("share", "peak_torque[2] / limits.effort[2]", "%", "0")
    + result("speed", "peak_speed[1]", "deg/s", "0") + result("asked", "peak_command[1]", "N m", "0")
)  # fmt: skip


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path, TEXT + MOVE + RESULTS)


def simulated(path, payload=0.5):
    """The same loop by the front door."""
    arm = lwr_dyn.load(path)
    law = lwr_dyn.controller("pd-gravity", arm, omega_n=20.0)
    q = np.radians([[0.0, 0.0], [60.0, -30.0]])
    move = lwr_dyn.reference("point-to-point", arm, start=q[0], end=q[1], duration=2.0)
    return metrics(lwr_dyn.simulate(arm, law, move, rate=500.0, payload=payload), arm)


def test_the_figures_are_those_of_simulate(written):
    path = written()
    m = simulated(path)
    wanted = [
        m.tip_max_mm, *m.position_mrad.rms, *m.peak_torque, 10.0 * m.peak_torque[1], np.degrees(m.peak_speed[0]),
        m.peak_command[0],
    ]  # fmt: skip
    found = [n.value for n in compare_numbers(own_study(path), slow=True).numbers]
    np.testing.assert_allclose(found, wanted, rtol=1e-12)
    assert found[0] > simulated(path, payload=0.0).tip_max_mm  # the controller does not know the payload


def test_an_erratum_of_the_tables_changes_the_run(written):
    """With a mass of 15 kg the peaks differ; the fewest errata under which they are as printed are found."""
    peak = simulated(written()).peak_torque[0]
    erratum = """
[[erratum]]
id = "mass-2"
where = "Table II"
printed = "15"
read_as = "1.5"
why = "a point is lost"
effect = "torques"
status = "proven"
patch = [{ at = "inertial.mass.values[1]", printed = 15, read = 1.5 }]
"""
    first = erratum + result("peak", "peak_torque[1]", "N m", f"{peak:.2f}") + 'errata = ["mass-2"]\n[[result]]'
    path = written(("values = [2.0, 1.5]", "values = [2.0, 15]"), ("[[result]]", first))
    (number, *_) = compare_numbers(own_study(path), slow=True).numbers
    assert (number.verdict, number.errata) == ("after erratum", ("mass-2",))


def test_runs_are_files_of_the_folder_and_audited_on_the_page(written, tmp_path):
    done = reproduce(written(), tmp_path / "out")
    assert lost(tmp_path / "out") == []
    run = lwr_dyn.Run.load(tmp_path / "out" / "runs" / "move.npz")
    assert run.t[-1] == pytest.approx(2.0)
    assert "move, inverse dynamics" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    bases = {n["basis"] for n in done.document.record()["numbers"]}
    assert bases == {"computed"}


def test_names_are_those_of_studies():
    """One name means one thing: what a study measures too has its name; `position_mean` is of papers alone."""
    assert set(METRICS) - set(OF_STUDIES) == {"position_mean"}


BAD = {
    "no run of that name": ('run = "move"', 'run = "mov"', "result.tip.run: 'mov'; allowed: one of move"),
    "a metric without a run": ('run = "move"\n', "", "result.tip.run: missing; allowed: text"),
    "no runs": (MOVE, "", "result.tip.compute: tip_max; allowed: with a table [run.NAME], of which the file has none"),
    "a run it does not take": ('"tip_max"', '"dh.a[1]"', "result.tip.run: given; allowed: left out: dh.a[1] does not"),
    "an odd name": ("[run.move]", '[run."../x"]', "run: '../x'; allowed: a letter, then letters"),
    "no controller": ('"pd-gravity:omega-n=20"', '"pd-gravty"', "run.move.controller: 'pd-gravty'; allowed: "),
    "code": ('"pd-gravity:omega-n=20"', '"mine.py"', "run.move.controller: 'mine.py', Python that would run"),
    "no task": ('"point-to-point"', '"point"', "run.move.task.name: "),
    "a task without its end": ("to-deg = [60, -30]\n", "", "run.move.task.to-deg: missing"),
    "an odd option": ("to-deg", "to-dge", "run.move.task.to-dge: unknown field (did you mean to-deg?)"),
    "a rate of zero": ("rate = 500", "rate = 0", "run.move.rate: 0; allowed: "),
    "another field": ("rate = 500", "rates = 500", "run.move.rates: unknown field"),
    "another unit": ('unit = "mm"\ncompute', 'unit = "N m"\ncompute', "a unit of m, which tip_max has"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, written):
    old, new, words = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        own_study(written((old, new)))
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)
