"""`lwr-dyn identify elastic`: what is asked reaches the logs and the fit."""

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.regression.samples import SampleRule


def test_options_reach_the_logs_and_the_fit_and_faults_end_it(asked, lwr_dyn_command):
    read = asked("lwr_dyn.cli.identify.elastic.readable_logs", (["a log"], [OptionError("log", "bad", "good")]))
    fit = asked("lwr_dyn.cli.identify.elastic.identify_elastic")
    options = ("--cutoff", 40, "--slowest", 0.2, "--units", "q=deg", "--columns", "q=pos_*")
    said = "lwr-dyn: log: bad; allowed: good\n"
    assert lwr_dyn_command("identify", "elastic", "wam7", "a.csv", "b.csv", *options) == (2, "", said)
    ((paths, units, arm, *more), _), ((logs, same, rule), _) = read[0], fit[0]
    assert (paths, dict(units), *more) == (
        ("a.csv", "b.csv"), {"q": "deg"}, ("q=pos_*",), True, ("q", "qm", "tau"), (),
    )  # fmt: skip
    assert (logs, repr(rule), arm.name) == (["a log"], repr(SampleRule(40.0, slowest=0.2)), "wam7")
    assert same is arm
    asked("lwr_dyn.cli.identify.elastic.readable_logs", ([], []))
    assert lwr_dyn_command("identify", "elastic", "wam7", "a.csv") == (0, "", "")
    assert len(fit) == 1
