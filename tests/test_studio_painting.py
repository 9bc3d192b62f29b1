"""Brush strokes: their shape, and the pictures that the studio keeps of them."""

import cv2
import numpy as np
import pytest
from stack_cases import write_maps
from studio_cases import ask, served, until

import nmaptool as nm
from nmaptool.core.errors import UsageError
from nmaptool.studio.painting.strokes import MOST_POINTS, Brush, reach_of, stroke

WHITE = np.ones((40, 60), np.float32)


def points(*given):
    return np.array([(*one, 1.0) if len(one) == 2 else one for one in given], float)


def test_a_dab_is_a_disc_of_its_size():
    brush = Brush(size=20, hardness=1)
    share = reach_of((60, 60), brush, points((30, 30)))
    assert share.sum() == pytest.approx(np.pi * 10**2, rel=0.02)
    assert np.array_equal(share, share.T)
    assert share[30, 30] == 1
    assert share[30, 41] == 0
    y, x = np.nonzero(share)
    assert np.hypot(x + 0.5 - 30, y + 0.5 - 30).max() < 10.6
    half = reach_of((60, 60), brush, points((30, 30, 0.5)))
    assert half.sum() == pytest.approx(np.pi * 5**2, rel=0.03)  # pressure scales the size


def test_a_soft_brush_fades_to_its_rim():
    share = reach_of((60, 60), Brush(size=40, hardness=0.25), points((30.5, 30.5)))
    profile = share[30, 30:52]
    assert profile[0] == 1
    assert profile[4] == 1
    assert np.all(np.diff(profile) <= 0)
    assert profile[13] == pytest.approx(0.5, abs=0.05)  # half way from the hard part to the rim
    assert profile[21] == 0


def test_a_stroke_that_crosses_itself_acts_once():
    brush = Brush(size=8, hardness=1, opacity=0.4)
    once = stroke(WHITE, brush, points((5, 20), (55, 20)), 1.0)
    twice = stroke(WHITE, brush, points((5, 20), (55, 20), (5, 20)), 1.0)
    assert np.array_equal(once, twice)
    assert once.min() == pytest.approx(0.6)
    assert once[20, 30] == once.min()
    assert once[0].min() == 1


def test_the_points_of_a_stroke_may_be_split():
    brush = Brush(size=10)
    whole = stroke(WHITE, brush, points((5, 5), (45, 30)), 1.0)
    split = stroke(WHITE, brush, points((5, 5), (25, 17.5), (45, 30)), 1.0)
    assert np.abs(whole - split).max() < 1e-5


def test_erase_smooth_and_fill():
    painted = stroke(WHITE, Brush(size=20, hardness=1, value=0.25), points((30, 20)), 1.0)
    assert painted[20, 30] == 0.25
    before = np.full_like(WHITE, 0.75)
    erased = stroke(painted, Brush("erase", size=40, hardness=1), points((30, 20)), before)
    assert erased[20, 30] == 0.75
    assert erased[0, 0] == 1
    smooth = stroke(painted, Brush("smooth", size=60, hardness=1), points((30, 20)), 1.0)
    steps = [np.abs(np.diff(picture[20])).max() for picture in (painted, smooth)]
    assert steps[1] < 0.3 * steps[0]
    filled = stroke(painted, Brush("fill", value=0.5), points((30, 20)), 1.0)
    assert filled[20, 30] == 0.5
    assert filled[0, 0] == 1
    assert np.array_equal(filled == 0.5, np.abs(painted - 0.25) <= 0.02)


def test_strokes_may_leave_the_picture():
    painted = stroke(WHITE, Brush(size=10, hardness=1), points((-30, 20), (5, 20), (500, 20)), 1.0)
    assert painted[20].max() == 0
    assert np.array_equal(stroke(WHITE, Brush(size=10), points((-30, -30)), 1.0), WHITE)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"tool": "burn"}, "the brush 'burn' is not one of paint, erase, smooth, fill"),
        ({"size": 0}, "a brush of 0 px"),
        ({"size": float("nan")}, "a brush of nan px"),
        ({"opacity": 1.5}, "an? opacity of 1.5: it must lie between 0 and 1"),
        ({"hardness": -1}, "a hardness of -1"),
    ],
)
def test_brushes_that_cannot_be(given, message):
    with pytest.raises(UsageError, match=message):
        Brush(**given)


def test_strokes_that_cannot_be():
    for wrong in (np.zeros((0, 3)), np.zeros((3, 2)), np.zeros((MOST_POINTS + 1, 3)), np.zeros(3)):
        with pytest.raises(UsageError, match="a stroke has 1 to 5000 points"):
            stroke(WHITE, Brush(), wrong, 1.0)
    for wrong in (np.nan, np.inf, 1e7):
        with pytest.raises(UsageError, match="a stroke left the picture"):
            stroke(WHITE, Brush(), points((wrong, 0)), 1.0)


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def shown(client, role):
    """The picture of a role, as the page gets it."""
    answer = client.get(f"/painted/{role}")
    assert answer.status == 200
    return cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_UNCHANGED)


def test_a_stroke_flattens_and_is_undone(folder):
    with served(folder / "bunny.exr") as client, client.live() as live:
        before = until(live, "frame")[1]
        assert shown(client, "delta_map").min() == 255
        motif = nm.read_normal_map(folder / "bunny.exr").foreground
        assert np.array_equal(shown(client, "mask") > 127, motif)
        brush = {"tool": "paint", "size": 60, "value": 0, "hardness": 1, "opacity": 1}
        ask(live, do="set", values={"beta": 0.1})
        until(live, "frame")
        ask(live, do="paint", role="beta_map", brush=brush, points=[[5, 20, 1], [9, 20, 1]])
        state = until(live, "state", lambda found: found["files"]["beta_map"])
        file = state["files"]["beta_map"]
        assert nm.read_raster(folder / file).bits == 16
        assert nm.read_grey(folder / file)[20, 8] == 0
        painted = until(live, "frame")[1]
        ask(live, do="paint", role="beta_map", brush={**brush, "value": 0.5}, points=[[25, 20, 1]])
        again = until(live, "state")["files"]["beta_map"]
        assert again != file
        ask(live, do="undo")
        assert until(live, "state")["files"]["beta_map"] == file
        ask(live, do="undo")
        assert until(live, "state")["files"]["beta_map"] is None
        assert shown(client, "beta_map").min() == 255
        assert np.abs(painted["first"] - before["first"]).max() > 0
        ask(live, do="paint", role="mask", brush={**brush, "size": 12}, points=[[15, 20, 1]])
        until(live, "state")
        assert shown(client, "mask")[20, 15] == 0
        assert shown(client, "mask").sum() < 255 * motif.sum()


def test_wrong_strokes_are_answered_in_one_line(folder, png):
    png(folder / "small.png", np.full((8, 8), 255, np.uint8))
    with served(folder / "bunny.exr") as client, client.live() as live:
        until(live, "frame")
        for message, expected in (
            ({"role": "hat"}, "'hat', which cannot be painted"),
            ({"role": "mask"}, "sent no brush"),
            ({"role": "mask", "brush": {"width": 3}}, "sent no brush"),
            ({"role": "mask", "brush": {"size": "x"}}, "a stroke that is not one"),
            ({"role": "mask", "brush": {}, "points": [[1, 2]]}, "points of three numbers"),
            ({"role": "mask", "brush": {}, "points": [[1], [2, 3]]}, "a stroke that is not one"),
        ):
            ask(live, do="paint", **message)
            assert expected in until(live, "error")["text"]
        assert client.get("/painted/hat").status == 400
        client.drop(folder / "small.png")
        ask(live, do="set-file", role="mu_map", file="small.png")
        until(live, "error")  # the relief cannot be solved with it
        assert b"small.png: is 8 x 8 px, the map 30 x 40 px" in client.get("/painted/mu_map").body


def test_the_mask_of_a_layer_is_painted_in_its_own_px(folder, tmp_path):
    with served(folder / "plate.exr", folder / "bunny.exr", root=tmp_path / "state") as client, client.live() as live:
        until(live, "frame")
        assert client.get("/painted/layer-mask?place=7").status == 400
        assert shown(client, "layer-mask?place=1").shape == (40, 30)
        brush = {"tool": "paint", "size": 16, "value": 0, "hardness": 1, "opacity": 1}
        ask(live, do="paint", role="layer-mask", place=[1], brush=brush, points=[[15, 20, 1]])
        state = until(live, "state", lambda found: found["layers"][1]["mask"])
        assert nm.read_grey(folder / state["layers"][1]["mask"])[20, 15] == 0
        until(live, "frame")
        with_hole = client.studio.engine.scene.composition
        plate = nm.read_normal_map(folder / "plate.exr")
        # the bunny lies at 25,10: through the hole the plate shows
        assert np.allclose(with_hole.normal_map.normals[30, 40], plate.normals[30, 40], atol=1e-6)
        ask(live, do="save", name="scene")
        until(live, "saved")
        assert nm.read_recipe(folder / "scene.toml").layers[1].mask == "scene-layer-mask.png"
        ask(live, do="set-layer", place=[1], values={"mask": "/etc/passwd"})
        assert "dropped files alone" in until(live, "error")["text"]
        ask(live, do="set-layer", place=[1], values={"mask": None})
        assert until(live, "state", lambda found: not found["layers"][1]["mask"])
