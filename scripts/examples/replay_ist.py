"""Two controllers draw IST; one page replays both, without a network: python scripts/examples/replay_ist.py."""

from __future__ import annotations

import argparse
from pathlib import Path

import lwr_dyn
from lwr_dyn.foundation.files import make_folder


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--controllers", nargs="+", default=["pd-gravity", "inverse-dynamics"])
    parser.add_argument("--reading", help="of the plant and of the controllers' model")
    parser.add_argument("--out", type=Path, default=Path("out/ist.html"))
    options = parser.parse_args(arguments)

    arm = lwr_dyn.load("lwr4plus", options.reading)
    reference = lwr_dyn.reference("ist", arm)
    runs = [lwr_dyn.simulate(arm, lwr_dyn.controller(name, arm), reference) for name in options.controllers]
    make_folder(options.out.parent)
    lwr_dyn.replay(runs, options.out, title="KUKA LWR 4+ draws IST")
    print(f"wrote {options.out}: open it in a browser, no network needed")


if __name__ == "__main__":
    main()
