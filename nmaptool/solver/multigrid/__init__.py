"""Multigrid without a matrix on the finest level, for any mask and any weights."""

from nmaptool.solver.multigrid.method import MultigridMethod

__all__ = ["MultigridMethod"]
