"""Least-squares heights on a quad grid: one definition of the operator (`system`), several methods to solve it.

Setup and solve are separate: `prepare` returns a solver for any number of right-hand sides.
"""

from nmaptool.solver.prepare import DirectMethod, Solution, Solver, choose, prepare
from nmaptool.solver.system import QuadSystem, energy, slope_load

__all__ = ["DirectMethod", "QuadSystem", "Solution", "Solver", "choose", "energy", "prepare", "slope_load"]
