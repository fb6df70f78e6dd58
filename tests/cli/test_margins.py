"""`lwr-dyn margins` as a user types it."""

import pytest

POSE = ("--q-deg", "0,30,0,-60,0,30,0")
PHYSICAL = ("lwr4plus", "--reading", "physical")


@pytest.mark.slow
def test_the_json_has_the_keys_that_programs_read(recorded):
    record = recorded("margins", "lwr4plus", "--reading", "computed", "--poses", "100")
    assert 0.1 < record["unstable_share"] < 0.4
    assert 6000 < record["least_rate_hz"] < 7000
    assert (len(record["worst_q"]), record["worst_joint"]) == (7, "joint_1")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "code"), [((), 0), (("--limit", "1.7"), 0), (("--limit", "1.01"), 1), (("--delay", "30"), 0)]
)
def test_a_limit_that_is_given_and_not_kept_is_exit_1(options, code, lwr_dyn_command):
    assert lwr_dyn_command("margins", *PHYSICAL, *POSE, *options)[0] == code


@pytest.mark.slow
def test_options_of_the_controller_the_loop_and_the_plant_reach_the_loop(recorded):
    def worst(*options):
        return recorded("margins", *PHYSICAL, *POSE, *options)["worst"]

    plain = worst()
    for options in (
        ("--omega-n", "20"), ("--controller", "inverse-dynamics+motor-side"), ("--delay", "1", "--rate", "2000"),
        ("--velocity-cutoff", "100"), ("--payload", "7"), ("--plant-reading", "computed"),
    ):  # fmt: skip
        assert worst(*options)["radius"] != plain["radius"], options
    link, motor = (worst("--elastic", "1e4", "--encoders", side) for side in ("link", "motor"))
    assert (link["stable"], motor["stable"]) == (False, True)


@pytest.mark.slow
def test_poses_along_a_task(recorded):
    record = recorded("margins", *PHYSICAL, "--task", "ist", "--controller", "inverse-dynamics")
    assert (record["poses"], record["where"]) == (200, "given poses")


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


@pytest.mark.slow
def test_pictures_are_written_and_named(printed, folder):
    out = printed("margins", *PHYSICAL, *POSE, "--plot", "bode", "--plot", "my_nyquist.svg")
    written = [line.removeprefix("wrote ") for line in out.splitlines() if line.startswith("wrote ")]
    assert written == ["bode.png", "bode.svg", "my_nyquist.png", "my_nyquist.svg"]
    assert all((folder / name).stat().st_size > 5000 for name in written)


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (("--rate", "0"), "rate: 0.0; allowed: a number above 0"),
        (("--delay", "200"), "a whole number of samples from 0 to 100"),
        (("--delay", "60", "--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05"),
         "--delay: 60 samples at 1000 Hz; allowed: less than the 0.05 s of the task"),
        (("--limit", "0.9"), "limit of |S_ii|: 0.9; allowed: a number above 1"),
        (("--poses", "0"), "poses: 0; allowed: a whole number above 0"),
        (("--elastic", "soft"), "--elastic: 'soft'; allowed: a stiffness above 0 in N m/rad, or file"),
        (("--elastic", "-1"), "stiffness"),
        (("--encoders", "link"), "--encoders: would do nothing here; allowed: with --elastic"),
        (("--velocity-cutoff", "600"), "below 500 Hz"),
        (("--controller", "nothing"), "nothing"),
        ((*POSE, "--poses", "5"), "--poses: would do nothing here"),
        ((*POSE, "--task", "ist"), "--task: would do nothing here; allowed: without --q-deg"),
        ((*POSE, "--from-deg", "0,0,0,0,0,0,0"), "--from-deg: would do nothing here"),
        (("--q-deg", "0,0"), "--q-deg: 2 numbers"),
        (("--plot", "chart"), "no picture named 'chart'"),
        (("--plot", "bode.pdf"), "ends in .pdf"),
        (("--map-joints", "1,2"), "--map-joints: would do nothing here; allowed: with --plot map"),
        ((*POSE, "--plot", "map", "--map-joints", "1,9"), "two of the joints 1 to 7"),
        ((*POSE, "--plot", "map", "--map-joints", "1.5,2"), "two joints counted from 1"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(options, fault, refused, folder):
    assert fault in refused("margins", *PHYSICAL, *options)
    assert not list(folder.iterdir())


def test_an_arm_without_inertias_is_refused(refused):
    assert "masses and inertias not given" in refused("margins", "lwr4")
