"""Ten parameters of a load on a known arm or together with the arm, the body it can be, and what is said of it."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.identification.payload.identify_load import LEAST_SHARE, RULES, body_of, identify_load, load_shift
from lwr_dyn.identification.payload.possible_load import NAMES, UNITS, load_document, possible_load, states
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.chain import is_physical, with_payload
from tests.identification.payload.loaded import ARM, COM, MASS, TENSOR, TRUTH, loaded, logs_of
from tests.identification.plants import Plant, inside, perturbed_plant, random_motion, simulated_log, torques
from tests.identification.table_study import TableStudy
from tests.json_schemas import faults


@pytest.fixture(scope="module")
def known():
    """The arm as its table says, with friction that nothing knows."""
    return perturbed_plant(TorqueColumns(ARM.chain), ARM, np.random.default_rng(1), 0.0)


@pytest.fixture(scope="module")
def none(known):
    return identify_load(logs_of(known, 8), ARM)


@pytest.fixture(scope="module")
def off():
    """An arm 10 per cent off its table, and its load by the table."""
    plant = perturbed_plant(TorqueColumns(ARM.chain), ARM, np.random.default_rng(3), 0.1)
    return plant, identify_load(logs_of(loaded(plant), 4), ARM)


def furthest(found, truth=TRUTH):
    """Of the misses, in standard errors."""
    return np.abs((found.parameters - truth) / found.sigma).max()


def test_the_load_on_a_known_arm_is_recovered(known):
    """Recovery figure: 10 s, 0.1 N m, friction unknown: mass to 4 g, centre to 0.5 mm, tensor to 2e-3 kg m^2.

    The arm is never taken to be its table: where what is left is noise, the load was up to 250 of its errors off.
    """
    found = identify_load(logs_of(loaded(known), 2), ARM)
    miss = found.parameters - TRUTH
    assert furthest(found) < 4.5
    assert abs(miss[0]) < 4e-3
    assert np.abs(found.parameters[1:4] / found.parameters[0] - COM).max() < 5e-4
    assert np.abs(miss[4:]).max() < 2e-3
    assert found.without.max() > 20 * found.left.max()
    kinds = ("coulomb+", "viscous+", "coulomb-", "viscous-")
    assert found.nuisance == tuple(f"{kind}_{j}" for j in range(1, 8) for kind in kinds)
    assert (found.found, found.in_doubt, found.systematic, found.share) == (True, False, (), LEAST_SHARE)
    assert found.determined.all()
    text = load_document(found).text()
    assert "; its errors are those of an arm 3% off its table" in text
    assert "fitted beside it: coulomb+, viscous+, coulomb-, viscous- of the joints" in text
    assert "DOUBT" not in text


@pytest.mark.slow
def test_errors_cover_where_the_arm_is_fitted_too():
    """Errors of noise alone: an arm off its table does not count."""
    arm, z = TableStudy.of("random6"), []
    for run in range(12):
        log, load, bare = arm.loaded("natural", run)
        found = identify_load([log], arm.arm, RULES[:1], unloaded=[bare])
        z.append((found.parameters - load) / found.sigma)
        assert found.share == 0.0
    assert inside(np.array(z)) > 0.98
    assert 0.7 < np.mean(np.square(z)) < 1.4


@pytest.mark.slow
@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_errors_cover_loads_on_arms_off_their_tables(name):
    """A seeded share of the soak line `loads_cover`: 5 % of masses and tensors, 3 mm of centres."""
    arm = TableStudy.of(name)
    z = np.array([arm.load_pulls("natural", run) for run in range(8)])
    assert inside(z) > 0.95
    assert np.abs(z).max() < 5.0


def test_unloaded_logs_take_the_arms_own_errors_out(off):
    """With its table alone the load is wrong by many sigma, with empty runs not."""
    plant, alone = off
    together = identify_load(logs_of(loaded(plant), 4), ARM, unloaded=logs_of(plant, 5))
    assert furthest(together) < 4.5
    assert np.abs(together.parameters[0] - MASS) < 0.02 < np.abs(alone.parameters[0] - MASS)
    assert alone.systematic
    assert together.systematic == ()
    assert together.known == "the arm's geometry; the arm is fitted to 1 log without the load"


def test_friction_of_the_arm_itself_is_taken_where_asked(known):
    plant = loaded(known)
    arm, logs = replace(ARM, friction=plant.columns.friction_of(plant.parameters)), logs_of(plant, 6)
    own = identify_load(logs, arm, friction="own")
    assert furthest(own) < 4.5
    assert (own.nuisance, own.known) == ((), "the arm's inertias and friction")
    for of, options, words in (
        (ARM, {"friction": "own"}, "has none"),
        (arm, {"friction": "own", "unloaded": logs}, "unloaded"),
        (arm, {"friction": "none"}, "directions, symmetric, own"),
    ):
        with pytest.raises(OptionError, match=words):
            identify_load(logs, of, **options)


@pytest.mark.slow
def test_columns_of_a_load_are_those_of_a_body_behind_the_flange():
    """Against the recursion: torques with the load, less torques without it, of an arm whose tool is turned."""
    tool = lwr_dyn.load("lwr4plus", "physical", tool={"xyz": [0.05, 0.0, 0.12], "rpy": [0.4, -0.3, 0.7]})
    columns = TorqueColumns(tool.chain)
    motion = random_motion(tool, 2.0, np.random.default_rng(0))
    chains = tool.chain, with_payload(tool.chain, MASS, COM, TENSOR)
    bare, full = (torques(columns, columns.own(replace(tool, chain=chain)), motion) for chain in chains)
    Y = columns(motion.q, motion.dq, motion.ddq)[:, :, columns.bodies - 10 : columns.bodies]
    assert Y @ load_shift(tool.chain.flange) @ TRUTH == pytest.approx(full - bare, abs=1e-11)


def test_an_arm_that_does_not_move_shows_no_load(known):
    log = logs_of(loaded(known), 9)[0]
    still = replace(log, q=np.broadcast_to(log.q[:1], log.q.shape))
    with pytest.raises(LogError, match="mass is not determined"):
        identify_load([still], ARM)


def test_a_slow_motion_takes_a_low_filter(known):
    """At 20 Hz the noise of accelerations biases the load; the colour of the residuals shows it."""
    plant, rng = loaded(known), np.random.default_rng(11)
    slow = simulated_log(plant, random_motion(ARM, 12.0, rng, rate=1000.0, share=0.15), 0.05, rng, 5e-5)
    fits = {rule.cutoff: identify_load([slow], ARM, [rule]) for rule in RULES}
    chi2 = {c: (f.parameters - TRUTH) @ np.linalg.solve(f.covariance, f.parameters - TRUTH) for c, f in fits.items()}
    chosen = identify_load([slow], ARM)
    assert chosen.cutoff in (5.0, 10.0)
    assert chosen.colour == min(f.colour for f in fits.values())
    assert chi2[chosen.cutoff] < 35.0 < chi2[20.0]


def test_an_arm_off_its_table_puts_the_load_in_doubt_and_widens_its_errors(known):
    """All bodies 15 per cent heavier and no load: that was a load of 0.5 kg at 94 of its errors."""
    heavier = known.parameters.copy()
    heavier[: known.columns.bodies] *= 1.15
    found = identify_load(logs_of(Plant(known.columns, heavier), 8), ARM)
    assert 0.3 < found.parameters[0] < 4.0 * found.sigma[0]
    assert 0.05 < found.share < 0.3
    said = "IN DOUBT: residuals are not noise alone, its errors are those of an arm"
    assert said in load_document(found).verdict


def test_the_load_is_a_body_and_a_slow_motion_says_which_numbers_it_does_not_show(known):
    plant, rng = loaded(known), np.random.default_rng(9)
    slow = simulated_log(plant, random_motion(ARM, 10.0, rng, rate=1000.0, share=0.1), 0.1, rng, 1e-5)
    found = identify_load([slow], ARM)
    load = possible_load(found)
    assert is_physical(load.body)
    assert not load.was_possible
    assert abs(load.body.mass - MASS) < 0.06
    most = max(found.parameters[0], 3.0 * found.sigma[0]) * np.array([1.0, *[0.1] * 3, *[0.01] * 6])
    assert states(found) == tuple(np.where(3.0 * found.sigma < most, "identified", "not excited"))
    assert (states(found)[0], "not excited" in states(found)[4:]) == ("identified", True)
    truth = np.concatenate([[MASS], COM, TENSOR[np.triu_indices(3)]])
    assert np.abs((load.values - truth) / load.sigma).max() < 5.0
    m, ball = (
        found.parameters[0],
        possible_load(found, weight=1e12).body,
    )  # next to no log: a ball of 2000 kg/m^3
    assert ball.mass == pytest.approx(m, rel=1e-4)
    assert ball.com == pytest.approx(found.parameters[1:4] / m, abs=1e-4)
    round_ = 0.4 * m * (m / (2000.0 * 4.0 / 3.0 * np.pi)) ** (2.0 / 3.0) * np.eye(3)
    assert ball.inertia_com == pytest.approx(round_, rel=1e-3, abs=1e-3 * round_[0, 0])
    least_squares = np.abs(found.parameters[4:] - TRUTH[4:]).max()
    assert np.abs(body_parameters(load.body)[4:] - TRUTH[4:]).max() < 0.5 * least_squares


def test_a_point_mass_without_noise_is_found_at_the_edge_of_what_bodies_are(known):
    full = loaded(known, (1.5, (0.0, 0.02, 0.06)))
    exact = {"noise": 0.0, "encoder": 0.0}
    found = identify_load(logs_of(full, 3, **exact), ARM, RULES[:1], unloaded=logs_of(known, 4, **exact))
    load = possible_load(found)
    assert load.body.mass == pytest.approx(1.5, abs=1e-4)
    assert load.body.com == pytest.approx([0.0, 0.02, 0.06], abs=1e-4)
    assert is_physical(load.body)
    with pytest.raises(OptionError, match=r"weight of the ball: 0\.0; allowed: a number above 0"):
        possible_load(found, weight=0.0)


def test_text_and_record_name_body_errors_and_what_is_wrong(off, none):
    found = off[1]
    shown, load = load_document(found, "lwr4plus"), possible_load(found)
    text, record = shown.text(), shown.record()
    assert faults("identify payload", {"caveats": [], **json.loads(json_text(record))}) == []
    joints = zip(range(1, 8), found.without, found.left, found.noise, found.slow, found.equations, strict=True)
    rows = {
        "load": zip(load.values, NAMES, UNITS, load.sigma, strict=True), "joints": joints,
        "least_squares": zip(found.parameters, found.sigma, states(found), strict=True),
    }  # fmt: skip
    names = {"least_squares": ["value", "standard_error", "state"]}
    for key, wanted in rows.items():
        got = [[row[x] for x in names.get(key, row)] for row in record[key]]
        assert got == [[*row] for row in wanted], key
    facts = {
        "robot": "lwr4plus", "found": True, "weight": load.weight, "price": load.price, "cutoff": found.cutoff,
        "least_squares_is_a_body": load.was_possible, "known": "the arm's inertias",
        "fitted_beside": list(found.nuisance), "motors": "",
    }  # fmt: skip
    assert {key: record[key] for key in facts} == facts
    listed = ", ".join(map(str, found.systematic))
    (warning,) = record["warnings"]
    assert warning.startswith(f"not noise alone: what is left at joints {listed} is more than 1.5 times larger in slow")
    assert warning in " ".join(text.split())
    assert found.systematic == tuple(np.flatnonzero(found.slow > 1.5 * found.noise) + 1)
    doubt = f"IN DOUBT: residuals are not noise alone, its errors are those of an arm {found.share:.0%} off its table"
    assert text.splitlines()[0].endswith(f" kg; {doubt}")
    assert not none.found
    assert abs(none.parameters[0]) < 4 * none.sigma[0]
    assert load_document(none).text().startswith("no load found: torques give ")
    assert load_document(none).record()["load"] == []


def test_parameters_and_body_are_each_others_inverse():
    body = body_of(TRUTH)
    for found, truth in ((body.mass, MASS), (body.com, COM), (body.inertia_com, TENSOR)):
        assert found == pytest.approx(truth)
