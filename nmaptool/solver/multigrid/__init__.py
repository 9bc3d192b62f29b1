"""Multigrid without a matrix on the finest level, for any mask and any weights."""

from nmaptool.solver.multigrid.hierarchy import Hierarchy

__all__ = ["Hierarchy"]
