"""Letters on plates: their area and outlines, heights, places, warnings and refusals."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from plate_cases import FONT, ball, design, made, solid
from solid_cases import check_solid

import nmaptool as nm
from nmaptool.options.plates import TextOptions
from nmaptool.plates.board import Board
from nmaptool.plates.distance import Curves
from nmaptool.plates.layout import lay_out, outline_of
from nmaptool.plates.letters import letter_heights, letters_of
from nmaptool.plates.sizes import Sizes

TEXT = {"text": "ANNO", "text_at": "50%,88%", "text_size": "4mm"}
ARC = {"text": "Numismatik", "text_path": "arc", "text_size": "3mm"}


def lettered(texts, **values):
    """A relief with room for texts around the motif, without the warning that the picture has no background."""
    return made(design("round", texts, **({"margin": "9mm"} | values)))


def placed(texts, shape="round", width=40.0, **values):
    """The letters of a design and a grid around its plate."""
    wanted = design(shape, texts, **values)
    _, mask = ball(64, 64, 0.4)
    layout = lay_out(mask, wanted, pitch_mm=None, width_mm=width)
    outline = outline_of(layout, mask, wanted, 0.1)
    return letters_of(layout, outline, wanted), Board.around(outline, 0.05), layout


@pytest.mark.parametrize(
    "text", [TEXT, ARC, {**TEXT, "text": "Æ&8@§", "text_at": "50%,80%"}], ids=lambda text: text["text"]
)
def test_the_volume_of_letters_is_their_area_times_their_height(text):
    (letters,), board, _ = placed((text,))
    added = letter_heights(board, letters, 0.3, 12.0)
    assert letters.stroke_mm > 2.5 * board.pitch_mm
    volume = added.sum() * board.pitch_mm**2
    assert volume == pytest.approx(letters.contours.area_mm2 * 0.3, rel=1e-2)
    assert added.max() == pytest.approx(0.3, abs=1e-12)
    sunk = letter_heights(board, letters, -0.3, 12.0)
    assert sunk == pytest.approx(-added, abs=1e-12)


def test_the_outline_at_half_height_is_that_of_the_font():
    (letters,), board, _ = placed((TEXT,))
    added = letter_heights(board, letters, 0.3, 12.0)
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots()
    found = axes.contour(board.x_mm, board.y_mm, added, [0.15]).get_paths()[0].to_polygons(closed_only=False)
    plt.close(figure)
    contours = board.placed(letters.contours)
    away = Curves(contours, 0.05).nearest(np.concatenate(found)).distance_mm
    assert away.max() < 0.6 * board.pitch_mm  # at corners
    assert away.mean() < 0.02 * board.pitch_mm
    area = abs(sum(((r[:, 0] * np.roll(r[:, 1], -1) - np.roll(r[:, 0], -1) * r[:, 1]).sum() / 2) for r in found))
    assert area == pytest.approx(contours.area_mm2, rel=1e-2)


@pytest.mark.parametrize("draft", [0.0, 12.0, 60.0])
@pytest.mark.parametrize("height", [0.1, 1.0, 3.0])
def test_letters_reach_their_full_height_at_any_draft(draft, height):
    (letters,), board, _ = placed(({**TEXT, "text": "HEIM"},))
    added = letter_heights(board, letters, height, draft)
    assert added.max() == pytest.approx(height, rel=1e-9)
    # not only at a few points: along the middle of all strokes
    depth = board.field(board.placed(letters.contours), 1.0).depth_mm()
    core = (depth > letters.stroke_mm / 2 - 1e-6) & (depth < np.inf)
    assert core.sum() > 100
    assert added[core].min() > 0.98 * height


def test_texts_are_reported():
    relief = lettered((TEXT, {**ARC, "text_sunk": True}), pitch="0.15mm")
    first, second = relief.plate.texts
    assert first["text"] == "ANNO"
    assert first["path"] == "line"
    assert first["size_mm"] == 4
    assert second["size_mm"] == 3
    (letters, _), _, _ = placed((TEXT, {**ARC, "text_sunk": True}))
    low, high = letters.contours.bounds_mm
    assert (high - low)[1] == pytest.approx(4, rel=0.06)  # O is a little higher than the capitals
    assert first["length_mm"] == pytest.approx((high - low)[0], rel=0.05)
    assert first["area_mm2"] == pytest.approx(letters.contours.area_mm2)
    assert first["stroke_mm"] == letters.stroke_mm
    assert first["height_mm"] == pytest.approx(0.5)
    assert second["height_mm"] == pytest.approx(-0.5)
    check_solid(solid(relief))


def test_default_sizes_of_texts():
    design_ = design("round", ({"text": "A"},))
    sizes = Sizes(50.0, 0.1)
    assert sizes.text(design_.texts[0]) == pytest.approx(3.5)  # 7% of the longer side
    arc = TextOptions(text="A", text_path="arc", text_size=nm.length("2mm"))
    assert sizes.text_inset(arc) == pytest.approx(1.2)
    with_arc = dataclasses.replace(design_, texts=(arc,))
    assert sizes.band(with_arc) == pytest.approx(1.2 + 3)
    assert sizes.margin(with_arc) == pytest.approx(0.75)
    assert sizes.margin(design_) == pytest.approx(2)


def test_letters_are_half_as_high_as_the_relief_and_at_most_a_fifth_of_their_size():
    (letters,), _, _ = placed((TEXT,))
    assert letters.height_mm(1.0) == pytest.approx(0.5)
    assert letters.height_mm(4.0) == pytest.approx(0.8)
    assert letters.height_mm(0.0) == pytest.approx(0.8)  # a flat motif
    (letters,), _, _ = placed(({**TEXT, "text_height": "0.3mm", "text_sunk": True},))
    assert letters.height_mm(4.0) == pytest.approx(-0.3)


def test_sunk_letters_lie_below_the_plate():
    text = {**TEXT, "text_height": "0.4mm", "text_sunk": True}
    relief = lettered((text,))
    assert relief.plate.lowest_mm == pytest.approx(-0.4, abs=1e-9)
    assert relief.plate.top_mm == pytest.approx(1, abs=1e-9)
    found = solid(relief)
    check_solid(found)
    assert found.bounds_mm[0, 2] == pytest.approx(-2)


def test_letters_along_the_edge_stand_between_frame_and_motif():
    wanted = design("round", (ARC,), frame="2mm", margin="1mm")
    _, mask = ball(64, 64, 0.4)
    layout = lay_out(mask, wanted, pitch_mm=None, width_mm=40.0)
    outline = outline_of(layout, mask, wanted, 0.1)
    (letters,) = letters_of(layout, outline, wanted)
    away = np.hypot(*(np.concatenate(letters.contours.rings) - layout.middle_mm).T)
    radius = 20 - 2 - 0.6 * 3  # of the heads of the capitals
    assert away.max() == pytest.approx(radius, abs=0.25)
    assert away.min() == pytest.approx(radius - 3, abs=0.2)
    motif = 0.4 * 32 * layout.pitch_mm
    # the farthest corner of a pixel of the motif is at the margin
    assert 20 - 2 - (0.6 + 1.5) * 3 - 1 - layout.pitch_mm * 1.5 < motif < 20 - 2 - (0.6 + 1.5) * 3 - 1


def test_fine_pixels_are_chosen_for_letters_unless_they_are_given():
    relief = lettered((TEXT,))
    stroke = relief.plate.texts[0]["stroke_mm"]
    assert relief.pitch_mm == pytest.approx(stroke / 5, rel=0.02)
    assert relief.plate.resampled > 1
    assert not relief.plate.warnings
    coarse = lettered((TEXT,), pitch="0.4mm")
    assert coarse.pitch_mm == pytest.approx(0.4, rel=0.02)
    (warning,) = coarse.plate.warnings
    assert warning.startswith("strokes of the text 'ANNO' are ")
    assert "a finer `pitch`, such as `pitch='" in warning


def test_text_on_the_motif_is_reported():
    two = {**TEXT, "text": "ANNO\\n2026", "text_at": "50%,50%", "text_size": "2mm"}
    (warning,) = made(design("round", (two,))).plate.warnings
    assert "text 'ANNO 2026' lies on the motif" in warning
    text = {**TEXT, "text_at": "50%,50%", "text_size": "2mm"}
    relief = made(design("round", (text,)))
    (warning,) = relief.plate.warnings
    assert warning == ("100% of the text 'ANNO' lies on the motif; move it with `text_at`, or make `text_size` smaller")
    normals, _ = ball(64, 64, 2.0)
    covered = made(design("round", (text,), fill="cover"), (normals, None))
    assert not any("lies on the motif" in each for each in covered.plate.warnings)


def test_strokes_finer_than_the_machine_are_reported():
    relief = lettered((TEXT,), finest="1mm")
    stroke = relief.plate.texts[0]["stroke_mm"]
    assert any(
        each.startswith(f"strokes of the text 'ANNO' are {stroke:.3g} mm wide, finer than the 1 mm of the machine")
        for each in relief.plate.warnings
    )
    coarse = lettered((TEXT,), finest="0.1mm")
    assert not any("finer than" in each for each in coarse.plate.warnings)


def test_texts_that_do_not_fit_are_refused():
    with pytest.raises(
        nm.InputError, match=r"the text 'ANNO DOMINI' is \d\S* x \d\S* mm and reaches \d\S* mm into the frame"
    ):
        made(
            design("round", ({**TEXT, "text": "ANNO DOMINI", "text_at": "50%,50%", "text_size": "3.1mm"},), frame="3mm")
        )
    with pytest.raises(nm.InputError, match=r"'ANNO' is .* and reaches \S* mm beyond the edge of the plate; use a sma"):
        made(design("round", ({**TEXT, "text_at": "50%,99%"},)))
    with pytest.raises(nm.InputError, match=r"the text is \d\S* mm long at 3mm, the edge has \d\S* mm; use a smaller"):
        made(design("round", ({**ARC, "text": "a legend that is far too long for a coin " * 3},)), ball(64, 64, 0.4))
    with pytest.raises(nm.InputError, match="no room is left for the motif on a plate 40 mm wide: lettering "):
        made(design("round", ({**ARC, "text_size": "15mm"},)))
    normals, _ = ball(40, 40, 2.0)
    with pytest.raises(
        nm.InputError, match=r"the text 'Numismatik' lies 11.2 mm inside the edge of a plate 40 mm wide"
    ):
        made(design("star.svg", ({**ARC, "text_size": "7mm"},), fill="cover"), (normals, None))


def test_glyphs_that_the_font_lacks_are_refused():
    with pytest.raises(
        nm.InputError, match=r"the font DejaVu Serif:bold \(.*\) lacks '.' \(U\+1F9C0\); use another `font`"
    ):
        made(design("round", ({**TEXT, "text": "A\U0001f9c0"},)))


def test_texts_need_their_font():
    text = TextOptions(text="A", font=FONT)
    with pytest.raises(nm.UsageError, match=f"`font='{FONT}'`: the design lacks this font; read it with read_design"):
        made(nm.PlateDesign(nm.PlateOptions(shape="round"), texts=(text,)))
    with pytest.raises(nm.UsageError, match="`text`: a text needs letters, such as `text='ANNO MMXXVI'`"):
        made(nm.PlateDesign(nm.PlateOptions(shape="round"), texts=(TextOptions(),)))
