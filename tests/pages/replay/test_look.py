"""The tokens: runs are told apart by eyes of four kinds, text has contrast, and no other file names a colour."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.pages.replay.look import RUN_COLOURS, font_faces, look_css, run_colour, tokens

# Machado, Oliveira, Fernandes 2009, table 1, severity 1.0; on linear sRGB
VISIONS = {
    "normal": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
# Ottosson 2020, "A perceptual color space for image processing"; linear sRGB to cone responses, their roots to Lab
CONES = [
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
]
LAB = [
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
]
LEAST_DISTANCE = 10.0
"""OKLab x 100, for lines of 1.4 px."""


def linear(colour):
    values = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def distance(one, other, vision):
    labs = [
        np.array(LAB) @ np.cbrt(np.array(CONES) @ np.clip(np.array(vision) @ linear(c), 0, 1)) for c in (one, other)
    ]
    return 100.0 * np.linalg.norm(labs[1] - labs[0])


def contrast(one, other):
    """Ratio of WCAG 2."""
    dark, light = sorted(linear(c) @ [0.2126, 0.7152, 0.0722] for c in (one, other))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("vision", VISIONS)
def test_runs_are_told_apart_with_every_kind_of_vision(vision, dark):
    """The grey of the fifth run is as far from the four; of two greys the label tells."""
    colours = [run_colour(place, dark) for place in range(5)]
    near = {
        pair: d
        for pair in itertools.combinations(colours, 2)
        if (d := distance(*pair, VISIONS[vision])) < LEAST_DISTANCE
    }
    assert near == {}


def test_distance_sees_the_palette_that_was_false():
    """Orange and green that a protanope takes for one another, as they stood here once: 4.3."""
    assert distance("#e8590c", "#2b8a3e", VISIONS["protan"]) == pytest.approx(4.3, abs=0.05)


@pytest.mark.parametrize("dark", [False, True])
def test_text_and_marks_have_contrast(dark):
    look = tokens(dark)
    for name in ("ink", "soft", "link", "alarm", "focus", "run1", "run2", "run3", "run4"):
        assert min(contrast(look[name], look[back]) for back in ("page", "card")) >= 4.5, name
    assert contrast(look["run5"], look["card"]) >= 3.0  # lines only; its label is ink
    for axis in ("axis-x", "axis-y", "axis-z"):
        assert contrast(look[axis], look["page"]) >= 3.0


def test_tokens_are_those_of_the_style_sheet():
    light, dark = tokens(), tokens(dark=True)
    assert light.keys() == dark.keys() == set(re.findall(r"--([\w-]+):", look_css().partition(":root")[2]))
    assert (light["t2"], dark["t2"]) == ("15px", "15px")
    assert len({light["card"], dark["card"]}) == 2
    assert tuple(light[f"run{k}"] for k in (1, 2, 3, 4)) == RUN_COLOURS
    assert run_colour(0, dark=True) == dark["run1"]
    colours = [value for look in (light, dark) for value in look.values() if value.startswith("#")]
    assert len(colours) == 2 * 26
    assert all(re.fullmatch(r"#[0-9a-f]{6}", colour) for colour in colours)


def test_fonts_are_inside_the_style():
    css = font_faces()
    assert css.count("@font-face") == 3
    assert "http" not in css
    assert 60_000 < len(css) < 90_000


COLOUR = re.compile(r"""(?<=[\s:("',])#(?:[0-9a-fA-F]{3,4}){1,2}(?=[\s;,)"'])|\brgba?\(\s*(?!0 0 0)\d""")


def test_no_other_file_of_pages_and_pictures_names_a_colour():
    """But for the black of shadows."""
    package = Path(lwr_dyn.__file__).parent
    kinds = (".py", ".css", ".js", ".html", ".svg")
    named = {
        path.relative_to(package).as_posix(): COLOUR.findall(path.read_text(encoding="utf-8"))
        for path in sorted(package.rglob("*"))
        if path.suffix in kinds
    }
    assert {name for name, colours in named.items() if colours} <= {"pages/replay/look.css", "pages/replay/look.py"}
    assert len(named["pages/replay/look.css"]) == 2 * 26
    assert COLOUR.search("a { color: rgb(1, 2, 3) }")
    assert not COLOUR.search("  #add(what) {")
