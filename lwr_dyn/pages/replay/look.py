"""The look of pages and pictures: the tokens of `look.css` (colours light and dark, type, spacing) and the fonts."""

import base64
import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

_FOLDER = files("lwr_dyn.pages.replay")

_TOKEN = re.compile(r"--([\w-]+): (?:light-dark\((.+), (.+)\)|(.+));")

_FACES = (("Plex Sans", 400, "plex-sans-400"), ("Plex Sans", 600, "plex-sans-600"), ("Plex Mono", 400, "plex-mono-400"))

_LICENCE = "/* IBM Plex, Copyright IBM Corp., SIL Open Font License 1.1 */"


def look_css() -> str:
    """The tokens as CSS custom properties, to stand first in a page's style."""
    return _FOLDER.joinpath("look.css").read_text(encoding="utf-8")


@cache
def tokens(dark: bool = False) -> Mapping[str, str]:
    """The tokens by name: colours of the light or the dark scheme, lengths [px], lists of fonts.

    >>> tokens()["ink"], tokens(dark=True)["ink"], tokens()["s4"]
    ('#14191f', '#e8ecf0', '16px')
    """
    found = _TOKEN.findall(look_css())
    return {name: same or (night if dark else day) for name, day, night, same in found}


RUN_COLOURS = tuple(tokens()[f"run{place}"] for place in range(1, 5))
"""The colours of the first four runs of a picture in the light scheme; from the fifth on `tokens()["run5"]`, a grey."""


def run_colour(place: int, dark: bool = False) -> str:
    """The colour of the run at a place (0-based) of `run_places`: four hues, then grey, which needs a label beside it.

    >>> run_colour(0) == RUN_COLOURS[0], run_colour(4) == run_colour(17) == tokens()["run5"]
    (True, True)
    """
    return tokens(dark)[f"run{min(place, 4) + 1}"]


@cache
def font_faces() -> str:
    """IBM Plex Sans (400, 600) and Mono (400), latin, as `@font-face` rules with the fonts inside (82 kB)."""
    source = 'src:url(data:font/woff2;base64,{}) format("woff2")'
    rule = f'@font-face{{{{font-family:"{{}}";font-weight:{{}};font-display:swap;{source}}}}}'
    read = _FOLDER.joinpath
    data = {file: base64.b64encode(read(f"fonts/{file}.woff2").read_bytes()).decode() for *_, file in _FACES}
    rules = (rule.format(family, weight, data[file]) for family, weight, file in _FACES)
    return "\n".join((_LICENCE, *rules))
