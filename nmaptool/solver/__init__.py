"""Least-squares heights on a quad grid: one statement of the operator (`system`), several ways to solve it.

Setup and solve are apart: `prepare` returns a solver that serves any number of right-hand sides.
"""

from nmaptool.solver.prepare import DirectMethod, Solution, Solver, choose, prepare
from nmaptool.solver.system import QuadSystem, energy, slope_load

__all__ = ["DirectMethod", "QuadSystem", "Solution", "Solver", "choose", "energy", "prepare", "slope_load"]
