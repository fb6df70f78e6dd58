"""Wrappers behind a controller's name on the command line."""

import pytest

TASK = ("--task", "hold", "--from-deg", "0,0,0,10,0,0,0", "--duration", "0.01")


def test_simulate_takes_them(printed):
    out = printed("simulate", "wam7", *TASK, "--controller", "inverse-dynamics+friction", "--omega-n", "20")
    assert "friction of dq_ref added" in out


def test_compare_takes_them(printed):
    names = "inverse-dynamics,inverse-dynamics+friction-measured"
    assert "friction of dq added" in printed("compare", "wam7", *TASK, "--controllers", names, "--plants", "friction")


SIMULATE, COMPARE = ("simulate", "--controller"), ("compare", "--controllers")
BAD = {
    "no friction": (SIMULATE, "lwr4plus", ("inverse-dynamics+friction",), "friction of its joints not given"),
    "no wrapper": (SIMULATE, "wam7", ("pid+fricton",), "did you mean friction?"),
    "no law": (SIMULATE, "wam7", ("pdi+friction",), "did you mean"),
    "not of this law": (SIMULATE, "wam7", ("inverse-dynamics+friction", "--ki", "3"), "would do nothing here"),
    "compare, no wrapper": (COMPARE, "wam7", ("pid+fricton,pid",), "did you mean friction?"),
    "compare, no law": (COMPARE, "wam7", ("pdi+friction,pid",), "did you mean pid?"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_names_are_one_line(refused, case):
    (command, option), robot, given, words = BAD[case]
    assert words in refused(command, robot, *TASK, option, *given)


@pytest.mark.parametrize("value", ["0", "-1", "inf", "nan"])
def test_a_stiffness_that_is_not_above_zero_is_refused_by_the_name_of_its_option(refused, value):
    simulated = ("simulate", "lwr4plus", *TASK)
    err = refused(*simulated, "--elastic", value)
    assert f"--elastic: {value!r}; allowed: a stiffness above 0 in N m/rad, or file" in err
    err = refused(*simulated, "--controller", "motor-pd", "--gear-stiffness", value)
    assert f"gear_stiffness: {value}; allowed: a number above 0 in N m/rad" in err


def test_a_default_of_one_law_is_not_shown_as_that_of_all(lwr_dyn_command):
    text = "".join(lwr_dyn_command("simulate", "--help")[1].split())
    assert "[default:2000.0(cartesian-impedance)]" in text
