"""The main job: one command, one folder, one page that replays both runs with the network off."""

import json

import numpy as np
import pytest
from headless import logs, opened, screenshot

import lwr_dyn
from lwr_dyn.motion import Run
from lwr_dyn.reproduction.lwr4plus.report import reproduce

POSE = 1e-6
"""[m] The page packs joint angles in 32 bits over a turn, 1.5e-9 rad; an arm's length of them is far below this."""
PAGE_BYTES = 6_000_000


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    folder = tmp_path_factory.mktemp("out") / "lwr4plus"
    return folder, reproduce(folder)


def test_everything_promised_is_there(outcome):
    folder, result = outcome
    assert result.holds
    names = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    assert {"tables.txt", "checks.txt", "results.json", "replay.html"} <= names
    for stem in ("lwr4plus", "lwr4plus_printed", "lwr4plus_physical"):
        assert {f"models/{stem}.{x}" for x in ("urdf", "srdf", "xml", "provenance.json")} <= names
    for figure in ("figure_04_path", "figure_06_position_error_pd", "figure_07_path_pd", "torque"):
        assert {f"plots/{figure}.png", f"plots/{figure}.svg"} <= names
    assert (folder / "replay.html").stat().st_size < PAGE_BYTES


def test_the_record_names_errata_exchanged_cells_and_nearest_conditions(outcome):
    record = json.loads((outcome[0] / "results.json").read_text())
    assert record["errata_that_matter"] == ["table1-swapped-yz", "table2-c5z"]
    assert {c["cell"] for c in record["table_vi"] if c["fits"]} == {"Kd_6", "Kp_7"}
    assert len(record["table_vii"]) == len(record["table_viii"]) == 3
    assert all(cell["verdict"] for table in record["table_viii"] for cell in table["cells"])
    assert "nearest: quintic timing" in (outcome[0] / "tables.txt").read_text()


def test_the_page_replays_both_runs_with_the_network_off(outcome, browser):
    folder, _ = outcome
    arm = lwr_dyn.load("lwr4plus")
    runs = [Run.load(folder / "runs" / f"{name}_as_modelled.npz") for name in ("pd-gravity", "inverse-dynamics")]
    address = (folder / "replay.html").as_uri()
    opened(browser, address)
    for k in (0, 6500, 13200):
        for index, run in enumerate(runs):
            script = "lwrReplay.setTime(arguments[0]); return lwrReplay.flangePose(arguments[1])"
            shown = np.array(browser.execute_script(script, float(run.t[k]), index))
            assert np.abs(shown - lwr_dyn.forward_kinematics(arm, run.q[k])).max() < POSE
    requests, console = logs(browser)
    assert requests == [address]
    assert console == []
    screenshot(browser, "main_job.png")
