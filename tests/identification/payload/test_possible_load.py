"""The body that a load can be, and what is said of it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.identification.payload.identify_load import RULES, body_of, identify_load
from lwr_dyn.identification.payload.possible_load import load_document, possible_load, states
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.chain import is_physical, with_payload
from tests.identification.payload.loaded import ARM, COM, MASS, TENSOR, TRUTH, loaded, logs_of
from tests.identification.plants import Plant, perturbed_plant, random_motion, simulated_log
from tests.json_schemas import faults


def test_the_load_is_a_body_and_a_slow_motion_says_which_numbers_it_does_not_show(known):
    plant, rng = loaded(known), np.random.default_rng(9)
    slow = simulated_log(plant, random_motion(ARM, 10.0, rng, rate=1000.0, share=0.1), 0.1, rng, 1e-5)
    found = identify_load([slow], ARM)
    load = possible_load(found)
    assert is_physical(load.body)
    assert not load.was_possible
    assert abs(load.body.mass - MASS) < 0.06
    assert states(found)[0] == "identified"
    assert "not excited" in states(found)[4:]
    truth = np.concatenate([[MASS], COM, TENSOR[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]])
    assert np.abs((load.values - truth) / load.sigma).max() < 5.0
    least_squares = np.abs(found.parameters[4:] - TRUTH[4:]).max()
    assert np.abs(body_parameters(load.body)[4:] - TRUTH[4:]).max() < 0.5 * least_squares


def test_a_point_mass_without_noise_is_found_at_the_edge_of_what_bodies_are(known):
    full = Plant(known.columns, known.parameters.copy())
    chain = with_payload(ARM.chain, 1.5, (0.0, 0.02, 0.06))
    full.parameters[60:70] += body_parameters(chain.links[-1].body) - body_parameters(ARM.chain.links[-1].body)
    exact = {"noise": 0.0, "encoder": 0.0}
    load = possible_load(identify_load(logs_of(full, 3, **exact), ARM, RULES[:1], unloaded=logs_of(known, 4, **exact)))
    assert load.body.mass == pytest.approx(1.5, abs=1e-4)
    assert load.body.com == pytest.approx([0.0, 0.02, 0.06], abs=1e-4)
    assert is_physical(load.body)
    with pytest.raises(OptionError, match="weight"):
        possible_load(identify_load(logs_of(full, 3), ARM), weight=0.0)


def test_text_and_record_name_body_errors_and_what_is_wrong(known):
    plant = perturbed_plant(TorqueColumns(ARM.chain), ARM, np.random.default_rng(3), 0.1)
    found = identify_load(logs_of(loaded(plant), 4), ARM)
    shown = load_document(found, "lwr4plus")
    text, record = shown.text(), shown.record()
    assert "not noise alone" in text
    assert len(record["warnings"]) == 1
    assert [row["unit"] for row in record["load"]][:2] == ["kg", "m"]
    load = possible_load(found)
    assert faults("identify payload", {"caveats": [], **json.loads(json_text(record))}) == []
    facts = {"robot": "lwr4plus", "found": True, "weight": load.weight, "price": load.price, "cutoff": found.cutoff,
             "least_squares_is_a_body": load.was_possible, "known": found.known}  # fmt: skip
    assert {key: record[key] for key in facts} == facts
    assert record["fitted_beside"] == list(found.nuisance)
    names = ["mass", "com_x", "com_y", "com_z", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"]
    units = ["kg"] + ["m"] * 3 + ["kg m^2"] * 6
    assert [list(row.values()) for row in record["load"]] == [
        [*row] for row in zip(load.values, names, units, load.sigma, strict=True)
    ]
    joints = zip(range(1, 8), found.without, found.left, found.noise, found.slow, found.equations, strict=True)
    assert [list(row.values()) for row in record["joints"]] == [[*row] for row in joints]
    assert [[row["value"], row["standard_error"], row["state"]] for row in record["least_squares"]] == [
        [*row] for row in zip(found.parameters, found.sigma, states(found), strict=True)
    ]
    doubt = f"IN DOUBT: residuals are not noise alone, its errors are those of an arm {found.share:.0%} off its table"
    assert text.splitlines()[0].endswith(f" kg; {doubt}")
    assert record["joints"][1]["in_slow_sums"] > 1.5 * record["joints"][1]["noise"]
    none = load_document(identify_load(logs_of(known, 8), ARM))
    assert none.text().startswith("no load found")
    assert none.record()["load"] == []


def test_parameters_and_body_are_each_others_inverse():
    body = body_of(TRUTH)
    assert body.mass == pytest.approx(MASS)
    assert body.com == pytest.approx(COM)
    assert body.inertia_com == pytest.approx(TENSOR)
