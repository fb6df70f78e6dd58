"""What the subcommands of `identify` share: lines of warnings and faults, exit codes, options of motors."""

from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.cli.identify.log_options import behind_the_gears, chosen_motors, end, joint_logs, sample_rule, warn
from lwr_dyn.cli.identify.payload import command
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.regression.samples import SampleRule

WAM = lwr_dyn.load("wam7")
TWOS = ",".join("2" * 7)


def motors_of(*arguments):
    """The motors by options of `lwr-dyn identify payload`."""
    with command.make_context("payload", ["wam7", "log.csv", *arguments]) as context:
        return chosen_motors(WAM, context.params)


@pytest.mark.parametrize(
    ("faults", "code", "lines"),
    [
        ([], 0, []),
        ([OptionError("--x", "1\n2", "3"), OptionError("--y", "4", "5")], 2,
         ["lwr-dyn: --x: 1 2; allowed: 3", "lwr-dyn: --y: 4; allowed: 5"]),
    ],
)  # fmt: skip
def test_warnings_and_faults_are_a_line_each_and_faults_exit_with_2(capsys, faults, code, lines):
    warn(["one\n  two", "three"])
    with pytest.raises(SystemExit) as stop:
        end(faults)
    out, err = capsys.readouterr()
    assert (stop.value.code, out) == (code, "")
    assert err.splitlines() == ["lwr-dyn: warning: one two", "lwr-dyn: warning: three", *lines]


def test_motors_are_asked_for_and_their_options_need_them():
    assert motors_of() is None
    for option in (("--torque-constant", TWOS), ("--motor-home", TWOS)):
        with pytest.raises(OptionError, match=f"{option[0]}: would do nothing here; allowed: with --motor-side"):
            motors_of(*option)
    with pytest.raises(OptionError, match="--link-side: would do nothing here; allowed: without --motor-side"):
        motors_of("--motor-side", "--link-side")
    motors = motors_of("--motor-side", "--torque-constant", TWOS)
    assert (list(motors.torque_constant), motors.home) == ([2.0] * 7, None)
    assert list(motors_of("--motor-side", "--motor-home", TWOS).home) == [2.0] * 7


def test_a_motor_is_slow_where_its_joints_have_that_speed():
    motors = motors_of("--motor-side")
    assert repr(sample_rule(15.0, 0.1, None, True)) == repr(SampleRule(15.0, slowest=0.1, link_side=True))
    assert repr(sample_rule(None, 0.1, None)) == repr(SampleRule(None, slowest=0.1))
    geared = sample_rule(15.0, 0.1, motors)
    lengths = [float(np.sqrt(sum(x * x for x in row))) for row in motors.transmission.matrix]
    np.testing.assert_allclose(geared.slowest, 0.1 * np.array(lengths), rtol=1e-15)
    assert (geared.cutoff, geared.transmission) == (15.0, motors.transmission)


@pytest.mark.parametrize(
    ("options", "needs", "also"),
    [
        (None, ("q", "tau"), ("dq",)),
        (("--motor-side",), ("qm", "tau"), ()),
        (("--motor-side", "--torque-constant", TWOS), ("qm", "i"), ()),
    ],
)
def test_logs_of_motors_have_other_columns(asked, options, needs, also):
    """Those that a log needs, and that it may have beside them."""
    prepared = SimpleNamespace(notes=(), logs=(), errors=("fault",))
    calls = asked("lwr_dyn.cli.identify.log_options.prepared_logs", prepared)
    motors = None if options is None else motors_of(*options)
    assert joint_logs(["a"], {"q": "deg"}, WAM, motors, ()) == ([], ["fault"])
    (paths, units, arm, _, *found), _ = calls[0]
    assert (paths, units, arm is WAM, *found) == (["a"], {"q": "deg"}, True, needs, also)


def test_no_rotor_is_fitted_to_torques_that_a_robots_file_calls_those_behind_the_gears(capsys):
    panda = lwr_dyn.load("panda")
    said = 'torques are measured behind the gears (torques = "link" in its file): no rotor is fitted'
    for arm, given, found, err in (
        (panda, {"link_side": False}, True, f"lwr-dyn: warning: panda: {said}\n"),
        (panda, {"link_side": True}, True, ""),
        (panda, {"link_side": False, "motor_side": True}, False, ""),
        (WAM, {"link_side": True}, True, ""),
        (WAM, {"link_side": False}, False, ""),
    ):
        assert (behind_the_gears(arm, given), capsys.readouterr().err) == (found, err)
