"""What the one-file page holds: runs, samples, labels, and how it refuses bad input."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.pages.replay import replay_page
from tests.pages.replay.replayed import lagging_run

LARGEST_PAGE = 6_000_000
"""Bytes of the HTML at most."""
PACKING = 2.4e-10
"""Half a step of 2^31 - 1 steps, relative to the largest number."""


def embedded(text):
    return json.loads(re.search(r'id="replay-data">(.*?)</script>', text, re.S).group(1))


def unpacked(packed):
    return (np.frombuffer(base64.b64decode(packed["data"]), "<i4") * packed["step"]).reshape(packed["shape"])


def test_page_is_deterministic_and_small(arm, two_runs, tmp_path):
    text = replay_page.replay_html(two_runs, arm)
    replay_page.write_replay(tmp_path / "replay.html", two_runs, arm)
    assert text == (tmp_path / "replay.html").read_text(encoding="utf-8")
    assert len(text.encode()) < LARGEST_PAGE


@pytest.mark.slow
def test_long_runs_are_thinned_with_a_note(arm, monkeypatch):
    monkeypatch.setattr(replay_page, "SERIES_BUDGET", 300_000)
    run = lagging_run(arm, 0.02, "pd-gravity", k=70001)
    record = embedded(replay_page.replay_html([run], arm))["runs"][0]
    kept, of = record["samples"]
    assert kept < 601 < of == 70001
    assert unpacked(record["t"])[[0, -1]].tolist() == pytest.approx([0.0, 6.0])
    assert len(json.dumps(record["q"])) + len(json.dumps(record["q_ref"])) < 300_000


def test_a_page_has_a_hundred_samples_a_second_or_as_many_as_asked_for(arm, two_runs):
    assert embedded(replay_page.replay_html(two_runs, arm))["runs"][1]["samples"] == [601, 3001]
    assert embedded(replay_page.replay_html(two_runs, arm, rate=1e4))["runs"][1]["samples"] == [3001, 3001]
    with pytest.raises(OptionError, match="rate: 0"):
        replay_page.replay_html(two_runs, arm, rate=0)


@pytest.mark.slow
def test_four_runs_of_fourteen_seconds_stay_small(arm):
    runs = [lagging_run(arm, 0.01 * i, f"controller {i}", k=14001, duration=14.0) for i in range(1, 7)]
    assert len(replay_page.replay_html(runs, arm).encode()) < LARGEST_PAGE


@given(arrays(np.float64, (5, 3), elements=st.floats(-1e6, 1e6)))
def test_packing_keeps_nine_digits(values):
    back = unpacked(replay_page.pack_int32(values))
    assert np.abs(back - values).max() <= replay_page.SMALLEST + PACKING * np.abs(values).max()


def test_labels_cannot_break_out_of_the_page(arm, two_runs):
    wicked = "</script><script>alert(1)</script>"
    text = replay_page.replay_html(two_runs[:1], arm, labels=[wicked], title=wicked)
    assert wicked not in text
    assert embedded(text)["runs"][0]["label"] == wicked


def test_the_tasks_own_path_is_drawn_when_the_run_carries_it(arm, two_runs):
    run = replace(two_runs[0], meta={**two_runs[0].meta, "reference_trace": [[0, 0, 0], [0, 0, 1]]})
    record = embedded(replay_page.replay_html([run], arm))["runs"][0]
    assert unpacked(record["reference"]).tolist() == [[0, 0, 0], [0, 0, 1]]


def test_bad_input_is_refused(arm, two_runs, tmp_path):
    with pytest.raises(OptionError, match="layout: 'stacked'"):
        replay_page.replay_html(two_runs, arm, layout="stacked")
    with pytest.raises(FileAccessError):
        replay_page.write_replay(tmp_path / "none" / "x.html", two_runs, arm)
