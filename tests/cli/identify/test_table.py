"""`lwr-dyn identify table`: cells, repairs and page are those of the library; tables with slips, bad input."""

import json
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.motion.motion_fit import identify_motion, motion_information
from lwr_dyn.identification.motion.motion_result import MotionRule
from lwr_dyn.identification.payload.identify_load import CUTOFFS
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.report.motion_report import motion_page
from lwr_dyn.identification.slips.slip_tables import best_table, slip_document, slips_card, table_against_log
from lwr_dyn.identification.slips.trace import DEVIATION, trace_slips
from lwr_dyn.pages.document import page_html
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

USUAL = MotionRule(SampleRule(), cutoffs=CUTOFFS)
OWN = MotionRule(SampleRule(8.0, slowest=0.02, link_side=True), cutoffs=())


def by_the_library(two, rule, share, source=None, reading="printed", robot=None):
    """Document and page of one log against a table, step by step."""
    source = source or two.paper
    information, samples = motion_information(two.logs[:1], two.arm, rule)
    report = trace_slips(information, source, deviation=share)
    cells = table_against_log(information, source, deviation=share, at=best_table(report))
    paper = source if source is two.paper else None
    document = slip_document(report, cells, paper, robot=str(robot or two.file), reading=reading)
    result = identify_motion(two.logs[:1], two.arm, MotionRule(samples, coupled=False))
    card = slips_card(result.information, source, report)
    return document, page_html(motion_page(result, more=[card], command="lwr-dyn identify table")), report


@pytest.mark.parametrize(
    ("options", "rule", "share"),
    [((), USUAL, DEVIATION), (("--deviation", "2%", "--cutoff", 8, "--slowest", 0.02, "--link-side"), OWN, 0.02)],
)
def test_the_record_and_the_page_are_those_of_the_library(two, recorded, lwr_dyn_command, as_recorded, folder,
                                                          options, rule, share):  # fmt: skip
    command = ("identify", "table", two.file, two.paths[0], *options)
    document, page, report = by_the_library(two, rule, share)
    assert report.fits
    assert recorded(*command) == as_recorded(document, two.arm)
    code, out, err = lwr_dyn_command(*command, "--html", "x.html")
    assert (code, out.splitlines()[-1], err) == (0, "wrote x.html", "")
    assert Path("x.html").read_text(encoding="utf-8") == page


def test_exit_codes_of_a_table_that_is_wrong_and_of_a_log_that_cannot_be_read(
    two, lwr_dyn_command, as_recorded, folder
):
    """1 for the table, 2 for the log, which goes before; what can be read is reported all the same."""
    right = two.file.read_text(encoding="utf-8")
    wrong = right.replace("[0, 0, -0.05]]", "[0.2, 0, -0.05]]")
    assert wrong != right
    Path("wrong.toml").write_text(wrong, encoding="utf-8")
    code, out, err = lwr_dyn_command("identify", "table", "wrong.toml", two.paths[0])
    assert (code, err) == (1, "")
    assert "the table does not meet the log" in out
    again = lwr_dyn_command("identify", "table", "wrong.toml", two.paths[0], "none.csv")
    missing = "lwr-dyn: none.csv: no such file or directory; allowed: a log (.csv or .parquet)\n"
    assert again == (2, out, missing)
    assert lwr_dyn_command("identify", "table", two.file, "none.csv") == (2, "", missing)
    line = ("identify", "table", two.file, two.paths[0], "--json", "--html", "x.html")
    code, out, err = lwr_dyn_command(*line)
    assert (code, err) == (0, "wrote x.html\n")
    assert json.loads(out)["robot"] == str(two.file)


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """Two logs of an arm 1 % off the LWR's physical table: encoders of 1e-5 rad, torque noise of 0.1 N m."""
    arm, rng = lwr_dyn.load("lwr4plus", "physical"), np.random.default_rng(1)
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng, 0.01)
    folder = tmp_path_factory.mktemp("logs")
    for k in (0, 1):
        motion = random_motion(arm, 12.0, rng, rate=500.0)
        write_log(folder / f"log{k}.csv", simulated_log(plant, motion, 0.1, rng, encoder=1e-5))
    return [str(folder / f"log{k}.csv") for k in (0, 1)]


@pytest.mark.slow
def test_a_right_table_meets_the_logs(printed, logs):
    out = printed("identify", "table", "lwr4plus", *logs, "--reading", "physical")
    assert out.startswith("the table meets the log")
    assert "one effect on all motions: I1yy = rotor1, m2 = c2z, I2yy = rotor2, c3z = c4y, c5z = c6y" in out
    assert "no motion shows: m1, c1x, c1y, c1z, I1xx, I1xy, I1xz, I1yz, I1zz, c2y" in out


@pytest.mark.slow
def test_logs_of_an_arm_on_a_wall(lwr_dyn_command, tmp_path):
    """With --mount the table meets them; without, gravity pulls another way."""
    arm, rng = lwr_dyn.load("lwr4plus", "physical", mount="wall"), np.random.default_rng(2)
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng, 0.01)
    log = simulated_log(plant, random_motion(arm, 12.0, rng, rate=500.0), 0.1, rng, encoder=1e-5)
    write_log(tmp_path / "wall.csv", log)
    line = ("identify", "table", "lwr4plus", tmp_path / "wall.csv", "--reading", "physical")
    code, out, err = lwr_dyn_command(*line, "--mount", "wall")
    assert (code, out.startswith("the table meets the log")) == (0, True), err
    assert lwr_dyn_command(*line)[0] != 0


@pytest.mark.slow
def test_a_table_with_a_copied_cell_is_named(lwr_dyn_command, logs, tmp_path):
    source = Path(lwr_dyn.__file__).parent / "arms" / "papers" / "lwr4plus.toml"
    text = source.read_text(encoding="utf-8")
    reading = text[text.index("[reading.physical]") :]
    without = reading.replace('"table2-c5z", ', "")
    assert without != reading
    (tmp_path / "arm.toml").write_text(text.replace(reading, without), encoding="utf-8")
    line = ("identify", "table", tmp_path / "arm.toml", *logs, "--reading", "physical")
    code, out, _ = lwr_dyn_command(*line, "--deviation", "2%")
    assert code == 1
    assert "it does with 1 repair:\n- c5z = -0.02" in out
    assert "which repeats c6z (erratum table2-c5z)\n  or c6y = " in out
    code, out, _ = lwr_dyn_command(*line, "--deviation", "0.02", "--json")
    record = json.loads(out)
    assert {c for e in record["explanations"] for r in e["repairs"] for c in r["cells"]} == {"c5z", "c6y"}
    assert (code, record["deviation"], len(record["cells"])) == (1, 0.02, 77)


def test_a_urdf_has_cells_too(recorded, as_recorded, two, tmp_path):
    urdf = tmp_path / "two.urdf"
    urdf.write_text(lwr_dyn.urdf_text(two.arm), encoding="utf-8")
    arm = lwr_dyn.load(urdf)
    two = type(two)(**{**vars(two), "arm": arm})
    document, *_ = by_the_library(two, USUAL, DEVIATION, arm, arm.reading, urdf)
    assert recorded("identify", "table", urdf, two.paths[0], "--mount", "floor") == as_recorded(document, arm)


CHANGED = "allowed: the arm as its table has it, or a .urdf\n"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("lwr4plus", "--deviation", "much"), "'--deviation': 'much' is not a share; allowed: a number such as 5%"),
        (("lwr4plus", "--deviation", "120%"), "deviation: 1.2"),
        (("lwr4",), "no mass"),
        (("wam7",), "missing.csv: no such file"),
        (("lwr4plus", "--lock", "joint_3=0"), f"--lock: given, which changes the arm; {CHANGED}"),
        (("lwr4plus", "--tool", "mass=1"), f"--tool: given, which changes the arm; {CHANGED}"),
        (("lwr4plus", "--html", "x.txt"), "x.txt: ends in '.txt'; allowed: a path in .html"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(refused, folder, options, said):
    assert said in refused("identify", "table", options[0], "missing.csv", *options[1:])
