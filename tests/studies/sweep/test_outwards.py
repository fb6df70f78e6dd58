"""Which parameter breaks a limit first, on metrics whose break is known."""

import numpy as np
import pytest

from lwr_dyn.studies.sweep.outwards import STEPS, Span, outward_search
from lwr_dyn.studies.sweep.vocabulary import metric_words

TIP, MARGIN = metric_words("tip_max"), metric_words("limit_margin")
SPANS = [Span("payload.mass", 0.0, 0.0, 7.0), Span("arm.mass", 1.0, 0.8, 1.2), Span("arm.com", 0.0, -0.01, 0.01, 21),
         Span("reading", "computed"), Span("loop.delay", 0.0, 1.0, 4.0, values=(1.0, 2.0, 3.0, 4.0))]  # fmt: skip


def evaluate(values):
    """A tip error that breaks 1 mm at 3 kg of payload, at a mass of 0.9, and never by the centres."""
    assert (values["reading"] == "computed").all()
    assert values["arm.com"].shape == (*values["payload.mass"].shape, 21)
    tip = 1e-3 * (values["payload.mass"] / 3.0 + 10.0 * np.maximum(0.0, 1.0 - values["arm.mass"]))
    return {"tip_max": tip + 1e-9, "limit_margin": np.column_stack([1.0 - 0.3 * values["loop.delay"], tip])}


def test_the_first_break_is_found_to_a_256th_of_the_way():
    found = outward_search(SPANS, {TIP: 1e-3}, evaluate)
    shares = {(line.path, line.end): line.share for line in found.lines}
    assert shares["payload.mass", 7.0] == pytest.approx(3.0 / 7.0, abs=1 / 256)
    assert shares["arm.mass", 0.8] == pytest.approx(0.5, abs=1 / 256)
    assert [line.path for line in found.lines[:2]] == ["payload.mass", "arm.mass"]
    first = found.lines[0]
    assert first.kept < 3.0 <= first.broken
    assert first.broken - first.kept == pytest.approx(7.0 / 256)
    assert first.metric == "tip_max"
    assert {line.share for line in found.lines[2:]} == {None}
    assert found.runs == 1 + STEPS * (6 + 2)


def test_a_margin_breaks_downwards_and_at_its_worst_joint():
    found = outward_search(SPANS, {MARGIN: 0.0}, evaluate)
    (broken,) = [line for line in found.lines if line.share is not None]
    assert (broken.path, broken.metric) == ("loop.delay", "limit_margin")
    assert (broken.kept, broken.broken, broken.share) == (3.0, 4.0, 1.0)  # a delay is a whole number of samples


def test_what_is_broken_at_the_nominal_values_is_said_and_nothing_searched():
    found = outward_search(SPANS, {TIP: 1e-10, MARGIN: -1.0}, evaluate)
    assert found.at_nominal == ("tip_max",)
    assert found.lines == ()


def test_a_run_without_a_number_breaks_its_limit():
    found = outward_search(
        SPANS[:1], {TIP: 1.0}, lambda values: {"tip_max": np.where(values["payload.mass"] > 2.0, np.nan, 0.0)}
    )
    assert found.lines[0].broken == pytest.approx(2.0, abs=7.1 / 256)


def test_a_limit_that_breaks_in_the_last_step_only():
    found = outward_search(SPANS[:1], {TIP: 1.0}, lambda values: {"tip_max": 2.0 * (values["payload.mass"] >= 7)})
    assert found.lines[0].share == 1.0


def test_a_limit_that_breaks_by_the_noise_of_one_run_only():
    """The second pass has other runs, with other noise of the encoders."""
    passes = iter([0.0, 1.0])

    def noisy(values):
        return {"tip_max": 2.0 * (values["payload.mass"] >= 7.0 + next(passes))}

    line = outward_search(SPANS[:1], {TIP: 1.0}, noisy).lines[0]
    assert (line.share, line.metric) == (1.0, "tip_max")


@pytest.mark.parametrize(
    ("span", "ends"),
    [
        (Span("a", 0.0, -1.0, 2.0), (-1.0, 2.0)),
        (Span("a", 0.0, 0.0, 7.0), (7.0,)),
        (Span("a", 0.0, 1.0, 4.0), (4.0,)),
        (Span("a", 5.0, 1.0, 4.0), (1.0,)),
        (Span("a", 1.0, 1.0, 1.0), ()),
        (Span("a", "computed"), ()),
    ],
)
def test_the_ends_of_a_span(span, ends):
    assert span.ends == ends


@pytest.mark.parametrize(
    ("span", "end", "at", "before"),
    [
        (Span("a", 1.0, 0.0, 5.0), 5.0, [1.0, 2.0, 4.0], (4.0, 3.0)),
        (Span("a", 1.0, -3.0, 5.0), -3.0, [1.0, 0.0, -2.0], (-2.0, -1.0)),
        (Span("a", 1.0, 0.0, 4.0, values=(0.0, 2.0, 4.0)), 4.0, [1.0, 2.0, 4.0], (4.0, 2.0)),
        (Span("a", 3.0, 0.0, 4.0, values=(0.0, 2.0, 4.0)), 0.0, [3.0, 2.0, 0.0], (2.0, 3.0)),
    ],
)  # fmt: skip
def test_values_on_the_way_and_the_one_before(span, end, at, before):
    """At 0, 1/4 and 3/4 of the way, the nearest that is known; before a value, the one known, or a quarter less."""
    assert span.at(np.array([0.0, 0.25, 0.75]), end).tolist() == at
    assert span.before(before[0], end, 0.25) == before[1]
