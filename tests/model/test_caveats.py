"""What stands before an arm's numbers, in words and back, and what an arm keeps of it."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.model.arm import arm_with_payload, caveats_of
from lwr_dyn.model.caveats import ALL, DYNAMICS, GUESSED, KINEMATICS, Caveats, StandIn, caveats_of_words
from lwr_dyn.model.chain import with_bodies

IDS = st.lists(st.sampled_from(("table2-rows", "kuka-signs", "a", "b-c")), unique=True, max_size=4).map(tuple)
ESTIMATES = st.lists(
    st.builds(StandIn, st.sampled_from(ALL), st.sampled_from(GUESSED), st.sampled_from(("", "from drawn solids"))),
    unique_by=lambda one: one.what,
    max_size=6,
).map(tuple)


@given(IDS, ESTIMATES, st.sampled_from(("", "m_7 is 5.2 sigma off, chi^2 92")))
def test_words_are_read_back(left, estimates, contradicted):
    said = Caveats(left, estimates, contradicted=contradicted)
    read = caveats_of_words(said.words())
    assert (read.left_in_place, set(read.estimates)) == (left, set(estimates))
    assert read.contradicted == contradicted
    assert read.words() == said.words()


def test_nothing_is_said_of_a_clean_arm_of_foreign_words_or_of_numbers_that_are_not_used():
    assert Caveats().words() == "" == Caveats(likely=("a",)).words()
    assert caveats_of_words("made by hand; wings estimated") == Caveats()
    assert Caveats(("a", "b", "c")).words() == "leaves a, b and c in place, proven errors"
    assert Caveats(likely=("b",)).errata_words(()) == "none"
    springs = Caveats(estimates=(StandIn("gear stiffness", "assumed"), StandIn("speed limits", "assumed")))
    assert springs.words(DYNAMICS) == "speed limits assumed" == springs.words(KINEMATICS)
    assert springs.words() == "gear stiffness and speed limits assumed"


def test_an_arm_keeps_them_whatever_is_done_with_it():
    arm = lwr_dyn.load("kr30ha", mount="ceiling", tool={"xyz": [0, 0, 0.1], "mass": 1.0})
    changed = arm_with_payload(arm.with_locked_joint("A4", 0.0), 3.0)
    assert changed.caveats == lwr_dyn.load("kr30ha").caveats
    assert caveats_of([arm, changed]) == (
        "kr30ha (kuka): masses, centres of mass and inertias estimated from drawn solids",
    )


def test_a_reading_that_keeps_a_proven_error_says_so_and_an_inertia_that_no_body_can_have_is_said():
    computed, arm = lwr_dyn.load("lwr4plus", "computed"), lwr_dyn.load("lwr4plus")
    error = "leaves rotor-inertia-power in place, a proven error"
    assert repr(computed) == f"Arm('lwr4plus', reading='computed', n=7, {error})"
    assert ["leaves rotor-inertia-power in place" in x._repr_html_() for x in (computed, arm)] == [True, False]
    assert repr(arm) == "Arm('lwr4plus', reading='physical', n=7)"
    assert "estimated from drawn solids" in lwr_dyn.load("kr30ha")._repr_html_()
    bodies = list(arm.chain.bodies)
    bodies[2] = replace(bodies[2], inertia_com=np.diag([0.01, 0.01, 0.1]))
    bad = arm.with_chain(with_bodies(arm.chain, bodies))
    assert bad.caveat(DYNAMICS) == "lwr4plus (physical): no body can have the inertia of link_3"
    assert arm.caveat(DYNAMICS) == bad.caveat(KINEMATICS) == ""
