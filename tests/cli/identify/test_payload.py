"""`lwr-dyn identify payload`: what is asked reaches the fit, and its result is what is shown."""

import json

import pytest

from lwr_dyn.identification.logs.joint_log import read_log, write_log
from lwr_dyn.identification.payload.identify_load import CUTOFFS, identify_load
from lwr_dyn.identification.payload.possible_load import load_document, load_warnings
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES, SampleRule
from lwr_dyn.model.arm import arm_with_payload

FIT = "lwr_dyn.cli.identify.payload.identify_load"
USUAL = [SampleRule(cutoff, slowest=DEFAULT_SAMPLES.slowest) for cutoff in CUTOFFS]


@pytest.mark.parametrize(
    ("options", "rules", "friction"),
    [
        ((), USUAL, "directions"),
        (("--cutoff", 12, "--slowest", 0.3, "--fit-friction", "symmetric", "--link-side"),
         [SampleRule(12.0, slowest=0.3, link_side=True)], "symmetric"),
    ],
)  # fmt: skip
def test_options_reach_the_fit(asked, lwr_dyn_command, two, options, rules, friction):
    fit = asked(FIT)
    line = ("identify", "payload", two.file, two.paths[0], "--without", two.paths[1], *options)
    assert lwr_dyn_command(*line) == (0, "", "")
    (logs, arm, *asked_for, empty), _ = fit[0]
    assert ([x.source for x in logs], [x.source for x in empty]) == ([str(two.paths[0])], [str(two.paths[1])])
    assert (arm.name, repr(asked_for)) == ("two", repr([rules, friction]))


def test_a_log_that_is_said_to_be_with_and_without_the_load_is_refused(asked, refused, two):
    fit = asked(FIT)
    err = refused("identify", "payload", two.file, two.paths[0], "--without", two.paths[0])
    assert f"{two.paths[0]}, which is with the load" in err
    assert fit == []


def test_the_record_is_that_of_the_library(lwr_dyn_command, as_recorded, wam, fourier, tmp_path):
    log = fourier(arm_with_payload(wam, 2.0, (0.02, -0.03, 0.1)), wam.friction, seconds=6.0)
    write_log(tmp_path / "log.csv", log)
    found = identify_load([read_log(tmp_path / "log.csv", {}, wam)], wam, [SampleRule(20.0)], "directions", [])
    line = ("identify", "payload", "wam7", tmp_path / "log.csv", "--cutoff", 20)
    code, out, err = lwr_dyn_command(*line, "--json")
    record = json.loads(out)
    assert (code, record) == (0, as_recorded(load_document(found, "wam7"), wam))
    assert record["load"][0]["value"] == pytest.approx(2.0, rel=0.05)
    assert err.splitlines() == [f"lwr-dyn: warning: {line}" for line in load_warnings(found)]
    code, out, _ = lwr_dyn_command(*line)
    assert (code, out) == (0, f"{load_document(found, 'wam7').text()}\n")
