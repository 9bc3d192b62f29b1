"""Outlines from SVG files: units, transforms, shapes, holes, and every refusal."""

from __future__ import annotations

import math

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.io.vector import svg
from nmaptool.types.contours import ring_area

DOCTYPE = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'


@pytest.fixture
def drawing(tmp_path):
    """Write an SVG file with some content."""

    def write(content, attributes='width="100mm" height="80mm" viewBox="0 0 100 80"', before=""):
        path = tmp_path / "plate.svg"
        text = f'<?xml version="1.0" encoding="UTF-8"?>{before}<svg xmlns="http://www.w3.org/2000/svg" '
        path.write_text(f'{text}xmlns:xlink="http://www.w3.org/1999/xlink" {attributes}>{content}</svg>', "utf-8")
        return path

    return write


@pytest.mark.parametrize("tolerance_mm", [0.05, 0.002, 1e-5])
def test_a_circle_has_its_area_within_the_tolerance(drawing, tolerance_mm):
    outline = nm.read_svg_outline(drawing('<circle cx="50" cy="40" r="19"/>'), tolerance_mm=tolerance_mm)
    missing = math.pi * 19**2 - outline.area_mm2
    assert 0 < missing < 2 * math.pi * 19 * tolerance_mm
    assert outline.bounds_mm == pytest.approx(np.array([[0.0, 0.0], [38.0, 38.0]]), abs=2 * tolerance_mm)
    distance = np.hypot(*(outline.rings[0] - 19).T)
    assert distance.max() == pytest.approx(19, abs=2 * tolerance_mm)
    assert outline.tolerance_mm == tolerance_mm


@pytest.mark.parametrize(
    ("attributes", "width_mm"),
    [
        ('width="100mm" height="80mm" viewBox="0 0 100 80"', 10.0),
        ('width="10cm" height="8cm" viewBox="0 0 100 80"', 10.0),
        ('width="10in" height="8in" viewBox="0 0 100 80"', 25.4),
        ('width="96px" height="76.8px" viewBox="0 0 100 80"', 2.54),
        ('width="96" height="76.8"', 10 * 25.4 / 96),
        ('viewBox="0 0 100 80"', 10 * 25.4 / 96),
        ("", 10 * 25.4 / 96),
        ('width="100%" height="100%" viewBox="0 0 100 80"', 10 * 25.4 / 96),
        ('width="50mm" height="40mm" viewBox="-50 -40 100 80"', 5.0),
    ],
)
def test_units_and_view_box_give_the_size(drawing, attributes, width_mm):
    outline = nm.read_svg_outline(drawing('<rect x="3" y="4" width="10" height="20"/>', attributes))
    assert outline.bounds_mm == pytest.approx(np.array([[0.0, 0.0], [width_mm, 2 * width_mm]]), rel=1e-9)
    assert outline.area_mm2 == pytest.approx(2 * width_mm**2, rel=1e-9)
    assert len(outline.rings[0]) == 4


def test_y_points_up(drawing):
    outline = nm.read_svg_outline(drawing('<path d="M10 10 h30 l-15 -5 z"/>'))
    assert outline.rings[0][np.argmax(outline.rings[0][:, 1])] == pytest.approx((15.0, 5.0))


@pytest.mark.parametrize(
    ("shape", "area_mm2"),
    [
        ('<ellipse cx="30" cy="30" rx="20" ry="7"/>', math.pi * 140),
        ('<polygon points="0,0 10,0 10,10"/>', 50.0),
        ('<polyline points="0,0 10,0 10,10 0,0"/>', 50.0),
        ('<rect width="30" height="20" rx="4"/>', 600 - (4 - math.pi) * 16),
        ('<path d="M0 0 C 0 10 10 10 10 0 Z"/>', 60.0),
        ('<path d="M0 0 Q 5 10 10 0 Z"/>', 100 / 3),
        ('<path d="M0 0 A 5 5 0 0 1 10 0 Z"/>', math.pi * 12.5),
        ('<path d="m10,10 10,0 0,10 -10,0z m2,2 6,0 0,6 -6,0z"/>', 64.0),
        ('<path d="m10,10 10,0 0,10 -10,0z"/><circle cx="15" cy="15" r="2"/>', 100 - 4 * math.pi),
        ('<g transform="translate(9 9) rotate(30)"><rect width="9" height="4" transform="scale(2 3)"/></g>', 216.0),
        ('<circle r="5" transform="translate(20 20) skewX(20) scale(2 1)"/>', 50 * math.pi),
        ('<defs><rect id="a" width="9" height="4"/></defs><use xlink:href="#a" x="5"/>', 36.0),
        ('<rect width="9" height="4"/><rect width="90" height="4" style="display:none"/>', 36.0),
        ('<rect width="9" height="4" fill="none" stroke="red" stroke-width="3"/><image width="3" height="3"/>', 36.0),
    ],
)
def test_every_shape_has_its_area(drawing, shape, area_mm2):
    outline = nm.read_svg_outline(drawing(shape), tolerance_mm=1e-4)
    assert outline.area_mm2 == pytest.approx(area_mm2, rel=1e-4)
    assert [ring_area(ring) > 0 for ring in outline.rings] == [True] + [False] * (len(outline.rings) - 1)


def test_the_way_round_of_holes_does_not_matter(drawing):
    first = nm.read_svg_outline(drawing('<path d="M0 0H9V9H0Z M2 2H4V4H2Z M5 5V7H7V5Z"/>'))
    assert first.area_mm2 == pytest.approx(81 - 8, rel=1e-9)
    assert len(first.rings) == 3


def test_what_drawing_programs_write_is_read(drawing, tmp_path):
    assert nm.read_svg_outline(drawing('<rect width="9" height="4"/>', before=DOCTYPE)).area_mm2 == pytest.approx(36.0)
    path = tmp_path / "prefix.svg"
    path.write_text(
        '<svg:svg xmlns:svg="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">'
        '<svg:path d="M1 1 5 1 5 5 1 5.0001"/></svg:svg>'
    )
    # ends that are 4 mm apart
    with pytest.raises(nm.InputError, match=r"prefix.svg: the path is not closed, the ends are 4 mm apart; close it"):
        nm.read_svg_outline(path)
    assert nm.read_svg_outline(drawing('<path d="M0 0H9V4H0V0.0005"/>')).area_mm2 == pytest.approx(36.0, rel=1e-4)


REFUSED = {
    "open": ('<path d="M0 0H9V4"/>', r"plate.svg: the path is not closed, the ends are 9.85 mm apart; close it"),
    "one open": ('<rect width="9" height="4"/><line x1="1" y1="1" x2="3" y2="1"/>', "1 of 2 paths are not closed"),
    "two": (
        '<rect width="9" height="4"/><rect x="20" width="9" height="4"/>',
        "has 2 outer paths; expected one closed",
    ),
    "nested": (
        '<circle cx="20" cy="20" r="9"/><circle cx="20" cy="20" r="6"/><circle cx="20" cy="20" r="3"/>',
        "has a path inside a hole; expected one closed path with holes inside it",
    ),
    "eight": ('<path d="M0 0 10 10 10 0 0 10Z"/>', r"a path crosses itself at 5.00,5.00 mm from the lower left corner"),
    "loop": ('<path d="M0 0H20V10L8 -2V5L0 10Z"/>', r"a path crosses itself at (8|10).00,1[02].00 mm from"),
    "twice around": ('<path d="M0 0H9V9H0Z H9V9H0Z"/>', "two paths cross or overlap; unite the paths"),
    "crossing": (
        '<rect width="10" height="10"/><rect x="5" y="5" width="10" height="10"/>',
        r"two paths cross or overlap at (5|10).00,(5|10).00 mm from the lower left corner; unite the paths",
    ),
    "plus": (
        '<rect y="4" width="12" height="2"/><rect x="4" width="2" height="12"/>',
        r"two paths cross or overlap at [46].00,[68].00 mm",
    ),
    "nothing": ("<g/>", "has no path or shape; draw one, and convert objects to paths"),
    "line": ('<path d="M0 0H9Z"/>', "has a closed path without an area; delete it"),
    "text": ('<rect width="9" height="4"/><text>hi</text>', "holds a text, which is not a path; convert it to paths"),
    "texts": ("<text>hi</text><text>ho</text>", "holds 2 texts, which are not a path"),
    "cycle": ('<g id="a"><use href="#a"/></g>', "a <use> element draws itself; export it again"),
    "nan": ('<rect width="1e999" height="4"/>', "plate.svg: (has coordinates that are not finite|is damaged)"),
    "transform": ('<rect width="9" height="4" transform="rotate(a b)"/>', "plate.svg: is damaged; export it again"),
    "unclosed": ("<g>", "plate.svg: is damaged; export it again"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_one_closed_path_is_refused(drawing, name):
    content, message = REFUSED[name]
    with pytest.raises(nm.InputError, match=message):
        nm.read_svg_outline(drawing(content))


def test_files_that_are_no_safe_svg_are_refused(drawing, tmp_path, monkeypatch):
    entity = '<!DOCTYPE svg [<!ENTITY a "aaaa">]>'
    with pytest.raises(nm.InputError, match="declares a document type or entities"):
        nm.read_svg_outline(drawing('<rect width="9" height="4"/>', before=entity))
    uses = [f'<use href="#g{n}"/>' * 10 for n in range(8)]
    bomb = "".join(f'<g id="g{n + 1}">{content}</g>' for n, content in enumerate(uses))
    with pytest.raises(nm.LimitError, match="draws more than 10000 elements; simplify the drawing"):
        nm.read_svg_outline(drawing(f'<defs><rect id="g0" width="9" height="4"/>{bomb}</defs><use href="#g8"/>'))
    for data, message in (
        (b"\x1f\x8b\x08", r"is compressed \(.svgz\); save it as plain SVG"),
        (b"<html></html>", r"is not an SVG file \(its first element is <html>\)"),
        (b"plain text", "is damaged; export it again"),
        (b"", "is empty"),
    ):
        (tmp_path / "other.svg").write_bytes(data)
        with pytest.raises(nm.InputError, match=message):
            nm.read_svg_outline(tmp_path / "other.svg")
    with pytest.raises(nm.InputError, match=r"missing.svg: no such file"):
        nm.read_svg_outline(tmp_path / "missing.svg")
    monkeypatch.setattr(svg, "_LARGEST", 100)
    with pytest.raises(nm.LimitError, match=r"has \d+ bytes, more than 100; simplify the drawing"):
        nm.read_svg_outline(drawing('<rect width="9" height="4"/>'))


@pytest.mark.parametrize("tolerance_mm", [0.0, -1.0, float("nan")])
def test_the_tolerance_is_a_positive_number(drawing, tolerance_mm):
    with pytest.raises(nm.UsageError, match=r"`tolerance_mm=.*`: must be a number greater than zero"):
        nm.read_svg_outline(drawing('<rect width="9" height="4"/>'), tolerance_mm=tolerance_mm)


def test_too_many_paths_are_refused(drawing):
    holes = "".join(f"M{1 + x % 40 * 2} {1 + x // 40 * 2}h1v1h-1z" for x in range(1001))
    with pytest.raises(nm.InputError, match="has 1002 closed paths, more than 1000; simplify the drawing"):
        nm.read_svg_outline(drawing(f'<path d="M0 0H99V79H0Z {holes}"/>'))
