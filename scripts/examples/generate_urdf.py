"""Write a robot as URDF with its sidecars: python scripts/examples/generate_urdf.py lwr4plus --reading physical."""

from __future__ import annotations

import argparse

import lwr_dyn
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.foundation.files import write_folder


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot", nargs="?", default="lwr4plus", help="a name, a .toml or a .urdf file")
    parser.add_argument("--reading")
    parser.add_argument("--out", default="out/models")
    options = parser.parse_args(arguments)
    arm = lwr_dyn.load(options.robot, options.reading)
    files = model_files(arm)
    write_folder(options.out, files)
    print(f"{arm.title}, reading {arm.reading}: {', '.join(files)} in {options.out}")


if __name__ == "__main__":
    main()
