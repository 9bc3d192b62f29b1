"""Pictures of reliefs in a material: `nmaptool.preview`."""

import numpy as np
import pytest
from preview_cases import cone, disc

import nmaptool as nm
from nmaptool.core.errors import UsageError


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"material": "cheese"}, "`material='cheese'`: use one of clay, plaster, bronze"),
        ({"light": ("135",)}, "`light='135'`: expected azimuth and elevation in degrees, such as 135,38"),
        ({"light": ("135,0",)}, "an elevation of 0 degrees is not above the plate"),
        ({"light": ("135,91",)}, "an elevation of 91 degrees is not above the plate"),
        ({"light": ("135,38,11",)}, "a strength of 11 must lie between 0 and 10"),
        ({"light": ("nan,38",)}, "expected azimuth and elevation"),
        ({"section": "z=3mm"}, "`section='z=3mm'`: expected x or y and a place, such as y=50% or x=12mm"),
        ({"section": "y=3"}, "`section='y=3'`: expected x or y and a place"),
        ({"section": "y=3mm", "size": 200}, "`size=200`: a section with its axes needs at least 240 px"),
        ({"background": "blue"}, "`background='blue'`: use auto, or a colour such as #e8e4dc"),
        ({"size": 4}, "`size=4`: must lie between 16 and 8000, such as 1200"),
        ({"frames": 1}, "`frames=1`: must lie between 2 and 1000"),
        ({"turntable": True, "light_sweep": True}, "`turntable` and `light_sweep`: only one of them fits"),
        ({"turntable": True, "section": "y=50%"}, "`section` and `turntable`: only one of them fits"),
        ({"view": "iso", "section": "y=50%"}, "`section` is a plot, and `view='iso'` a picture"),
        ({"thickness": "5px"}, "`thickness='5px'`: sets the thickness of the plate; give it in mm"),
    ],
)
def test_wrong_options_are_refused(words, message):
    with pytest.raises(UsageError) as told:
        nm.PreviewOptions(**words)
    assert message in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("name", nm.MATERIALS)
@pytest.mark.parametrize("view", ["top", "iso"])
def test_every_material_shows_the_relief_from_both_sides(name, view):
    picture = nm.preview(disc(), nm.PreviewOptions(material=name, view=view, size=240))
    assert picture.dtype == np.uint8
    assert max(picture.shape) == 240
    assert picture.shape[2] == 3
    middle = picture[picture.shape[0] // 4 : -picture.shape[0] // 4, 60:-60].astype(float)
    assert middle.std() > 4
    assert 20 < middle.mean() < 235


def test_the_picture_is_lit_from_the_upper_left_and_the_far_side_is_in_shadow():
    height = cone(slope=1.5)
    picture = nm.preview(height).mean(axis=2)
    factor = picture.shape[1] / 120
    tip = np.array([40, 60]) * factor
    near, far = (picture[tuple((tip + sign * 6 * factor).astype(int))] for sign in (-1, 1))
    plate = picture[5, -5]
    assert near > plate > far
    low = nm.preview(height, nm.PreviewOptions(light=("135,20",))).mean(axis=2)
    beyond = tuple((tip + 20 * factor).astype(int))  # on the plate: the cone ends 13 px from its tip
    assert low[beyond] < 0.75 * low[5, -5]


def test_lights_add_up_and_none_leaves_the_sky():
    height = cone()
    dark = nm.preview(height, nm.PreviewOptions(light=())).astype(int)
    one = nm.preview(height, nm.PreviewOptions(light=("135,38",))).astype(int)
    two = nm.preview(height, nm.PreviewOptions(light=("135,38", "-45,38"))).astype(int)
    assert (two >= one).all()
    assert (one >= dark).all()
    assert two.mean() > one.mean() + 5 > dark.mean() + 10
    assert nm.PreviewOptions(light="90,20").light == ("90,20",)


def test_the_background_shows_around_the_piece():
    plain = nm.preview(disc(), nm.PreviewOptions(size=160))
    red = nm.preview(disc(), nm.PreviewOptions(size=160, background="#c81e1e"))
    assert red[3, 3, 0] > 2 * red[3, 3, 1]
    assert abs(int(plain[3, 3, 0]) - int(plain[3, 3, 2])) < 20
    np.testing.assert_array_equal(plain[80, 60:100], red[80, 60:100])


def test_a_thicker_plate_stands_higher_in_perspective():
    shapes = [nm.preview(disc(), nm.PreviewOptions(view="iso", size=300, thickness=f"{mm}mm")).shape for mm in (1, 8)]
    assert max(shapes[0]) == max(shapes[1]) == 300
    assert shapes[1][0] / shapes[1][1] > shapes[0][0] / shapes[0][1] + 0.1


def test_a_normal_map_and_a_relief_give_the_same_picture():
    y, x = np.mgrid[1:-1:48j, -1:1:64j]
    normal_map = nm.NormalMap.from_array(np.dstack([x, y, np.ones_like(x)]), np.hypot(x, y) < 0.9, 0.5, "dome")
    np.testing.assert_array_equal(nm.preview(normal_map), nm.preview(nm.relief(normal_map)))


def test_values_without_a_preview_are_refused():
    with pytest.raises(UsageError, match="the relief must be a Height, Relief, NormalMap or Mesh, found ndarray"):
        nm.preview(np.zeros((4, 4)))
    with pytest.raises(UsageError, match="`turntable`: makes a film; write it with write_preview"):
        nm.preview(cone(), nm.PreviewOptions(turntable=True))
