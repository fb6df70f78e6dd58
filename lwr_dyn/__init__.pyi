"""Types of the names of `import lwr_dyn`."""

from lwr_dyn.arms.loading import load as load
from lwr_dyn.arms.papers.catalog import readings as readings
from lwr_dyn.arms.papers.catalog import robots as robots
from lwr_dyn.arms.urdf.writer import urdf_text as urdf_text
from lwr_dyn.codegen.kernels.batch import batch_dynamics as batch_dynamics
from lwr_dyn.codegen.rollouts.rollouts import rollouts as rollouts
from lwr_dyn.control.controllers import controller as controller
from lwr_dyn.design.margins import margins as margins
from lwr_dyn.dynamics.engines import dynamics_of as dynamics_of
from lwr_dyn.dynamics.engines import engines as engines
from lwr_dyn.identification.ranking.rank import rank as rank
from lwr_dyn.kinematics.forward import forward_kinematics as forward_kinematics
from lwr_dyn.kinematics.inverse import inverse_kinematics as inverse_kinematics
from lwr_dyn.kinematics.pose_solver import ik_solver as ik_solver
from lwr_dyn.model.run import Motion as Motion
from lwr_dyn.model.run import Run as Run
from lwr_dyn.pages.explorer.shown import show as show
from lwr_dyn.pages.plotting.plots import plot as plot
from lwr_dyn.pages.replay.replay_page import replay as replay
from lwr_dyn.simulation.simulate import simulate as simulate
from lwr_dyn.studies.compare.comparison import compare as compare
from lwr_dyn.trajectory.references.references import reference as reference

__version__: str
__all__ = [
    "Motion",
    "Run",
    "batch_dynamics",
    "compare",
    "controller",
    "dynamics_of",
    "engines",
    "forward_kinematics",
    "ik_solver",
    "inverse_kinematics",
    "load",
    "margins",
    "plot",
    "rank",
    "readings",
    "reference",
    "replay",
    "robots",
    "rollouts",
    "show",
    "simulate",
    "urdf_text",
]
