"""`lwr-dyn margins`: what is typed reaches the judgement, its report is what is shown, exit codes, bad input."""

from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.design.margins import LIMIT, margins
from lwr_dyn.design.sampled_stability import PLACES, POSES, SEED
from lwr_dyn.foundation.document import Document
from lwr_dyn.model.caveats import ABSENT_ROTORS, ALL, DYNAMICS

BENT = "0,30,0,-60,0,30,0"
POSE = ("--q-deg", BENT)
Q = np.radians([0, 30, 0, -60, 0, 30, 0])
PHYSICAL = ("lwr4plus", "--reading", "physical")
USUAL = {"rate": 1000.0, "delay": 0, "cutoff_hz": None, "elasticity": None, "encoders": "motor", "limit": LIMIT,
         "poses": POSES, "seed": SEED}  # fmt: skip
ALONG = ("--task", "point-to-point", "--from-deg", BENT, "--to-deg", "9,40,0,-60,0,30,0", "--duration", "0.5")
ASKED = "lwr_dyn.cli.margins.margins"


def report(holds=True):
    return SimpleNamespace(document=Document("", "judged", ()), holds=holds)


@pytest.mark.parametrize(
    ("options", "law", "changed", "q"),
    [
        ((), "pd-gravity", {}, None),
        (("--rate", "500", "--delay", "2", "--velocity-cutoff", "90", "--poses", "7", "--seed", "3", "--limit", "1.4",
          "--controller", "pid", "--ki", "3"), "pid",
         {"rate": 500.0, "delay": 2, "cutoff_hz": 90.0, "poses": 7, "seed": 3, "limit": 1.4, "ki": 3.0}, None),
        (("--elastic", "1e4", "--encoders", "link", "--q", ",".join(map(repr, Q.tolist()))), "pd-gravity",
         {"elasticity": 1e4, "encoders": "link"}, Q),
        (("--elastic", "file", "--controller", "inverse-dynamics+motor-side", "--omega-n", "20", *POSE),
         "inverse-dynamics+motor-side", {"elasticity": "file", "omega_n": 20.0}, Q),
        (ALONG, "pd-gravity", {}, lwr_dyn.reference("point-to-point", lwr_dyn.load("lwr4plus"), start=Q,
         end=np.radians([9, 40, 0, -60, 0, 30, 0]), duration=0.5).sample(np.linspace(0.0, 0.5, PLACES)).q),
    ],
)  # fmt: skip
def test_what_is_typed_reaches_the_judgement(asked, printed, options, law, changed, q):
    calls = asked(ASKED, report())
    assert printed("margins", *PHYSICAL, *options).splitlines()[-1] == "judged"
    ((arm, controller), given) = calls[0]
    where, plant = given.pop("q"), given.pop("plant")
    assert ((arm.name, arm.reading), controller, plant, given) == (("lwr4plus", "physical"), law, None, USUAL | changed)
    assert (where is None) == (q is None)
    if q is not None:
        np.testing.assert_allclose(np.reshape(where, np.shape(q)), q, atol=1e-12)


@pytest.mark.parametrize(
    ("options", "reading", "load"),
    [
        (("--payload", "2"), "physical", 2.0),
        (("--plant-reading", "computed"), "computed", 0.0),
        (("--plant-reading", "computed", "--payload", "3", "--mount", "wall"), "computed", 3.0),
    ],
)
def test_the_plant_is_another_reading_with_the_load_as_the_arm_stands(asked, printed, options, reading, load):
    calls = asked(ASKED, report())
    printed("margins", *PHYSICAL, *options)
    (arm,), plant = calls[0][0][:1], calls[0][1]["plant"]
    own = lwr_dyn.load("lwr4plus", reading)
    assert (plant.reading, plant.loaded_with) == (reading, arm.loaded_with)
    masses = [body.mass for body in plant.bodies()]
    assert masses == pytest.approx([body.mass + load * (i == 6) for i, body in enumerate(own.bodies())])


@pytest.mark.parametrize(
    ("options", "holds", "code"),
    [((), True, 0), ((), False, 0), (("--limit", "1.7"), True, 0), (("--limit", "1.7"), False, 1)],
)
def test_a_limit_that_is_given_and_not_kept_is_exit_1(asked, lwr_dyn_command, options, holds, code):
    asked(ASKED, report(holds))
    assert lwr_dyn_command("margins", *PHYSICAL, *options)[0] == code


@pytest.mark.parametrize(
    ("options", "given", "used"),
    [((), {}, DYNAMICS), (("--elastic", "1e4", "--encoders", "link"), {"elasticity": 1e4, "encoders": "link"}, ALL)],
)
def test_the_record_is_that_of_the_library(recorded, as_recorded, options, given, used):
    arm = lwr_dyn.load("lwr4plus", "physical")
    found = margins(arm, "pd-gravity", q=Q, rate=800.0, delay=1, **given)
    record = recorded("margins", *PHYSICAL, *POSE, "--rate", "800", "--delay", "1", *options)
    assert record == as_recorded(found.document, arm, used=(*used, ABSENT_ROTORS))


def test_pictures_are_drawn_of_the_report_and_named(asked, printed, recorded):
    """Those that are asked for, in their order, of the joints counted from 1; none is named in a record."""
    calls = asked(ASKED, report())
    drawn = []
    writers = {"bode": "b.png", "my_map.svg": "m.png"}

    def writer(wish):
        return lambda found, joints: drawn.append((wish, found.holds, joints)) or (writers[wish], f"{wish}.svg")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lwr_dyn.cli.margins.picture_writer", writer)
        out = printed("margins", *PHYSICAL, "--plot", "bode", "--plot", "my_map.svg", "--map-joints", "2,4")
        recorded_too = printed("margins", *PHYSICAL, "--plot", "bode", "--json")
    assert out.splitlines()[-4:] == ["wrote b.png", "wrote bode.svg", "wrote m.png", "wrote my_map.svg.svg"]
    assert drawn == [("bode", True, (1, 3)), ("my_map.svg", True, (1, 3)), ("bode", True, None)]
    assert "wrote" not in recorded_too
    assert len(calls) == 2


@pytest.mark.slow
def test_the_whole_joint_box(recorded):
    record = recorded("margins", "lwr4plus", "--reading", "computed", "--poses", "100")
    assert 0.1 < record["unstable_share"] < 0.4
    assert 6000 < record["least_rate_hz"] < 7000
    assert (len(record["worst_q"]), record["worst_joint"]) == (7, "joint_1")


def test_a_file_of_ones_own_is_linearised_and_this_is_said(printed, refused, tmp_path):
    own = tmp_path / "own.py"
    own.write_text(
        "def make(arm, dynamics):\n"
        "    def law(t, q, dq, q_ref, dq_ref, ddq_ref):\n"
        "        return dynamics.inverse_dynamics(q, dq, 2500 * (q_ref - q) - 100 * dq)\n"
        "    return law\n"
    )
    law = (*PHYSICAL, *POSE, "--controller", str(own))
    assert "the controller has no linear_feedback(q): linearised by central differences" in printed("margins", *law)
    own.write_text("def controller(t, q, dq, q_ref, dq_ref, ddq_ref):\n    return q_ref - qq\n")
    assert "own.py: line 2: NameError" in refused("margins", *law)


NOTHING = "would do nothing here; allowed:"
HOLD = ("--task", "hold", "--from-deg", BENT, "--duration", "0.05")


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (("--rate", "0"), "rate: 0.0; allowed: a number above 0"),
        (("--rate", "0", *HOLD), "rate: 0.0; allowed: a number above 0"),
        (("--delay", "200"), "a whole number of samples from 0 to 100"),
        (("--delay", "50", *HOLD), "--delay: 50 samples at 1000 Hz; allowed: less than the 0.05 s of the task"),
        (("--limit", "0.9"), "limit of |S_ii|: 0.9; allowed: a number above 1"),
        (("--poses", "0"), "poses: 0; allowed: a whole number above 0"),
        (("--elastic", "soft"), "--elastic: 'soft'; allowed: a stiffness above 0 in N m/rad, or file"),
        (("--elastic", "-1"), "stiffness"),
        (("--encoders", "link"), f"--encoders: {NOTHING} with --elastic"),
        (("--velocity-cutoff", "600"), "below 500 Hz"),
        (("--controller", "nothing"), "nothing"),
        (("--ki", "3"), f"--ki: {NOTHING} with --controller pid"),
        ((*POSE, "--poses", "5"), f"--poses: {NOTHING} without --q-deg and --task"),
        (("--q", "0,0,0,0,0,0,0", "--seed", "5"), f"--seed: {NOTHING} without --q-deg and --task"),
        (("--task", "ist", "--poses", "5"), f"--poses: {NOTHING} without --q-deg and --task"),
        (("--task", "ist", "--seed", "5"), f"--seed: {NOTHING} without --q-deg and --task"),
        ((*POSE, "--task", "ist"), f"--task: {NOTHING} without --q-deg"),
        ((*POSE, "--from-deg", "0,0,0,0,0,0,0"), f"--from-deg: {NOTHING} with --task"),
        (("--q-deg", "0,0"), "--q-deg: 2 numbers"),
        (("--plot", "chart"), "no picture named 'chart'"),
        (("--plot", "bode.pdf"), "ends in .pdf"),
        (("--map-joints", "1,2"), f"--map-joints: {NOTHING} with --plot map"),
        (("--plot", "bode", "--map-joints", "1,2"), f"--map-joints: {NOTHING} with --plot map"),
        ((*POSE, "--plot", "map", "--map-joints", "1,9"), "two of the joints 1 to 7"),
        ((*POSE, "--plot", "Map", "--map-joints", "1.5,2"), "--map-joints: 1.5,2; allowed: two joints counted from 1"),
        ((*POSE, "--plot", "map", "--map-joints", "1,2,3"), "--map-joints: 1,2,3; allowed: two joints counted from 1"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(options, fault, refused, folder):
    assert fault in refused("margins", *PHYSICAL, *options)
    assert not list(folder.iterdir())


def test_an_arm_without_inertias_is_refused(refused):
    assert "masses and inertias not given" in refused("margins", "lwr4")


@pytest.mark.slow
def test_pictures_are_drawn_and_named(printed, folder):
    out = printed("margins", *PHYSICAL, *POSE, "--plot", "bode", "--plot", "my_nyquist.svg")
    written = [line.removeprefix("wrote ") for line in out.splitlines() if line.startswith("wrote ")]
    assert written == ["bode.png", "bode.svg", "my_nyquist.png", "my_nyquist.svg"]
    assert all((folder / name).stat().st_size > 5000 for name in written)
