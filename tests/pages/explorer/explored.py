"""Arms that the explorer is tried on, and its page in a browser."""

from functools import cache
from pathlib import Path

import pinocchio as pin

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from tests.headless import logs, waiting

FOREIGN = {
    "panda": "panda_description/urdf/panda.urdf",
    "tiago": "tiago_description/robots/tiago.urdf",  # branched, its first joint slides
}
SHARE = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots"
COMMITTED = [(robot, reading) for robot in studied() for reading in lwr_dyn.readings(robot)]
NAMES = [*(f"{robot} {reading}" for robot, reading in COMMITTED), *FOREIGN, "hung"]
"""Every robot and reading of the package, two foreign arms, one on a ceiling with a tool."""


@cache
def explored_arm(name):
    """The arm of a name."""
    if name == "hung":
        tool = {"xyz": [0.0, 0.1, 0.2], "rpy_deg": [10.0, 20.0, 30.0], "mass": 1.5}
        return lwr_dyn.load("lwr4plus", mount="ceiling", tool=tool)
    return lwr_dyn.load(SHARE / FOREIGN[name]) if name in FOREIGN else lwr_dyn.load(*name.split())


def opened(browser, address):
    """Open an arm's page and wait until it is drawn; what was logged before is dropped."""
    browser.get("about:blank")
    logs(browser)
    browser.get(address)
    waiting(browser, 60).until(lambda w: w.execute_script("return !!(window.lwrExplorer && lwrExplorer.ready)"))
    return browser
