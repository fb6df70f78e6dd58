"""What a paper prints, as text with its digits, from the data files of its folder."""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Any


def printed_tables(paper: str, file: str = "results") -> dict[str, Any]:
    """What a paper prints, from a data file in its room: blocks with their cells and what is given beside them."""
    text = resources.files(f"lwr_dyn.reproduction.{paper}").joinpath(f"{file}.toml").read_text(encoding="utf-8")
    raw = tomllib.loads(text)
    return {name: _merged(block) if isinstance(block, dict) else block for name, block in raw.items()}


def _merged(block: dict[str, Any]) -> dict[str, Any]:
    merged: dict[str, Any] = block | block.get("given", {}) | block.get("cells", {})
    return merged
