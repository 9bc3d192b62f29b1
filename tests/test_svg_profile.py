"""Profiles of frames from SVG files."""

from __future__ import annotations

import numpy as np
import pytest

import nmaptool as nm


@pytest.fixture
def profile(tmp_path):
    def read(content):
        path = tmp_path / "profile.svg"
        path.write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="0 0 20 20">{content}</svg>'
        )
        return nm.read_svg_profile(path)

    return read


def test_a_line_keeps_its_corners(profile):
    found = profile('<polyline points="2,10 4,5 8,5 12,8"/>')
    assert found == pytest.approx(np.array([[0.0, 0.0], [0.2, 1.0], [0.6, 1.0], [1.0, 0.4]]), abs=1e-9)
    assert not found.flags.writeable


def test_the_direction_of_drawing_does_not_matter(profile):
    forwards, backwards = profile('<path d="M0 9 L3 2 L9 9"/>'), profile('<path d="M9 9 L3 2 L0 9"/>')
    assert forwards == pytest.approx(backwards)


def test_a_half_circle_is_round(profile):
    x, y = profile('<path d="M2 10 A 5 5 0 0 1 12 10"/>').T
    assert y == pytest.approx(2 * np.sqrt(np.maximum(x * (1 - x), 0)), abs=3e-4)
    between = (x[1:] + x[:-1]) / 2
    assert np.hypot(between - 0.5, np.interp(between, x, y) / 2) == pytest.approx(0.5, abs=2e-4)
    assert (x[0], x[-1], y.max()) == pytest.approx((0.0, 1.0, 1.0))


def test_steps_are_kept(profile):
    found = profile('<path d="M0 9 V5 H4 V2 H10"/>')
    assert found[:, 0] == pytest.approx([0.0, 0.0, 0.4, 0.4, 1.0])
    assert found[:, 1] == pytest.approx([0.0, 4 / 7, 4 / 7, 1.0, 1.0])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            '<path d="M0 9 L6 2 L4 5 L9 9"/>',
            r"profile.svg: the path turns back by 2 mm of 9 mm; expected a path from left",
        ),
        ('<path d="M3 9 L0 5 L9 9"/>', r"profile.svg: the path turns back by 3 mm of 9 mm"),
        ('<rect width="4" height="3"/>', "the path is closed; expected an open path from the outer edge to the inner"),
        ('<path d="M0 0 L4 3 M5 5 L6 7"/>', "has 2 paths; expected one open path from the outer edge to the inner"),
        ('<path d="M0 0 V3"/>', "the path has no width; expected a path from left to right"),
        ('<path d="M0 0 H3"/>', "the path is level, without a height; use `frame_profile='flat'`"),
        ("<text>a</text>", "holds a text, which is not a path"),
    ],
)
def test_what_is_no_profile_is_refused(profile, content, message):
    with pytest.raises(nm.InputError, match=message):
        profile(content)
