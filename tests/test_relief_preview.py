"""`ReliefSession.solve` with a preview tolerance: coarser heights while a slider moves, exact ones afterwards."""

from __future__ import annotations

import numpy as np
import pytest
from relief_cases import dome

import nmaptool as nm
from nmaptool.core.errors import UsageError

SIDE = 96
OPTIONS = nm.ReliefOptions(background="cut", beta=0.002, delta=12.0)


@pytest.fixture(scope="module")
def maps():
    original, _, detail = dome(SIDE, bumps=1)
    return original, detail


def test_a_preview_is_coarser_and_a_later_solve_continues_from_it(maps):
    session, exact = nm.ReliefSession(*maps), nm.relief(*maps, options=OPTIONS)
    preview = session.solve(OPTIONS, preview_tolerance=1e-5)
    assert OPTIONS.tolerance < preview.report.residual <= 1e-5
    assert 0 < preview.report.iterations < exact.report.iterations
    assert np.abs(preview.z_mm - exact.z_mm).max() <= 1e-4 * np.ptp(exact.z_mm)
    assert session.solve(OPTIONS, preview_tolerance=1e-5).report.iterations == 0
    final = session.solve(OPTIONS)
    assert 0 < final.report.iterations < exact.report.iterations
    assert np.abs(final.z_mm - exact.z_mm).max() <= 1e-6 * np.ptp(exact.z_mm)
    # the exact heights are known now
    assert session.solve(OPTIONS, preview_tolerance=1e-5).report.residual <= OPTIONS.tolerance


def test_a_preview_tolerance_below_that_of_the_options_changes_nothing(maps):
    exact = nm.relief(*maps, options=OPTIONS)
    found = nm.ReliefSession(*maps).solve(OPTIONS, preview_tolerance=1e-12)
    assert np.array_equal(found.z_mm, exact.z_mm)


@pytest.mark.parametrize("bad", [0.0, 1.0, -1e-5, np.nan])
def test_a_bad_preview_tolerance_is_refused(maps, bad):
    with pytest.raises(UsageError, match=r"`preview_tolerance=.*`: must be between 0 and 1, both excluded"):
        nm.ReliefSession(*maps).solve(OPTIONS, preview_tolerance=bad)
