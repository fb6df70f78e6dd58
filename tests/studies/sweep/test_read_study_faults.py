"""Every fault in the file of a study, as one line with the file and the field."""

import re

import pytest

from lwr_dyn.foundation.errors import FileAccessError, LwrDynError, PaperError
from lwr_dyn.studies.sweep.read_study import read_study
from tests.studies.sweep.texts import HEAD, PAYLOAD, parameter

KR30 = """
robot = "kr30ha"
controllers = ["inverse-dynamics"]
[task]
name = "hold"
from-deg = [0, -90, 90, 0, 30, 0]
duration = 0.5
"""


def swap(old, new):
    return HEAD.replace(old, new)


FAULTS = [
    ("robot = ", "TOML: "),
    ("x = 1", "robot: missing; allowed: text"),
    ("[joints]", "a robot's tables; allowed: a study (lwr-dyn new study FILE ROBOT writes one)"),
    (swap("lwr4plus", "lwr4pluss"), "robot: no robot named 'lwr4pluss' (did"),
    (swap("lwr4plus", "mine.urdf"), "robot: mine.urdf: no such file"),
    (swap('"physical"', '"phys"'), "robot: no reading of lwr4plus named 'phys'"),
    (HEAD.replace("lwr4plus", "lwr4").replace('reading = "physical"', ""), "robot: lwr4: masses"),
    (swap('["inverse-dynamics", "robust:omega_n=20"]', "[]"), "controllers: an empty list; all"),
    (swap("robust:", "robst:"), "controllers[1]: no controller named 'robst' (did you mean robust?"),
    (swap("omega_n", "omega"), "controllers[1]: controller robust: option 'omega' (did you mean omega-n?)"),
    (swap("omega_n=20", "omega_n=-2"), "controllers[1]: omega_n: -2.0; allowed: a number above 0"),
    (swap("robust:omega_n=20", "pid+friction"), "friction of its joints not given"),
    (
        parameter("controller.omega_n", "low = -1\nhigh = 20").replace(":omega_n=20", ""),
        "parameter[0]: omega_n: -1.0; allowed: a number above 0",
    ),
    (swap("robust:omega_n=20", "inverse-dynamics"), "'inverse-dynamics' twice; allowed: each"),
    (swap("robust:omega_n=20", "mine.py") + PAYLOAD, "controllers[1]: mine.py: no such file"),
    ("reding = 1\n" + HEAD, "reding: unknown field (did you mean reading?); allowed: "),
    (HEAD.partition("[task]")[0], "task: missing; allowed: a table"),
    (swap('"hold"', '"held"'), "task.name: no reference named 'held' (did you mean hold?)"),
    (swap("from-deg", "fromdeg"), "task.fromdeg: unknown field (did you mean from-deg?); all"),
    (swap("0, 30, 0,", "0, 30,"), "task.from-deg: 6 numbers; allowed: a list of 7 numbers, one"),
    (swap("0, 30, 0,", "200, 30, 0,") + PAYLOAD, "task: "),
    (swap("0.5", '"0.5"'), "task.duration: '0.5'; allowed: a number (Duration, s)"),
    (swap("from-deg", "# from-deg") + PAYLOAD, "task.from-deg: missing; allowed: a value, which"),
    (HEAD + "[loop]\nrate = 0\n", "loop.rate: 0; allowed: a number above 0"),
    (HEAD + "[loop]\nsubsteps = 0\n", "loop: substeps: 0; allowed: a whole number from 1 to 1000"),
    (HEAD + "[loop]\ncutoff_hz = 600\n", "loop: "),
    (HEAD + '[loop]\nfriction = "set-valued"\n', "loop.friction: 'set-valued'; allowed: one of none, smooth"),
    (HEAD, "parameter: nothing that varies; allowed: one [[parameter]] or more"),
    (parameter("payload.mass", "value = 3"), "parameter: nothing that varies"),
    (parameter("payload.mas", "value = 3"), "parameter[0].path: no parameter path named 'payload.mas' (did you mean p"),
    (parameter("arm.mass.8", "value = 1"), "'8'; allowed: the number of a link, from 1 to 7, or all"),
    (parameter("arm.com.3.w", "value = 0"), "no axis of arm.com named 'w'; allowed: x, y, z"),
    (parameter("payload.mass.3", "value = 0"), "'payload.mass.3'; allowed: payload.mass"),
    (parameter("arm.mass", ""), "parameter[0]: no distribution; allowed: low and high, or mean and"),
    (parameter("payload.mass", "low = 7\nhigh = 0"), "parameter[0]: an empty range, low = 7 and high = 0; allowed: lo"),
    (parameter("payload.mass", "low = 7\nhigh = 7"), "a range of one value, low = 7 and high = 7; allowed: low"),
    (parameter("arm.mass", "low = 0\nhigh = 1"), "parameter[0].low: 0; allowed: a number above 0"),
    (parameter("arm.mass", 'low = "a"\nhigh = 1'), "parameter[0].low: 'a'; allowed: a number above 0"),
    (parameter("arm.mass", "low = 1\nhigh = inf"), "parameter[0].high: inf; allowed: a number above 0"),
    (parameter("payload.mass", "values = []"), "parameter[0].values: an empty list; allowed: one number or more"),
    (parameter("payload.mass", "values = [1, 1.0]"), "parameter[0].values[1]: 1.0 twice; allowed: each once"),
    (parameter("payload.mass", "low = 0\nhigh = 1\ncount = 0"), "parameter[0].count: 0; allowed: a whole number from"),
    (parameter("payload.mass", "low = 0\nhigh = 1\ncount = 1"), "parameter[0].count: 1; allowed: a whole"),
    (parameter("payload.mass", "low = 0\nhigh = 1\ncount = 100001"), "100001; allowed: a whole number from 2 to 10000"),
    (parameter("loop.delay", "low = 0\nhigh = 1\ncount = 3"), "parameter[0].count: 3, a level at 0.5; allowed: a"),
    (parameter("arm.com", "mean = 0\ndeviation = 1\nlow = 2\nhigh = 2"), "an empty range, low = 2 and high = 2"),
    (parameter("arm.com", "mean = 0\ndeviation = 1\nlow = 8.1"), "parameter[0].mean: 0; allowed: a mean within 8 dev"),
    (parameter("arm.com", "mean = 0\ndeviation = 1\nhigh = -8.1"), "parameter[0].mean: 0; allowed: a mean within 8 de"),
    (parameter("payload.known", "mean = 0.5\ndeviation = 1\nlow = 0"), "parameter[0].high: missing, and a normal"),
    (
        parameter("arm.com.3", "value = 0") + '[[parameter]]\npath = "arm.com.all.x"\nvalue = 0\n',
        "arm.com.all.x beside arm.com.3",
    ),
    (parameter("loop.delay", "low = 0\nhigh = 4"), "uniform; allowed: choice or levels: a whole number"),
    (parameter("loop.delay", "values = [0.5, 1]"), "values[0]: 0.5; allowed: a whole number from 0 to 8"),
    (parameter("loop.delay", "values = [0, 9]"), "values[1]: 9; allowed: a whole number from 0 to 8"),
    (parameter("arm.mass", "mean = 1\ndeviation = 0.1"), "parameter[0].low: missing, and a normal distribution passes"),
    (parameter("arm.com", "mean = 0\ndeviation = 0"), "parameter[0].deviation: 0; allowed: a number above 0"),
    (parameter("arm.com", "mean = 1\ndeviation = 0.01\nhigh = 0"), "parameter[0].mean: 1; allowed: a mean w"),
    (parameter("payload.mass", 'value = 1\nkind = "guess"'), "parameter[0].kind: 'guess'; allowed: one of printed"),
    (parameter("payload.mass", "value = 1\nmin = 0"), "parameter[0].min: unknown field"),
    (
        parameter("arm.mass.all", "value = 1") + '[[parameter]]\npath = "arm.mass.3"\nvalue = 1\n',
        "parameter[1].path: arm.mass.3 beside arm.mass.all; allowed: each number once",
    ),
    (parameter("payload.known", "values = [0, 1]"), "payload.known without a payload; allowed: pa"),
    (
        parameter("reading", 'values = ["printed", "phys"]'),
        "parameter[0].values: no reading named 'phys' (did you mean physical?); allowed: physical, printed, computed",
    ),
    (parameter("reading", "low = 0\nhigh = 1"), "'uniform'; allowed: choice (values) or fixed"),
    (
        HEAD + '[loop]\nfriction = "none"\n[[parameter]]\npath = "friction.viscous"\nvalues = [0, 1]\n',
        "friction.viscous beside loop.friction = 'none'; allowed: loop.friction = 'smooth', or left out",
    ),
    (parameter("controller.xi", "low = 1\nhigh = 2"), "controller robust:omega_n=20 has no number 'xi'; allowed: omeg"),
    (
        parameter("controller.omega_n", "low = 10\nhigh = 20"),
        "controller.omega_n, and omega_n in controller 'robust:omega_n=20'; allowed: each in one place",
    ),
    (
        parameter("task.duration", "low = 1\nhigh = 2").replace("duration = 0.5\n", ""),
        "parameter[0].distribution: uniform, and each value is a reference of its own",
    ),
    (parameter("task.duration", "values = [1, 2]"), "task.duration, and duration in [task]; allowed: each"),
    (parameter("task.speeed", "values = [1, 2]"), "task hold has no number 'speeed'"),
    (
        parameter("task.duration", "low = 1\nhigh = 2\ncount = 65").replace("duration = 0.5\n", ""),
        "65 tasks; allowed: at m",
    ),
    (HEAD + PAYLOAD + '[sampling]\nmethod = "sobl"\n', "sampling.method: 'sobl'; allowed: one of grid, sobol"),
    (HEAD + PAYLOAD + "[sampling]\nruns = 0\n", "sampling: runs: 0; allowed: a whole number from 1 to 10000000"),
    (HEAD + PAYLOAD + '[sampling]\nmethod = "grid"\n', "parameter[0].distribution: uniform in a grid; allowed: values"),
    (
        parameter("payload.mass", "values = [0, 1]") + '[sampling]\nmethod = "grid"\nruns = 3\n',
        "sampling: runs: 3 of a grid; allowed: 2, the product of its levels",
    ),
    (HEAD + PAYLOAD + '[sampling]\nmethod = "saltelli"\nruns = 100\n', "runs: 100 by saltelli; allowed: 3 times a pow"),
    (HEAD + PAYLOAD + "[limits]\ntip_mx = 1\n", "limits.tip_mx: no metric named 'tip_mx' (did you mean tip_max?)"),
    (HEAD + PAYLOAD + "[limits]\ntip_q95 = 1\n", "limits.tip_q95: no metric named"),
    (HEAD + PAYLOAD + "[limits]\ntip_max = nan\n", "limits.tip_max: nan; allowed: a number from 0 on, in m"),
    (HEAD + PAYLOAD + "[limits]\ntip_max = -1\n", "limits.tip_max: -1; allowed: a number from"),
    (HEAD + PAYLOAD + "[metrics]\nquantiles = [95]\n", "metrics.quantiles[0]: 95.0; allowed: a share between"),
    (HEAD + PAYLOAD + "[metrics]\ntolerance = 0\n", "metrics.tolerance: 0; allowed: a number above 0"),
    (HEAD + PAYLOAD + "[limits]\nfirst_violation = 1\n", "without a tolerance; allowed: metrics.tolerance"),
    (
        KR30 + PAYLOAD + "[limits]\nsaturated_s = 0\n",
        "limits.saturated_s: torque limits of A1, A2, A3, A4, A5, A6 are unknown; allowed: peak_torque, in N m or N",
    ),
]


@pytest.mark.parametrize(("text", "words"), FAULTS, ids=[words for _, words in FAULTS])
def test_a_fault_is_one_line_with_the_file_and_the_field(text, words, read):
    with pytest.raises(LwrDynError) as caught:
        read(text)
    assert re.search(re.escape(words), str(caught.value)), str(caught.value)
    assert str(caught.value).startswith("s.toml: ")
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value, PaperError)
    assert caught.value.exit_code == 2


def test_another_ending_and_a_missing_file_are_refused(tmp_path):
    for path, words in (("s.txt", "does not end in .toml"), ("s.toml", "no such file")):
        with pytest.raises(FileAccessError, match=words):
            read_study(tmp_path / path)


def test_joints_without_limits_and_rotors_are_named(read):
    pose = "from-deg = [0, -90, 90, 0, 0, 0]\nduration = 0.5\n"
    text = HEAD.replace("lwr4plus", "kr30ha").replace('reading = "physical"', "").partition("from-deg")[0] + pose
    for path, words in (
        ("limits.torque", "limits.torque, and A1 of kr30ha has no torque limit; allowed: joints with one"),
        ("reading", "printed, with other frames of the links than kuka; allowed: readings that differ in"),
        ("arm.armature", "arm.armature, and kr30ha gives no rotors; allowed: an arm with rotors"),
    ):
        values = '["kuka", "printed"]' if path == "reading" else "[1, 2]"
        with pytest.raises(PaperError, match=words):
            read(text + f'[[parameter]]\npath = "{path}"\nvalues = {values}\n')
