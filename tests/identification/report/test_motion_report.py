"""The report of a fit to any motion: its figures are those of the fit, and the page holds them."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.document import Section
from lwr_dyn.foundation.tables import Table
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule, expected
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.report.motion_report import _drawn, _recordings, link_parameters, motion_page
from lwr_dyn.identification.slips.slip_tables import table_card
from lwr_dyn.model.chain import with_bodies
from lwr_dyn.pages.document import page_html
from tests.identification.plants import Plant, perturbed_plant, random_motion, rms, simulated_log


@pytest.fixture(scope="module")
def logs(lwr):
    rng = np.random.default_rng(7)
    plant = perturbed_plant(TorqueColumns(lwr.chain, "directions"), lwr, rng, 0.25)
    return [
        simulated_log(plant, random_motion(lwr, seconds, rng, rate=500.0), 0.3, rng, 1e-5, f"motion_{seconds:g}.csv")
        for seconds in (8.0, 4.0, 3.0)
    ]


@pytest.fixture(scope="module")
def result(logs, lwr):
    return identify_motion(logs[:2], lwr)


@pytest.fixture(scope="module")
def shown(result, logs):
    slips = Section("Slips of the table", [Table("Repairs", ("cell",), [("c5z",)])])
    return motion_page(result, unseen=result.validated_on(logs[2:]), more=[slips])


@pytest.fixture(scope="module")
def drawn(result):
    return _drawn(result)[1]


def tables(document):
    """Title of a section -> its tables by title."""
    return {
        one.title: {part.title: part for part in one.parts if isinstance(part, Table) and part.is_shown}
        for one in document.sections
        if one.there is not False
    }


def test_head_figures_are_those_of_the_fit(shown, result):
    figures, rows = {one.head: one.text for one in shown.facts}, result.validation
    assert shown.verdict.startswith(f"{result.identified} of {result.base.count} base parameters identified")
    near = {part.head: part.text for one in shown.sections if one.key == "consistent" for part in one.parts[:6]}
    assert near["bodies near the table"] == "7 of 7 links are bodies"
    assert near["expected off the table"] == expected(result.consistent)
    consistent, model, measured = (rms([getattr(v, x) for v in rows]) for x in ("consistent", "model", "measured"))
    assert figures["of unseen torques left, by the result"] == f"{100 * consistent / measured:.3g} %"
    assert figures["left by the robot's own data"] == f"{100 * model / measured:.3g} %"
    noise = result.information.residual_noise
    loudest = f"noise, largest at joint_{noise.argmax() + 1}"
    assert figures[loudest] == f"{noise.max():.2g} N m"
    assert shown.command == "lwr-dyn identify motion"
    assert [one.title for one in shown.sections if one.page] == [
        "The motion, and the links before and after", "Torque against prediction", "Friction", "Recordings",
    ]  # fmt: skip
    assert [one.page for one in shown.facts[-3:]] == [True] * 3
    assert loudest not in shown.text()


def test_what_is_drawn_is_that_of_the_fit_and_the_table(drawn, result, lwr):
    left = np.concatenate([np.where(one.used, one.measured - one.predicted, np.nan) for one in drawn.recordings])
    found, parameters = np.sqrt(np.nanmean(np.square(left), axis=0)), result.consistent.parameters
    np.testing.assert_allclose(found, result.information.normal.residual_rms(result.base.of(parameters)))
    assert [one.source for one in drawn.recordings] == ["motion_8.csv", "motion_4.csv"]
    np.testing.assert_array_equal(drawn.after, link_parameters(result.columns, parameters))
    np.testing.assert_array_equal(drawn.before, link_parameters(result.columns, result.columns.own(lwr)))
    assert drawn.friction == result.columns.friction_of(parameters)


def test_the_cards_hold_validation_bodies_and_what_is_open(shown, result, logs):
    cards = tables(shown)
    assert list(cards)[-3:] == ["Validation on other logs", "Slips of the table", "Recordings"]
    kept, white = cards["Validation"].values()
    (unseen,) = cards["Validation on other logs"].values()
    assert [row[3] for row in kept.rows] == [v.held_out for v in result.validation]
    assert "no fit has seen" in unseen.title
    assert [row[2] for row in unseen.cells] == [""] * 7
    assert [row[1] for row in white.rows] == [w.white for w in result.whiteness]
    (links,) = cards["Links"].values()
    assert [sum(row[7:]) for row in links.rows] == [10] * 7
    samples, rows = result.samples, []
    for k, log in enumerate(logs[:2]):
        of_log = samples.recording == k
        seconds = np.ptp(samples.t[of_log])
        rows.append((log.source, seconds, of_log.sum(), samples.used[of_log].sum(), "none"))
    assert [*cards["Recordings"]["Recordings"].rows] == rows


def test_a_joint_that_moves_by_less_than_a_milliradian_stands_still(result):
    q = result.samples.q * [*np.array([0.9e-3, 1.1e-3]) / np.ptp(result.samples.q[:, :2], axis=0), *[1.0] * 5]
    whole = replace(result.samples, q=q, recording=0 * result.samples.recording)
    (row,) = _recordings(replace(result, samples=whole), SimpleNamespace(left_out=0, every=1)).parts[0].rows
    assert row[-1] == "joint_1"


def test_the_page_names_every_parameter(shown, result):
    text = page_html(shown)
    for statement in result.base.statements():
        assert statement in text
    assert "nan" not in re.sub(r"<script.*?</script>|<style.*?</style>", "", text, flags=re.DOTALL)
    assert text == page_html(shown)


@pytest.mark.slow
def test_an_arm_without_masses_has_a_report_too(logs, lwr):
    bare = replace(lwr, chain=with_bodies(lwr.chain, [None] * 7))
    found = identify_motion(logs[:2], bare)
    assert found.consistent is None
    shown = motion_page(found)
    assert "Bodies near the table" not in tables(shown)
    assert shown.record()["consistent"] is None
    assert '"before":[null,null,null,null,null,null,null]' in page_html(shown)


def test_residuals_that_are_not_white_are_said(logs, lwr):
    tau = logs[0].tau.copy()
    tau[:, 3] += 0.5 * np.sin(np.arange(len(tau)) / 50.0)
    found = identify_motion([replace(logs[0], tau=tau)], lwr)
    assert found.information.inflation[3] > 1.0
    document = motion_page(found)
    assert "sigma widened: residuals are not white" in document.text()
    white = next(iter(table for title, table in tables(document)["Validation"].items() if "white" in title))
    assert not white.rows[3][1]


@pytest.mark.slow
def test_a_joint_that_never_moves_and_torques_that_were_cut_out(logs, lwr):
    q, tau = logs[0].q.copy(), logs[0].tau.copy()
    q[:, 2], tau[500:900, 1] = q[0, 2], np.nan
    found = identify_motion([replace(logs[0], q=q, tau=tau)], lwr)
    shown = motion_page(found)
    assert shown.verdict.endswith("condition inf")
    assert tables(shown)["Recordings"]["Recordings"].rows[0][-1] == "joint_3"
    assert np.isnan(_drawn(found)[1].recordings[0].measured[:, 1]).any()
    text = page_html(shown)
    assert ">-<" in text  # what the log does not show


@pytest.mark.slow
def test_friction_behind_a_coupling_is_said_to_be_the_motors():
    wam, rng = lwr_dyn.load("wam7"), np.random.default_rng(2)
    columns = TorqueColumns(wam.chain, "directions", transmission=wam.transmission)
    parameters = columns.own(wam)
    parameters[columns.bodies :] = np.tile([1e-4, 0.05, 1e-3, 0.06, 1e-3], wam.n)  # rotor, friction each way
    log = simulated_log(Plant(columns, parameters), random_motion(wam, 6.0, rng, rate=500.0), 0.01, rng, 1e-6)
    found = identify_motion([log], wam, MotionRule(SampleRule(slowest=2.0, transmission=wam.transmission)))
    shown = motion_page(found, more=table_card(found.information, wam))
    assert _drawn(found)[1].friction_at == tuple(f"motor {j}" for j in range(1, 8))
    assert "The table against the logs, cell by cell" not in tables(shown)
    assert "<h3>motor 7 <small>" in page_html(shown)


def test_the_command_writes_it(logs, tmp_path, lwr_dyn_command):
    for log in logs:
        write_log(tmp_path / log.source, log)
    fitted, unseen = ([str(tmp_path / log.source) for log in part] for part in (logs[1:2], logs[2:]))

    def identify(page):
        line = ("identify", "motion", "lwr4plus", "--reading", "physical", "--validate", *unseen, *fitted)
        return lwr_dyn_command(*line, "--html", str(tmp_path / page))

    code, out, err = identify("report.html")
    assert (code, err, out.splitlines()[-1]) == (0, "", f"wrote {tmp_path / 'report.html'}")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    for words in (
        "<h1>Identification of lwr4plus, reading physical</h1>", "which no fit has seen",
        "<h2>The table against the logs, cell by cell</h2>",
    ):  # fmt: skip
        assert words in text
    for page, words in (("no/x.html", "no/x.html"), ("report.txt", "report.txt: ends in '.txt'")):
        code, out, err = identify(page)
        assert (code, out, words in err) == (2, "", True)
