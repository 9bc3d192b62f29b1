"""Widths of strokes and counters."""

from __future__ import annotations

import math

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.lettering.place import around, straight
from nmaptool.lettering.shaping import lay_out
from nmaptool.lettering.strokes import narrowest_counter_mm, thinnest_stroke_mm


def ring_of(radius, sides=720):
    turn = np.arange(sides) * (2 * np.pi / sides)
    return radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def test_widths_of_known_shapes():
    annulus = nm.Contours((ring_of(5.0), ring_of(4.6)[::-1]))
    assert thinnest_stroke_mm(annulus) == pytest.approx(0.4, rel=1e-3)
    assert narrowest_counter_mm(annulus) == pytest.approx(9.2, rel=1e-3)
    thick = np.array([[20.0, 0.0], [29.0, 0.0], [29.0, 1.0], [20.0, 1.0]])
    both = nm.Contours.joined([annulus, nm.Contours((thick,))])
    assert thinnest_stroke_mm(both) == pytest.approx(0.4, rel=1e-3)
    assert thinnest_stroke_mm(nm.Contours((thick,))) == pytest.approx(1.0)
    assert narrowest_counter_mm(nm.Contours((thick,))) == math.inf
    assert thinnest_stroke_mm(nm.Contours(())) == math.inf


def test_strokes_scale_with_the_letters_and_do_not_change_on_a_circle():
    font = nm.read_font("DejaVu Sans")
    line = lay_out(font, "LITHE", 2.0)
    # stems of 201 units, bars of 170 (the outline of H is 1493 high)
    assert thinnest_stroke_mm(straight([line])) == pytest.approx(2.0 * 170 / 1493, rel=0.01)
    assert thinnest_stroke_mm(straight([lay_out(font, "I", 2.0)])) == pytest.approx(2.0 * 201 / 1493, rel=0.01)
    assert thinnest_stroke_mm(straight([lay_out(font, "LITHE", 6.0)])) == pytest.approx(6.0 * 170 / 1493, rel=0.01)
    assert thinnest_stroke_mm(around(line, ring_of(12.0))) == pytest.approx(2.0 * 170 / 1493, rel=0.01)


def test_thin_parts_of_bold_letters_count():
    bold, regular = (
        thinnest_stroke_mm(straight([lay_out(nm.read_font(name), "ANNO MMXXVI", 2.0)]))
        for name in ("DejaVu Sans:bold", "DejaVu Sans")
    )
    serif = thinnest_stroke_mm(straight([lay_out(nm.read_font("DejaVu Serif:bold"), "ANNO MMXXVI", 2.0)]))
    assert serif < regular < bold
