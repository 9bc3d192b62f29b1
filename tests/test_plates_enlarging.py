"""The room that a motif has beside letters in arcs."""

from __future__ import annotations

import numpy as np
import pytest
from plate_cases import blob, corners_mm, design

from nmaptool.plates.enlarging import enlarged
from nmaptool.plates.layout import lay_out, outline_of
from nmaptool.plates.letters import letters_of


def outlines_of(mask, wanted, width=40.0):
    """The layout beside the letters, and corners of the motif and of the letters from the middle of the plate."""
    first = lay_out(mask, wanted, pitch_mm=None, width_mm=width)
    letters = letters_of(first, outline_of(first, mask, wanted, first.pitch_mm), wanted)
    layout = enlarged(first, mask, wanted, letters)
    letters = letters_of(layout, outline_of(layout, mask, wanted, layout.pitch_mm), wanted)
    texts = np.concatenate([ring for each in letters for ring in each.contours.rings]) - layout.middle_mm
    return first, layout, corners_mm(mask, layout), texts


@pytest.mark.parametrize("shape", [{}, {"aspect": "3:4"}])
@pytest.mark.parametrize("side", ["top", "bottom"])
def test_a_motif_uses_the_room_beside_letters_in_an_arc(shape, side):
    arc = {"text": "ANNO", "text_path": "arc", "text_side": side, "text_size": "3mm"}
    wanted = design("oval" if shape else "round", (arc,), frame="2mm", margin="1mm", **shape)
    first, layout, motif, texts = outlines_of(blob(), wanted)
    assert layout.pitch_mm > 1.1 * first.pitch_mm
    assert (layout.width_mm, layout.height_mm) == (first.width_mm, first.height_mm)
    # it moves away from the letters, and keeps the margin from them and from the frame
    assert motif[:, 1].mean() * (-1 if side == "top" else 1) > 0.3
    near = np.hypot(*(motif[:, None] - texts[None]).transpose(2, 0, 1)).min()
    assert near > 0.998  # the polygon of the edge, along which letters are placed, has other corners
    half = np.array([layout.width_mm, layout.height_mm]) / 2 - 3
    reach = np.hypot(*(motif / half).T).max()
    assert reach <= 1 + 1e-9
    assert reach > 0.995 or near < 1.05


@pytest.mark.parametrize("text", [{"text_path": "circle"}, {"text_path": "ring"}, {"text_size": "20px"}])
def test_letters_all_around_or_in_pixels_keep_their_band(text):
    arc = {"text": "ANNO", "text_path": "arc", "text_size": "2mm"} | text
    first, layout, _, _ = outlines_of(blob(), design("round", (arc,), frame="2mm", margin="1mm"))
    assert layout is first
