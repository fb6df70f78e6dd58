"""What the subcommands of `identify` share: lines of warnings and faults, exit codes, options of motors."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.cli.identify.log_options import behind_the_gears, chosen_motors, end, sample_rule, warn
from lwr_dyn.cli.identify.payload import command
from lwr_dyn.foundation.errors import OptionError


def motors_of(*arguments):
    """The motors by options of `lwr-dyn identify payload`."""
    with command.make_context("payload", ["wam7", "log.csv", *arguments]) as context:
        return chosen_motors(lwr_dyn.load("wam7"), context.params)


def test_warnings_and_faults_are_a_line_each(capsys):
    warn(["one\n  two", "three"])
    with pytest.raises(SystemExit) as stop:
        end([OptionError("--x", "1\n2", "3"), OptionError("--y", "4", "5")])
    out, err = capsys.readouterr()
    assert (stop.value.code, out) == (2, "")
    assert err.splitlines() == [
        "lwr-dyn: warning: one two", "lwr-dyn: warning: three", "lwr-dyn: --x: 1 2; allowed: 3",
        "lwr-dyn: --y: 4; allowed: 5",
    ]  # fmt: skip


def test_without_faults_the_exit_code_is_0(capsys):
    with pytest.raises(SystemExit) as stop:
        end([])
    assert (stop.value.code, capsys.readouterr()) == (0, ("", ""))


def test_motors_are_asked_for_and_their_options_need_them():
    assert motors_of() is None
    numbers = ",".join("2" * 7)
    for option in ("--torque-constant", "--motor-home"):
        with pytest.raises(OptionError, match="with --motor-side"):
            motors_of(option, numbers)
    motors = motors_of("--motor-side", "--torque-constant", numbers)
    assert (list(motors.torque_constant), motors.home) == ([2.0] * 7, None)
    assert list(motors_of("--motor-side", "--motor-home", numbers).home) == [2.0] * 7


def test_a_motor_is_slow_where_its_joints_have_that_speed():
    motors = motors_of("--motor-side")
    bare, geared = sample_rule(15.0, 0.1, None), sample_rule(15.0, 0.1, motors)
    assert (bare.cutoff, bare.slowest, bare.transmission) == (15.0, 0.1, None)
    lengths = [float(np.sqrt(sum(x * x for x in row))) for row in motors.transmission.matrix]
    np.testing.assert_allclose(geared.slowest, 0.1 * np.array(lengths), rtol=1e-15)
    assert (geared.cutoff, geared.transmission) == (15.0, motors.transmission)


def test_no_rotor_is_fitted_to_torques_that_a_robots_file_calls_those_behind_the_gears(capsys):
    panda, wam = lwr_dyn.load("panda"), lwr_dyn.load("wam7")
    assert behind_the_gears(panda, {"link_side": False})
    assert "no rotor is fitted" in capsys.readouterr().err
    assert behind_the_gears(wam, {"link_side": True})
    assert not behind_the_gears(wam, {"link_side": False})
    assert not behind_the_gears(panda, {"link_side": False, "motor_side": True})
    assert capsys.readouterr().err == ""
