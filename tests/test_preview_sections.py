"""Sections through reliefs: their profile, and the plot with axes in mm."""

import math

import numpy as np
import pytest
from preview_cases import PITCH, cone, disc

import nmaptool as nm
from nmaptool.core.errors import UsageError
from nmaptool.core.units import offset
from nmaptool.figures.section import exaggeration, section_figure
from nmaptool.shading.section import section


@pytest.mark.parametrize(("text", "row_mm"), [("y=50%", 10.0), ("y=10mm", 10.0), ("y=40px", 10.0), ("y=1cm", 10.0)])
def test_a_section_through_the_tip_of_a_cone_has_its_slope(text, row_mm):
    cut = section(cone(), "y", offset(text[2:]))
    assert cut.at_mm == pytest.approx(row_mm)
    assert cut.along_mm[[0, -1]].tolist() == [0, 30]
    side = (cut.along_mm > 6) & (cut.along_mm < 14.9)
    slopes = np.polyfit(cut.along_mm[side], cut.z_mm[side], 1)
    assert slopes[0] == pytest.approx(0.5, abs=1e-9)
    assert np.nanmax(cut.z_mm) == 5


def test_a_section_from_bottom_to_top_and_beside_the_tip():
    cut = section(cone(), "x", offset("18mm"))
    expected = np.maximum(5 - 0.5 * np.hypot(3, cut.along_mm - 10), 0)
    np.testing.assert_allclose(cut.z_mm, expected, atol=1e-12)
    assert cut.along_mm[-1] == 20


def test_a_plotted_section_shows_the_slope(monkeypatch):
    """What the axes draw, in pixels: its slope is that of the cone times the exaggeration."""
    from matplotlib.axes import Axes

    drawn = {}
    plot = Axes.plot

    def kept(self, *args, **words):
        drawn["axes"], drawn["line"] = self, plot(self, *args, **words)[0]
        return [drawn["line"]]

    monkeypatch.setattr(Axes, "plot", kept)
    wide = nm.Height(cone().z_mm / 4, np.ones((80, 120), bool), nm.Frame(80, 120, PITCH))
    for height, slope, factor in ((cone(), 0.5, 1), (wide, 0.125, 2)):
        cut = section(height, "y", offset("50%"))
        section_figure(cut, -0.5)
        points = drawn["axes"].transData.transform(drawn["line"].get_xydata())
        inside = (cut.along_mm > 6) & (cut.along_mm < 14.9)
        assert np.polyfit(*points[inside].T, 1)[0] == pytest.approx(slope * factor, rel=1e-3)
        title = drawn["axes"].get_title()
        assert title.startswith("Section at y = 10 mm, heights ")
        assert title.endswith("to scale" if factor == 1 else f"{factor} times exaggerated")
        assert drawn["axes"].get_xlabel() == "x, mm"


def test_a_section_has_gaps_outside_the_surface_and_steps_at_walls():
    cut = section(disc(), "y", offset("50%"))
    hidden = np.isnan(cut.z_mm)
    assert hidden[:6].all()
    assert not hidden[40:100].any()
    raised = np.zeros((8, 8), bool)
    raised[2:6, 2:6] = True
    z = np.zeros((9, 9))
    z[2:7, 2:7] = 3
    walls = nm.Height(z, np.ones((8, 8), bool), nm.Frame(8, 8, 1.0), raised=raised)
    cut = section(walls, "y", offset("50%"))
    at_wall = cut.z_mm[cut.along_mm == 2]
    assert at_wall.tolist() == [0, 3]


def test_a_section_ends_at_the_exact_outline():
    from nmaptool.types.contours import Contours

    turn = np.linspace(0, math.tau, 2000, endpoint=False)
    ring = np.stack([10 + 8 * np.cos(turn), 10 + 8 * np.sin(turn)], axis=1)
    hole = np.stack([10 + 2 * np.cos(-turn), 10 + 2 * np.sin(-turn)], axis=1)
    plate = nm.Height(np.ones((81, 81)), disc().domain, nm.Frame(80, 80, PITCH), outline=Contours((ring, hole)))
    cut = section(plate, "y", offset("50%"))
    known = cut.along_mm[np.isfinite(cut.z_mm)]
    assert known.min() == pytest.approx(2, abs=1e-3)
    assert known.max() == pytest.approx(18, abs=1e-3)
    assert not ((known > 8.01) & (known < 11.99)).any()


def test_sections_outside_the_relief_are_refused():
    with pytest.raises(
        UsageError, match=r"`section='y=25mm'`: lies at 25 mm; the relief reaches from 0 to 20 mm along y"
    ):
        nm.preview(cone(), nm.PreviewOptions(section="y=25mm"))


def test_sections_that_meet_no_surface_are_refused():
    with pytest.raises(UsageError, match=r"`section='x=0\.2mm'`: meets no surface at 0\.2 mm"):
        nm.preview(disc(), nm.PreviewOptions(section="x=0.2mm"))


def test_the_plot_has_the_size_that_was_asked_for():
    steep = nm.Height(20 * cone().z_mm, np.ones((80, 120), bool), nm.Frame(80, 120, PITCH))
    for height in (cone(), steep):
        picture = nm.preview(height, nm.PreviewOptions(section="y=50%", size=400))
        assert max(picture.shape) == picture.shape[1] == 400
        assert picture[2, 2].tolist() == [255, 255, 255]
        assert picture.min() < 90


def test_nice_factors():
    assert [exaggeration(100, high) for high in (20, 5, 2, 1, 0.05, 0)] == [1, 2, 5, 10, 100, 100]
