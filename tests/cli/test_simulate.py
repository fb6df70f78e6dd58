"""`lwr-dyn simulate`: what they write, and one line for every bad input, nothing half-written."""

import click
import pytest

from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.cli import simulate
from lwr_dyn.model.run import Run

SHORT = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05")

BAD = {
    "rate": (("--rate", "0"), "rate: 0.0; allowed: a number above 0"),
    "substeps": (("--substeps", "0"), "substeps: 0; allowed: a whole number from 1 to 1000"),
    "gains": (("--omega-n", "-5"), "omega_n: -5.0; allowed: a number above 0"),
    "integral gain": (("--controller", "pid", "--ki", "-1"), "Ki"),
    "payload": (("--payload", "-3"), "payload mass: -3.0; allowed: a number >= 0"),
    "mass factor": (("--plant-scale", "0"), "mass factor: 0.0; allowed: a number above 0"),
    "duration": (("--duration", "-1"), "durations: -1.0; allowed: a number from 1e-09"),
    "encoder": (("--encoder-bits", "99"), "--encoder-bits: 99; allowed: a whole number from 1 to 40"),
    "velocity filter": (("--encoder-bits", "12", "--velocity-cutoff", "900"), "below 500 Hz"),
    "seed": (("--encoder-noise", "1e-5", "--seed", "-1"), "seed: -1; allowed: a whole number from 0 on"),
    "controller": (("--controller", "fuzzy"), "'fuzzy' is not one of 'pd-gravity', 'pid', 'inverse-dynamics'"),
    "plant": (("--plant-reading", "real"), "no reading of lwr4plus named 'real'"),
    "folder that is not there": (("--out", "none/run.npz"), "none/run.npz: no directory none"),
    "other ending": (("--out", "run.txt"), "run.txt: ends in '.txt'; allowed: a path that ends in one of .npz,"),
    "outside the limits": (("--from-deg", "0,130,0,0,0,0,0"), "joint_2"),
    "no start": (("--task", "point-to-point"), "--from-deg: not given"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_options_get_one_line(name, refused, folder):
    options, message = BAD[name]
    start = ("--task", "point-to-point") if name == "no start" else SHORT
    assert message in refused("simulate", "lwr4plus", *start, *options)
    assert list(folder.iterdir()) == []


def test_a_path_that_leaves_the_limits_is_refused_with_its_place(refused):
    err = refused("simulate", "lwr4plus", "--arm-angle-deg", "0")
    assert "at t = " in err
    assert "point (" in err
    assert "joint_1 at 4.58" in err  # it goes on through half a turn, beyond its limit


@pytest.mark.slow
def test_a_run_file_carries_what_made_it_and_loads(recorded, tmp_path):
    target = tmp_path / "run.npz"
    options = ("--controller", "pid", "--payload", "2", "--encoder-noise", "1e-6", "--seed", "3", "--out", str(target))
    record = recorded("simulate", "lwr4plus", *SHORT, *options)
    assert {"mean", "mean_abs", "max", "min", "rms"} <= set(record["metrics"]["position_mrad"])
    run = Run.load(target)
    meta = run.meta
    assert (meta["robot"], meta["reading"], meta["seed"]) == ("lwr4plus", "physical", 3)
    assert meta["controller"]["name"] == "pid"
    assert meta["payload"]["mass"] == 2.0
    assert meta["options"]["rate"] == 1000.0
    assert len(meta["digest"]) == 64
    assert {"lwr_dyn", "numpy", "pin"} <= set(meta["versions"])
    assert abs(meta["audit"]["residual"]) < 1e-9


@pytest.mark.slow
def test_a_diverging_run_names_the_time_and_keeps_its_samples(lwr_dyn_command, tmp_path):
    target = tmp_path / "run.npz"
    options = ("--omega-n", "3000", "--no-saturation", "--controller", "inverse-dynamics", "--encoder-noise", "1e-3")
    # a loop far faster than its samples cannot be held
    code, out, err = lwr_dyn_command("simulate", "lwr4plus", *SHORT[:-1], "1", *options, "--out", str(target))
    assert code == 2
    assert "kept what was computed" in out
    assert err.splitlines()[-1].startswith("lwr-dyn: the simulation diverges at t = ")
    assert all(line.startswith("note: ") for line in err.splitlines()[:-1])
    assert "joint_" in err
    kept = Run.load(target)
    assert 1 < kept.t.size < 1001


@pytest.mark.parametrize("task", ["ist", "ist-clear"])
def test_the_letters_are_refused_by_name_for_an_arm_that_cannot_write_them(refused, tmp_path, task):
    own = tmp_path / "own.toml"
    own.write_text(template("own.toml", "own", "RR"))
    err = refused("simulate", str(own), "--task", task)
    assert err.startswith(f"lwr-dyn: task {task}, robot: own; allowed: a seven-joint arm")
    assert err.endswith("other arms have other tasks, as point-to-point\n")


def test_an_infeasible_arm_is_refused_unless_allowed(lwr_dyn_command, refused, tmp_path):
    own = tmp_path / "own.toml"
    text = template("own.toml", "own", "RR").replace("[0, 0, 0.004]]", "[0, 0, 0.03]]")
    own.write_text(text)
    move = ("--task", "point-to-point", "--from-deg", "0,0", "--to-deg", "20,-10", "--duration", "0.1")
    move = (*move, "--controller", "inverse-dynamics")
    assert "own (printed): the inertia of link_1, link_2 is not physical" in refused("simulate", str(own), *move)
    assert lwr_dyn_command("simulate", str(own), *move, "--allow-unphysical")[0] == 0
    assert "inertias that no body can have: link_1, link_2" in lwr_dyn_command("urdf", str(own))[1]


def test_a_run_of_an_own_or_locked_arm_can_be_replayed(lwr_dyn_command, tmp_path):
    own, run, page = (str(tmp_path / name) for name in ("own.toml", "run.npz", "page.html"))
    lwr_dyn_command("new", "arm", own, "--joints", "RPR")
    move = ("--task", "hold", "--from-deg", "10,20", "--duration", "0.05", "--controller", "inverse-dynamics")
    assert lwr_dyn_command("simulate", own, "--lock", "joint_2=0.2", *move, "--out", run)[0] == 0
    assert Run.load(run).n == 2
    assert lwr_dyn_command("replay", run, "--html", page)[0] == 0
    assert lwr_dyn_command("simulate", own, "--lock", "joint_2=0.9", *move)[2].startswith(
        "lwr-dyn: lock of joint_2: 0.9"
    )
    assert "no joint of own named 'joint_9'" in lwr_dyn_command("check", own, "--lock", "joint_9=0")[2]
    assert lwr_dyn_command("check", own, "--lock", "joint_2=0.2")[0] == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "models"),
    [
        (("--controller", "pid"), 1),
        (("--controller", "inverse-dynamics", "--payload", "1", "--payload-known"), 1),
        (("--payload", "1"), 2),
        (("--plant-reading", "physical"), 2),
        (("--plant-scale", "1.1"), 2),
    ],
)
def test_a_model_is_built_once_where_the_plant_is_the_controllers_model(options, models, recorded, monkeypatch):
    from lwr_dyn.dynamics import pinocchio_engine

    built, build = [], pinocchio_engine.pinocchio_model
    monkeypatch.setattr(pinocchio_engine, "pinocchio_model", lambda arm: built.append(arm) or build(arm))
    assert recorded("simulate", "lwr4plus", *SHORT, *options)["meta"]["engine"] == "pinocchio"
    assert len(built) == models


@pytest.mark.slow
def test_a_payload_over_the_rated_one_is_warned_of_in_one_line(lwr_dyn_command):
    task = ("simulate", "kr30ha", "--task", "hold", "--from-deg", "0,-90,90,0,0,0", "--duration", "0.02")
    task = (*task, "--controller", "inverse-dynamics")  # stable everywhere: no note on sampling
    code, _, err = lwr_dyn_command(*task, "--payload", "31", "--payload-known")
    assert code == 0
    assert err == "lwr-dyn: warning: kr30ha: a payload of 31 kg is over the rated 30 kg\n"
    assert lwr_dyn_command(*task, "--payload", "30")[2] == ""


def test_each_rule_refuses_its_option_where_it_has_no_effect():
    given = {"payload": 0.0, "method": "dop853", "encoder_bits": None, "encoder_noise": 0.0, "elastic": None}
    used = {"payload": 1.0, "method": "rk4", "encoder_bits": None, "encoder_noise": 1e-4, "elastic": "file"}
    assert [rule.holds(given) for rule in simulate.RULES] == [False] * 5
    assert [rule.holds(used) for rule in simulate.RULES] == [True] * 5


def test_a_controller_is_a_name_or_a_python_file():
    kind = simulate.NameOrFile(["pid"])
    assert kind.convert("pid", None, None) == "pid"
    assert kind.convert("folder/mine.py", None, None) == "folder/mine.py"
    with pytest.raises(click.BadParameter, match=r"'mine\.txt' is not"):
        kind.convert("mine.txt", None, None)


@pytest.mark.slow
def test_an_error_of_zero_has_no_sign(lwr_dyn_command):
    code, out, _ = lwr_dyn_command("simulate", "lwr4plus", *SHORT)
    assert code == 0
    assert "joint_2  mrad      0 " in out
    assert " -0 " not in out


TASK = ("--task", "hold", "--from-deg", "0,0,0,10,0,0,0", "--duration", "0.01")


def test_simulate_takes_them(printed):
    out = printed("simulate", "wam7", *TASK, "--controller", "inverse-dynamics+friction", "--omega-n", "20")
    assert "friction of dq_ref added" in out


def test_compare_takes_them(printed):
    names = "inverse-dynamics,inverse-dynamics+friction-measured"
    assert "friction of dq added" in printed("compare", "wam7", *TASK, "--controllers", names, "--plants", "friction")


SIMULATE, COMPARE = ("simulate", "--controller"), ("compare", "--controllers")
BAD_NAMES = {
    "no friction": (SIMULATE, "lwr4plus", ("inverse-dynamics+friction",), "friction of its joints not given"),
    "no wrapper": (SIMULATE, "wam7", ("pid+fricton",), "did you mean friction?"),
    "no law": (SIMULATE, "wam7", ("pdi+friction",), "did you mean"),
    "not of this law": (SIMULATE, "wam7", ("inverse-dynamics+friction", "--ki", "3"), "would do nothing here"),
    "compare, no wrapper": (COMPARE, "wam7", ("pid+fricton,pid",), "did you mean friction?"),
    "compare, no law": (COMPARE, "wam7", ("pdi+friction,pid",), "did you mean pid?"),
}


@pytest.mark.parametrize(("command", "robot", "given", "words"), BAD_NAMES.values(), ids=BAD_NAMES)
def test_bad_names_are_one_line(refused, command, robot, given, words):
    name, option = command
    assert words in refused(name, robot, *TASK, option, *given)


@pytest.mark.parametrize("value", ["0", "-1", "inf", "nan"])
def test_a_stiffness_that_is_not_above_zero_is_refused_by_the_name_of_its_option(refused, value):
    simulated = ("simulate", "lwr4plus", *TASK)
    err = refused(*simulated, "--elastic", value)
    assert f"--elastic: {value!r}; allowed: a stiffness above 0 in N m/rad, or file" in err
    err = refused(*simulated, "--controller", "motor-pd", "--gear-stiffness", value)
    assert f"gear_stiffness: {value}; allowed: a number above 0 in N m/rad" in err


def test_a_default_of_one_law_is_not_shown_as_that_of_all(lwr_dyn_command):
    text = "".join(lwr_dyn_command("simulate", "--help-all")[1].split())
    assert "[default:2000.0(cartesian-impedance)]" in text


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
    assert "--timing: would do nothing here; allowed: with --task ist" in refused(
        "simulate", "kr30ha", "--timing", "smooth"
    )


def test_steps_are_chosen_where_none_are_typed_and_they_matter(recorded):
    task = ("--task", "point-to-point", "--from-deg", "0,0,0,0,0,0,0", "--to-deg", "60,60,60,60,60,60,60")
    coarse = (*task, "--duration", "0.6", "--rate", "40", "--controller", "inverse-dynamics", "--omega-n", "10")
    chosen = recorded("simulate", "lwr4plus", *coarse)["meta"]
    assert chosen["options"]["substeps"] > 1
    assert chosen["note"]["chosen"][-1].startswith(f"substeps: {chosen['options']['substeps']}, chosen for this run")
    typed = recorded("simulate", "lwr4plus", *coarse, "--substeps", "1")["meta"]
    assert typed["options"]["substeps"] == 1
    assert "chosen" not in typed["note"]


@pytest.mark.slow
def test_a_bag_is_written_and_its_topics_are_named_one_by_one(lwr_dyn_command, tmp_path):
    bag = str(tmp_path / "run.mcap")
    code, out, _ = lwr_dyn_command("simulate", "lwr4plus", *SHORT, "--out", bag)
    assert code == 0
    assert out.splitlines()[-1] == f"wrote {bag}"
    topics = [word for x in ("q", "dq", "tau") for word in ("--columns", f"{x}=/joint_states")]
    code, _, err = lwr_dyn_command("identify", "friction", "lwr4plus", bag, *topics)
    assert code == 2
    assert "cruise" in err
    code, _, err = lwr_dyn_command("identify", "friction", "lwr4plus", bag, *topics[:4])
    assert "tau: effort of these joints in /joint_states, /reference, /friction; needed: one topic" in err
    code, _, err = lwr_dyn_command("identify", "friction", "lwr4plus", bag, *topics, "--columns", "q=/reference")
    assert err == "lwr-dyn: --columns: q twice; allowed: each quantity once\n"
