"""Controllers on ist-clear, on the arm of their model and on two other arms: the table of `lwr-dyn compare`.

The errors are those of an arm with rigid links and joints. With --task ist, the paper's path as it is printed, joint 6
starts 1.2 degrees from its limit: with the payload it comes to rest on its stop, and the table says so.
"""

from __future__ import annotations

import argparse

import lwr_dyn
from lwr_dyn.studies.compare.plants import plant_case
from lwr_dyn.studies.compare.study import ControllerStudy

CONTROLLERS = ("pd-gravity", "pid", "inverse-dynamics")


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="ist-clear", choices=["ist-clear", "ist"])
    parser.add_argument("--timing", default="smooth", help="constant, quintic, smooth or smooth-blended")
    parser.add_argument("--plants", default="nominal,scale=1.1,payload=3", help="unknown to the controllers")
    parser.add_argument("--no-stops", action="store_true", help="let joints pass their position limits")
    parser.add_argument("--html", help="page to write")
    options = parser.parse_args(arguments)

    arm = lwr_dyn.load("lwr4plus", "computed")  # as the authors of the paper computed it
    reference = lwr_dyn.reference(options.task, arm, timing=options.timing)
    plants = [plant_case(arm, text) for text in options.plants.split(",")]
    fixed = (("position_limits", not options.no_stops),)
    compared, _ = ControllerStudy(arm, reference, CONTROLLERS, plants, options.task, fixed).run()
    print(compared.table.text())
    if options.html:
        compared.save(options.html)


if __name__ == "__main__":
    main()
