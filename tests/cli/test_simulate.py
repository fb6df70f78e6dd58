"""`lwr-dyn simulate`: every option reaches the loop, the run is that of the library, what it prints and refuses."""

from types import SimpleNamespace

import click
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.cli import simulate
from lwr_dyn.cli.simulate import friction_lines, run_document
from lwr_dyn.foundation.errors import DivergenceError, OptionError
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.contact import ACTIVE_FRICTION
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop

POSE = "0,30,0,-60,0,30,0"
Q = np.radians([0, 30, 0, -60, 0, 30, 0])
SHORT = ("--task", "hold", "--from-deg", POSE, "--duration", "0.05")
TASK = ("--task", "hold", "--from-deg", "0,0,0,10,0,0,0", "--duration", "0.01")
STOP = OptionError("stop", "here", "nothing")
NOTHING = "would do nothing here; allowed:"
FIELDS = ("payload", "encoder", "rate", "method", "substeps", "continuous", "delay", "elasticity", "encoders", "loop",
          "seed", "saturate", "friction", "position_limits", "allow_unphysical", "meta")  # fmt: skip


@pytest.fixture
def loop_of(asked, lwr_dyn_command):
    """What the options make of the loop: arm, law, task and loop, as they stand before the run."""

    def run(*options, robot="lwr4plus"):
        calls = asked("lwr_dyn.cli.simulate.prepare", STOP)
        code, _, err = lwr_dyn_command("simulate", robot, *SHORT, *options)
        assert (code, err.splitlines()[-1]) == (2, "lwr-dyn: stop: here; allowed: nothing")
        return calls[0][0]

    return run


@pytest.mark.parametrize(
    ("options", "changed"),
    [
        ((), {}),
        (("--rate", "500", "--delay", "2", "--substeps", "3", "--no-saturation", "--no-stops",
          "--allow-unphysical", "--friction", "none", "--loop", "compiled", "--payload", "2"),
         {"rate": 500.0, "delay": 2, "substeps": 3, "saturate": False, "position_limits": False,
          "allow_unphysical": True, "friction": "none", "loop": "compiled", "payload": 2.0}),
        (("--encoder-bits", "14"), {"encoder": Encoder.of_bits(14, 0.0, 100.0)}),
        (("--encoder-bits", "14", "--encoder-noise", "1e-5", "--velocity-cutoff", "50", "--seed", "3"),
         {"encoder": Encoder.of_bits(14, 1e-5, 50.0), "seed": 3}),
        (("--encoder-noise", "1e-5"), {"encoder": Encoder(0.0, 1e-5, 100.0)}),
        (("--continuous",), {"continuous": True}),
        (("--elastic", "2e4", "--encoders", "link", "--method", "radau"),
         {"method": "radau", "elasticity": 2e4, "encoders": "link",
          "meta": {"plant": "elastic joints of 2e4 N m/rad, link encoders"}}),
        (("--elastic", "file", "--plant-scale", "1.1", "--plant-reading", "computed"),
         {"elasticity": "file",
          "meta": {"plant": "reading computed, masses times 1.1, elastic joints, motor encoders"}}),
        (("--payload", "3", "--payload-known"), {"payload": 3.0, "meta": {"payload_known": True}}),
    ],
)  # fmt: skip
def test_options_reach_the_loop(loop_of, options, changed):
    arm, _, reference, loop = loop_of("--controller", "pd-gravity", *options)
    usual = Loop()
    expected = {name: getattr(usual, name) for name in FIELDS} | changed
    expected["meta"] = {"task": "hold", **(changed.get("meta") or {})}
    assert {name: repr(getattr(loop, name)) for name in FIELDS} == {name: repr(x) for name, x in expected.items()}
    assert (arm.name, arm.reading, reference.duration) == ("lwr4plus", "physical", 0.05)
    np.testing.assert_allclose(reference.sample(0.0).q[0], Q)


@pytest.mark.parametrize(
    ("options", "reading", "factor", "shared"),
    [
        ((), "physical", 1.0, True),
        (("--payload", "1"), "physical", 1.0, False),
        (("--payload", "1", "--payload-known"), "physical", 1.0, True),
        (("--plant-scale", "1.2"), "physical", 1.2, False),
        (("--plant-reading", "computed"), "computed", 1.0, False),
        (("--plant-reading", "computed", "--plant-scale", "0.9", "--mount", "wall"), "computed", 0.9, False),
    ],
)
def test_the_plant_is_the_arm_changed_and_shares_its_model_where_it_is_the_controllers(loop_of, options, reading,
                                                                                      factor, shared):  # fmt: skip
    arm, law, _, loop = loop_of("--controller", "inverse-dynamics", *options)
    own = lwr_dyn.load("lwr4plus", reading)
    masses = [factor * body.mass for body in own.bodies()]
    assert [body.mass for body in loop.plant.bodies()] == pytest.approx(masses)
    assert (loop.plant.reading, loop.plant.loaded_with) == (reading, arm.loaded_with)
    assert isinstance(loop.engine, str) != shared
    known = 1.0 if "--payload-known" in options else 0.0
    models = lwr_dyn.load("lwr4plus", mount="wall") if "--mount" in options else lwr_dyn.load("lwr4plus")
    loaded = lwr_dyn.load("lwr4plus", tool={"mass": known}) if known else models
    q_ref = Q + 0.01
    expected = lwr_dyn.controller("inverse-dynamics", loaded)(0.0, Q, 0 * Q, q_ref, 0 * Q, 0 * Q)
    np.testing.assert_allclose(law(0.0, Q, 0 * Q, q_ref, 0 * Q, 0 * Q), expected, rtol=1e-9)


def test_the_run_its_files_and_the_lines_are_those_of_the_library(asked, printed, recorded, folder):
    """With another gain and payload; the page is written last and no line leads to another where it is there."""
    arm = lwr_dyn.load("lwr4plus")
    hold = lwr_dyn.reference("hold", arm, q=Q, duration=0.05)
    law = lwr_dyn.controller("inverse-dynamics", arm, omega_n=30.0)
    expected = lwr_dyn.simulate(arm, law, hold, payload=1.5, rate=500.0)
    line = ("simulate", "lwr4plus", *SHORT, "--controller", "inverse-dynamics", "--omega-n", "30", "--payload", "1.5",
            "--rate", "500", "--substeps", "1", "--out", "run.npz", "--csv", "run.csv")  # fmt: skip
    pages = asked("lwr_dyn.pages.replay.replay_page.write_replay")
    for more, full, last in (
        ((), False, ["wrote run.npz; see it:  lwr-dyn replay run.npz --html run.html"]),
        (("--full", "--html", "x.html"), True, ["wrote x.html", "wrote run.npz"]),
    ):
        out = printed(*line, *more)
        run = Run.load("run.npz")
        for name in ("t", "q", "dq", "tau_command"):
            np.testing.assert_array_equal(getattr(run, name), getattr(expected, name))
        assert out == "\n".join([run_document(run, arm, full).text(), "wrote run.csv", *last, ""])
        np.testing.assert_array_equal(read_log("run.csv", {}, arm).q, run.q)
    ((path, runs, own), _) = pages[0]
    assert (path, len(runs), own.name, len(pages)) == ("x.html", 1, "lwr4plus", 1)
    record = recorded(*line)
    assert record["metrics"]["tip_max_mm"] == pytest.approx(1e3 * np.linalg.norm(
        lwr_dyn.forward_kinematics(arm, expected.q)[:, :3, 3] - lwr_dyn.forward_kinematics(arm, Q)[:3, 3], axis=1
    ).max(), rel=1e-6)  # fmt: skip
    meta = record["meta"]
    assert (meta["robot"], meta["reading"], meta["payload"]["mass"], meta["options"]["rate"], len(meta["digest"])) == (
        "lwr4plus", "physical", 1.5, 500.0, 64,
    )  # fmt: skip
    assert {"lwr_dyn", "numpy", "pin"} <= set(meta["versions"])
    assert abs(meta["audit"]["residual"]) < 1e-9


def test_a_run_that_diverges_keeps_its_samples_and_is_refused(asked, lwr_dyn_command, folder, two_runs):
    asked("lwr_dyn.cli.simulate.run_setup", DivergenceError(0.1, "joint_2", "9", "less", two_runs[0]))
    code, out, err = lwr_dyn_command("simulate", "lwr4plus", *SHORT, "--out", "run.npz")
    assert (code, out) == (2, "kept what was computed in run.npz\n")
    assert err.splitlines()[-1] == "lwr-dyn: the simulation diverges at t = 0.1 s: joint_2: 9; allowed: less"
    np.testing.assert_array_equal(Run.load("run.npz").q, two_runs[0].q)
    assert lwr_dyn_command("simulate", "lwr4plus", *SHORT)[1] == ""
    fast = ("--omega-n", "3000", "--no-saturation", "--controller", "inverse-dynamics", "--elastic", "file")
    notes = lwr_dyn_command("simulate", "lwr4plus", *SHORT, *fast)[2].splitlines()[-3:-1]
    assert ["unstable" in line for line in notes] == [True, True]


def test_friction_is_said_in_words():
    """Its form, what a refit changed, where it drives joint by joint; nothing without friction."""
    arm = lwr_dyn.load("wam7")
    before, after = {"coulomb": 1.5, "viscous": 0.25}, {"coulomb": 2.0, "viscous": 0.0}
    change = {"joint": "joint_4", "side": "positive", "before": before, "after": after, "rms": 0.3121, "speed": 1.5}
    events = [SimpleNamespace(kind=kind, joint=joint, t=0.25, value=-1.23456)
              for kind, joint in ((ACTIVE_FRICTION, 3), ("stop", 1), (ACTIVE_FRICTION, 0))]  # fmt: skip
    run = SimpleNamespace(
        meta={"friction_law": {"form": "set-valued"}, "note": {"passive_refit": [change]}}, events=events
    )
    drives = "feeds energy in from 0.25 s on, at -1.235 rad/s (m/s)"
    assert friction_lines(run, arm) == [
        "friction of the plant: set-valued",
        "passive refit of joint_4, positive: F_c 1.5000, sigma 0.2500 -> F_c 2.0000, sigma 0.0000; "
        "RMS 0.312 N m up to 1.5 rad/s",
        f"warning: friction of joint_1 {drives}", f"warning: friction of joint_4 {drives}",
    ]  # fmt: skip
    assert friction_lines(SimpleNamespace(meta={"friction_law": {"form": "none"}}), arm) == []


def test_laws_with_wrappers_are_taken(printed):
    line = ("simulate", "wam7", *TASK, "--controller", "inverse-dynamics+friction", "--omega-n", "20")
    assert "friction of dq_ref added" in printed(*line)
    names = "inverse-dynamics,inverse-dynamics+friction-measured"
    assert "friction of dq added" in printed("compare", "wam7", *TASK, "--controllers", names, "--plants", "friction")


BAD = [
    (("--rate", "0"), "rate: 0.0; allowed: a number above 0"),
    (("--rate", "1e9"), "allowed"),
    (("--omega-n", "1e200"), "allowed"),
    (("--substeps", "0"), "substeps: 0; allowed: a whole number from 1 to 1000"),
    (("--substeps", "99999999999"), "substeps: 99999999999; allowed: a whole number from 1 to 1000"),
    (("--omega-n", "-5"), "omega_n: -5.0; allowed: a number above 0"),
    (("--controller", "pid", "--ki", "-1"), "Ki"),
    (("--payload", "-3"), "payload mass: -3.0; allowed: a number >= 0"),
    (("--plant-scale", "0"), "mass factor: 0.0; allowed: a number above 0"),
    (("--duration", "-1"), "durations: -1.0; allowed: a number from 1e-09"),
    (("--encoder-bits", "41"), "--encoder-bits: 41; allowed: a whole number from 1 to 40"),
    (("--encoder-bits", "0"), "--encoder-bits: 0; allowed: a whole number from 1 to 40"),
    (("--encoder-bits", "12", "--velocity-cutoff", "900"), "below 500 Hz"),
    (("--encoder-noise", "1e-5", "--seed", "-1"), "seed: -1; allowed: a whole number from 0 on"),
    (("--controller", "fuzzy"), "'fuzzy' is not one of 'pd-gravity', 'pid', 'inverse-dynamics'"),
    (("--plant-reading", "real"), "no reading of lwr4plus named 'real'"),
    (("--out", "none/run.npz"), "none/run.npz: no directory none"),
    (("--out", "run.txt"), "run.txt: ends in '.txt'; allowed: a path that ends in one of .npz,"),
    (("--csv", "run.txt"), "run.txt: does not end in .csv"),
    (("--html", "run.txt"), "run.txt: does not end in .html"),
    (("--from-deg", "0,130,0,0,0,0,0"), "joint_2"),
    (("--task", "point-to-point"), "--to-deg: not given"),
    (("--ki", "3"), f"--ki: {NOTHING} with --controller pid"),
    (("--payload-known",), f"--payload-known: {NOTHING} with --payload"),
    (("--encoder-bits", "16", "--seed", "3"), f"--seed: {NOTHING} with --encoder-noise"),
    (("--velocity-cutoff", "50"), f"--velocity-cutoff: {NOTHING} with --encoder-bits or --encoder-noise"),
    (("--timing", "quintic"), f"--timing: {NOTHING} with --task ist, ist-clear"),
    (("--method", "dop853", "--substeps", "2"), f"--substeps: {NOTHING} with --method rk4"),
    (("--encoders", "link"), f"--encoders: {NOTHING} with --elastic"),
    (("--passive-refit",), "--passive-refit: lwr4plus has no friction; allowed: with an arm whose friction is known"),
    (("--own-gains",), "lwr4plus: controller gains not given; needed for own_gains (--own-gains)"),
    (("--controller", "motor-pd", "--gear-stiffness", "0"), "gear_stiffness: 0; allowed: a number above 0 in N m/rad"),
    *((("--elastic", x), f"--elastic: {x!r}; allowed: a stiffness above 0 in N m/rad, or file")
      for x in ("0", "-1", "inf", "nan")),
    (("--controller", "inverse-dynamics+friction"), "friction of its joints not given"),
]  # fmt: skip


@pytest.mark.parametrize(("options", "message"), BAD, ids=lambda x: " ".join(x)[:40] if isinstance(x, tuple) else "")
def test_bad_options_get_one_line(options, message, refused, folder):
    assert message in refused("simulate", "lwr4plus", *SHORT, *options)
    assert list(folder.iterdir()) == []


LAW, LAWS = ("simulate", "--controller"), ("compare", "--controllers")


@pytest.mark.parametrize(
    ("command", "given", "words"),
    [
        (LAW, ("pid+fricton",), "did you mean friction?"),
        (LAW, ("pdi+friction",), "did you mean"),
        (LAW, ("inverse-dynamics+friction", "--ki", "3"), NOTHING),
        (LAWS, ("pid+fricton,pid",), "did you mean friction?"),
        (LAWS, ("pdi+friction,pid",), "did you mean pid?"),
    ],
)
def test_bad_names_of_laws_are_one_line(refused, command, given, words):
    assert words in refused(command[0], "wam7", *TASK, command[1], *given)


def test_a_path_that_leaves_the_limits_is_refused_with_its_place(refused):
    """It goes on through half a turn, beyond the limit of joint 1."""
    err = refused("simulate", "lwr4plus", "--arm-angle-deg", "0")
    assert all(words in err for words in ("at t = ", "point (", "joint_1 at 4.58"))
    assert "--from-deg: not given" in refused("simulate", "lwr4plus", "--task", "point-to-point")


@pytest.fixture
def own(folder):
    """A function that writes an arm of such joints, with a text replaced."""

    def write(joints, old="", new=""):
        (folder / "own.toml").write_text(template("own.toml", "own", joints).replace(old, new), encoding="utf-8")
        return "own.toml"

    return write


def test_a_run_of_an_own_or_locked_arm_can_be_replayed_while_its_file_is_the_same(own, lwr_dyn_command, refused):
    line = ("simulate", own("RPR"), "--lock", "joint_2=0.2", "--task", "hold", "--from-deg", "10,20", "--duration",
            "0.05", "--controller", "inverse-dynamics")  # fmt: skip
    assert lwr_dyn_command(*line, "--out", "run.npz")[0] == 0
    assert Run.load("run.npz").n == 2
    assert lwr_dyn_command("replay", "run.npz", "--html", "page.html")[0] == 0
    own("RPR", "values = [0.3, 0]", "values = [0.9, 0]")
    own("RPR", "[0.01, 0, 0]", "[0.02, 0, 0]")
    assert "has changed since the run was made" in refused("replay", "run.npz", "--html", "x.html")
    assert "lock of joint_2: 0.9" in refused(*line[:3], "joint_2=0.9", *line[4:])
    assert "no joint of own named 'joint_9'" in refused("check", "own.toml", "--lock", "joint_9=0")


def test_sliding_joints_are_printed_in_their_units(own, printed):
    move = ("--task", "hold", "--from-deg", "0,0.2,0", "--duration", "0.05", "--controller", "inverse-dynamics")
    lines = printed("simulate", own("RPR"), *move).splitlines()
    rows = {line.split()[0]: line.split()[1] for line in lines if line.startswith("joint_")}
    assert rows == {"joint_1": "mrad", "joint_2": "mm", "joint_3": "mrad"}


def test_an_infeasible_arm_is_refused_unless_allowed(own, lwr_dyn_command, refused):
    move = ("--task", "point-to-point", "--from-deg", "0,0", "--to-deg", "20,-10", "--duration", "0.1")
    line = ("simulate", own("RR", "[0, 0, 0.004]]", "[0, 0, 0.03]]"), *move, "--controller", "inverse-dynamics")
    assert "own (printed): the inertia of link_1, link_2 is not physical" in refused(*line)
    assert lwr_dyn_command(*line, "--allow-unphysical")[0] == 0
    assert "inertias that no body can have: link_1, link_2" in lwr_dyn_command("urdf", "own.toml")[1]


@pytest.mark.parametrize("task", ["ist", "ist-clear"])
def test_the_letters_are_refused_by_name_for_an_arm_that_cannot_write_them(own, refused, task):
    err = refused("simulate", own("RR"), "--task", task)
    assert err.startswith(f"lwr-dyn: task {task}, robot: own; allowed: a seven-joint arm")
    assert err.endswith("other arms have other tasks, as point-to-point\n")


@pytest.mark.slow
def test_a_payload_over_the_rated_one_is_warned_of_in_one_line(lwr_dyn_command):
    task = ("simulate", "kr30ha", "--task", "hold", "--from-deg", "0,-90,90,0,0,0", "--duration", "0.02")
    task = (*task, "--controller", "inverse-dynamics")  # stable everywhere: no note on sampling
    code, _, err = lwr_dyn_command(*task, "--payload", "31", "--payload-known")
    assert (code, err) == (0, "lwr-dyn: warning: kr30ha: a payload of 31 kg is over the rated 30 kg\n")
    assert lwr_dyn_command(*task, "--payload", "30")[2] == ""


def test_a_controller_is_a_name_or_a_python_file():
    kind = simulate.NameOrFile(["pid"])
    assert [kind.convert(x, None, None) for x in ("pid", "folder/mine.py", "mine.py+friction")] == [
        "pid", "folder/mine.py", "mine.py+friction",
    ]  # fmt: skip
    assert kind.get_metavar(click.Option(["--x"])) == "[pid|FILE.py]"
    with pytest.raises(click.BadParameter, match=r"'mine\.txt' is not"):
        kind.convert("mine.txt", None, None)


def test_an_arm_for_which_nothing_is_asked_gets_a_task_of_its_own_that_is_said(lwr_dyn_command):
    code, out, err = lwr_dyn_command("simulate", "kr30ha")
    assert code == 0
    assert "task move, 2 s" in out
    assert "position and speed kept; torque unknown" in out
    assert "task: point-to-point, chosen for this arm (--task move): (" in err


def test_options_of_a_task_and_a_law_keep_to_what_was_chosen(recorded, refused):
    record = recorded("simulate", "kr30ha", "--duration", "5", "--velocity-error")
    assert record["meta"]["reference"]["duration"] == 5.0
    assert record["meta"]["controller"]["name"] == "pd-gravity"
    assert record["meta"]["note"]["chosen"][0].startswith("task: point-to-point, chosen for this arm")
    assert f"--timing: {NOTHING} with --task ist" in refused("simulate", "kr30ha", "--timing", "smooth")


def test_steps_are_chosen_where_none_are_typed_and_they_matter(recorded):
    task = ("--task", "point-to-point", "--from-deg", "0,0,0,0,0,0,0", "--to-deg", "60,60,60,60,60,60,60")
    coarse = (*task, "--duration", "0.6", "--rate", "40", "--controller", "inverse-dynamics", "--omega-n", "10")
    chosen = recorded("simulate", "lwr4plus", *coarse)["meta"]
    assert chosen["options"]["substeps"] > 1
    assert chosen["note"]["chosen"][-1].startswith(f"substeps: {chosen['options']['substeps']}, chosen for this run")
    typed = recorded("simulate", "lwr4plus", *coarse, "--substeps", "1")["meta"]
    assert (typed["options"]["substeps"], "chosen" in typed["note"]) == (1, False)


@pytest.mark.slow
def test_a_bag_is_written_and_its_topics_are_named_one_by_one(lwr_dyn_command, printed, tmp_path):
    bag = str(tmp_path / "run.mcap")
    assert printed("simulate", "lwr4plus", *SHORT, "--out", bag).splitlines()[-1] == f"wrote {bag}"
    topics = [word for x in ("q", "dq", "tau") for word in ("--columns", f"{x}=/joint_states")]
    line = ("identify", "friction", "lwr4plus", bag)
    for words, said in (
        (topics, "cruise"),
        (topics[:4], "tau: effort of these joints in /joint_states, /reference, /friction; needed: one topic"),
        ((*topics, "--columns", "q=/reference"), "lwr-dyn: --columns: q twice; allowed: each quantity once\n"),
    ):
        code, _, err = lwr_dyn_command(*line, *words)
        assert (code, said in err) == (2, True)


@pytest.mark.slow
def test_a_loop_far_faster_than_its_samples_diverges_and_keeps_what_was_computed(lwr_dyn_command, folder):
    options = ("--omega-n", "3000", "--no-saturation", "--controller", "inverse-dynamics", "--encoder-noise", "1e-3")
    code, out, err = lwr_dyn_command("simulate", "lwr4plus", *SHORT[:-1], "1", *options, "--out", "run.npz")
    assert (code, "kept what was computed" in out) == (2, True)
    assert err.splitlines()[-1].startswith("lwr-dyn: the simulation diverges at t = ")
    assert 1 < Run.load("run.npz").t.size < 1001
