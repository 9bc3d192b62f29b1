"""A motif that stands on its plate with walls: its heights, its outline, its solid."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from scipy import ndimage
from solid_cases import PLATE, check_solid, crossings, random_blobs

import nmaptool as nm
from nmaptool.core.grid import touching_vertices
from nmaptool.reliefs.standing import Standing, bridged, flat_share

SIDE = 48


def facade(slope=0.0, island=False):
    """(H, W, 3) float32 flat normals with one dome, (H, W) bool a square motif, with a second one on demand."""
    normals = np.zeros((SIDE, SIDE, 3), np.float32)
    normals[..., 0], normals[..., 2] = -slope, 1
    y, x = np.mgrid[-23.5:24:1, -23.5:24:1]
    dome = np.hypot(x, y) < 8
    normals[dome, 0], normals[dome, 1] = x[dome] / 12, -y[dome] / 12
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    motif = np.zeros((SIDE, SIDE), bool)
    motif[8:40, 6:40] = True
    if island:
        motif[10:20, 43:47] = True
    return normals, motif


def options(**values):
    lengths = {"height", "edge_height", "width", "base", "shell", "hollow", "max_error"}
    kind = (
        nm.SolidOptions if values.keys() & {"base", "shell", "hollow", "max_error", "triangles"} else nm.ReliefOptions
    )
    return kind(**{name: nm.length(v) if name in lengths and isinstance(v, str) else v for name, v in values.items()})


def test_a_flat_facade_stays_flat_and_stands_free():
    normals, motif = facade()
    relief = nm.relief(normals, options=options(edge="wall", height="4mm", edge_height="3mm"), mask=motif)
    outline = touching_vertices(motif) & touching_vertices(~motif)
    assert relief.z_mm[~touching_vertices(motif)] == pytest.approx(0)
    assert relief.z_mm[outline] == pytest.approx(3, abs=0.3)
    assert relief.z_mm[outline].mean() == pytest.approx(3, abs=1e-9)
    assert relief.height.range_mm == pytest.approx((0, 4), abs=1e-9)
    assert relief.report.edge == "wall"
    assert relief.report.edge_height_mm == pytest.approx(3, abs=1e-9)
    # with the outline held to the plate it is a pillow
    pillow = nm.relief(normals, options=options(height="4mm"), mask=motif)
    assert np.ptp(pillow.z_mm[12:36, 7:14]) > 5 * np.ptp(relief.z_mm[12:36, 7:14])


def test_an_engraving_goes_down_from_its_plate():
    normals, motif = facade()
    given = options(edge="wall", height="4mm", edge_height="3mm", delta=-30.0)
    relief = nm.relief(normals, options=given, mask=motif)
    outline = touching_vertices(motif) & touching_vertices(~motif)
    assert relief.z_mm[outline].max() < 0
    assert relief.z_mm[outline].mean() == pytest.approx(-3)
    assert relief.height.range_mm == pytest.approx((-4, 0), abs=1e-9)


def test_each_island_has_its_own_wall():
    normals, motif = facade(slope=0.1, island=True)
    relief = nm.relief(normals, options=options(edge="wall", edge_height="5mm"), mask=motif)
    for part in (motif & (np.arange(SIDE) < 41), motif & (np.arange(SIDE) >= 41)):
        outline = touching_vertices(part) & touching_vertices(~part)
        assert relief.z_mm[outline].mean() == pytest.approx(5)


def test_a_wall_without_a_height_never_reaches_the_plate():
    normals, motif = facade(slope=0.6)
    for delta in (30.0, 0.0, -30.0):
        relief = nm.relief(normals, options=options(edge="wall", height="4mm", delta=delta), mask=motif)
        outline = np.abs(relief.z_mm[touching_vertices(motif) & touching_vertices(~motif)])
        assert outline.min() > 0.04 * 4
        assert np.abs(relief.z_mm).max() == pytest.approx(4)


def test_the_choice_is_by_how_much_is_flat():
    normals, motif = facade()
    assert flat_share(normals, motif) > 0.7
    assert nm.relief(normals, options=options(edge="auto"), mask=motif).report.edge == "wall"
    steep, _ = facade(slope=0.6)
    assert nm.relief(steep, options=options(edge="auto"), mask=motif).report.edge == "blend"
    assert nm.relief(normals, options=options(edge="auto")).report.edge == "blend"  # no plate to stand on


def test_a_session_keeps_the_edges_apart():
    normals, motif = facade()
    session = nm.ReliefSession(normals, mask=motif)
    wall, blend = options(edge="wall", height="4mm"), options(height="4mm")
    for given in (wall, blend, wall):
        again = nm.relief(normals, options=given, mask=motif)
        assert session.solve(given).z_mm == pytest.approx(again.z_mm, abs=1e-6)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"edge": "wall", "background": "cut"}, "`edge='wall'`: needs a flat plate, `background='plane'`, not cut"),
        ({"edge_height": "2mm"}, "`edge_height='2mm'`: needs `edge='wall'`"),
        ({"edge": "wall", "fit": "delta", "height": "3mm"}, "`fit='delta'`: is for `edge='blend'`; a wall goes with"),
    ],
)
def test_options_that_contradict_each_other_are_refused(values, message):
    with pytest.raises(nm.UsageError, match=message):
        options(**values)


@pytest.mark.parametrize(
    ("slope", "values", "message"),
    [
        (0.0, {"height": "2mm", "edge_height": "2mm"}, "`edge_height='2mm'`: must be less than `height='2mm'`"),
        (
            0.6,
            {"edge_height": "1mm"},
            "`edge_height='1mm'`: the outline would cut into the plate, because it",
        ),
    ],
)
def test_heights_that_cannot_be_are_refused(slope, values, message):
    normals, motif = facade(slope)
    with pytest.raises(nm.InputError, match=message):
        nm.relief(normals, options=options(edge="wall", **values), mask=motif)


def test_a_slab_is_as_high_as_its_wall():
    normals, motif = facade()
    normals[:] = (0, 0, 1)
    with pytest.raises(nm.InputError, match="`height='4mm'`: the motif is flat, so its wall is as high as the relief"):
        nm.relief(normals, options=options(edge="wall", height="4mm", edge_height="3mm"), mask=motif)
    relief = nm.relief(normals, options=options(edge="wall", height="4mm"), mask=motif)
    assert np.unique(relief.z_mm.round(9)).tolist() == [0, 4]


def test_heights_in_pictures_are_crisp():
    normals, motif = facade()
    relief = nm.relief(normals, options=options(edge="wall", height="4mm", edge_height="3mm"), mask=motif)
    centres = relief.height.at_pixels()
    assert (centres[~motif] == 0).all()
    assert centres[motif].min() > 2


def test_pixels_that_touch_at_a_corner_are_bridged_by_the_one_with_more_coverage():
    motif = np.zeros((4, 4), bool)
    motif[0, 0] = motif[1, 1] = motif[2, 2] = True
    coverage = np.zeros((4, 4), np.float32)
    coverage[1, 0], coverage[1, 2] = 0.4, 0.3
    joined = bridged(motif, coverage)
    assert np.argwhere(joined & ~motif).tolist() == [[1, 0], [1, 2]]
    rng = np.random.default_rng(2)
    noise = bridged(rng.random((40, 40)) > 0.6, rng.random((40, 40)).astype(np.float32))
    nw, ne, sw, se = noise[:-1, :-1], noise[:-1, 1:], noise[1:, :-1], noise[1:, 1:]
    assert not ((nw & se & ~ne & ~sw) | (ne & sw & ~nw & ~se)).any()


def raised_relief(seed):
    """A random raised motif, and heights all above or all below its plate."""
    rng = np.random.default_rng(seed)
    motif, coverage = random_blobs(rng, 2, 50)
    rows, cols = motif.shape
    motif = bridged(motif, coverage)
    z_mm = 2 + ndimage.gaussian_filter(rng.standard_normal((rows + 1, cols + 1)), 1) * rng.choice([0.01, 0.3])
    z_mm = np.where(touching_vertices(motif), z_mm * rng.choice([1, 1, -1]), 0.0)
    height = nm.Height(z_mm, np.ones((rows, cols), bool), nm.Frame(rows, cols, pitch_mm=0.1), motif)
    return nm.Relief(height, motif, PLATE, coverage if seed % 2 else None)


def test_random_raised_motifs_give_manifold_solids(trials):
    backs = (
        {"base": "4mm"},
        {"base": "4mm", "hollow": "0.5mm"},
        {"shell": "0.4mm"},
        {"base": "4mm", "max_error": "0.05mm"},
        {"base": "4mm", "max_error": "0.001mm"},
    )
    for seed in range(trials(300)):
        relief = raised_relief(seed)
        given = dataclasses.replace(options(**backs[seed % 5]), outline=("auto", "exact", "smooth")[seed % 3])
        solid = nm.solid(relief, given)
        check_solid(solid)
        if relief.height.domain.size < 220:
            mesh = solid.to_mesh()
            assert crossings(mesh.vertices, mesh.faces) == 0


def test_walls_are_vertical_and_the_open_surface_has_them():
    normals, motif = facade()
    relief = nm.relief(normals, options=options(edge="wall", height="4mm", edge_height="3mm", width="48mm"), mask=motif)
    surface = nm.solid(relief, nm.SolidOptions(outline="exact"))
    mesh = surface.to_mesh()
    normal = np.cross(*(mesh.vertices[mesh.faces[:, i]] - mesh.vertices[mesh.faces[:, 0]] for i in (1, 2)))
    walls = np.abs(normal[:, 2]) < 1e-12
    assert walls.sum() == 2 * 2 * (32 + 34)
    assert np.linalg.norm(normal[walls], axis=1).sum() / 2 == pytest.approx(2 * (32 + 34) * 3, rel=0.02)
    assert surface.bounds_mm[:, 2] == pytest.approx([0, 4])
    solid = nm.solid(relief, options(base="2mm"))
    check_solid(solid)
    assert solid.size_mm == pytest.approx((48, 48, 6))


def test_a_limit_of_triangles_holds_for_the_whole_solid():
    normals, motif = facade()
    relief = nm.relief(normals, options=options(edge="wall", height="4mm", edge_height="3mm"), mask=motif)
    solid = nm.solid(relief, options(base="2mm", triangles="2500"))
    check_solid(solid)
    assert 1500 < solid.face_count <= 2500
    with pytest.raises(nm.UsageError, match="`max_error` and `shell` do not go together with a raised motif"):
        nm.solid(relief, options(shell="2mm", max_error="0.1mm"))


def test_a_wall_that_vanishes_is_refused():
    z_mm = np.zeros((5, 5))
    z_mm[2, 2] = 1
    motif = np.zeros((4, 4), bool)
    motif[1:3, 1:3] = True
    height = nm.Height(z_mm, np.ones((4, 4), bool), nm.Frame(4, 4, pitch_mm=1.0), motif)
    with pytest.raises(nm.InputError, match="the outline of the raised motif lies at 0 to 0 mm, so its wall vanishes"):
        nm.solid(height, options(base="1mm"))
    motif = np.eye(4, dtype=bool)
    height = nm.Height(np.ones((5, 5)), np.ones((4, 4), bool), nm.Frame(4, 4, pitch_mm=1.0), motif)
    with pytest.raises(nm.InputError, match="pixels of the raised motif touch only at a corner; join them in the mask"):
        nm.solid(height, options(base="1mm"))


def test_raised_pixels_have_the_size_of_the_heights():
    with pytest.raises(nm.InputError, match=r"raised is bool \(2, 2\), expected bool \(4, 4\)"):
        nm.Height(np.zeros((5, 5)), np.ones((4, 4), bool), nm.Frame(4, 4, pitch_mm=1.0), np.ones((2, 2), bool))
    with pytest.raises(nm.InputError, match="a raised motif stands on a plate: the domain must be the whole picture"):
        nm.Height(np.zeros((5, 5)), np.eye(4, dtype=bool), nm.Frame(4, 4, pitch_mm=1.0), np.eye(4, dtype=bool))


def test_the_command_line_says_how_the_edge_was_chosen(tmp_path, run, codes, png):
    normals, motif = facade()
    alpha = (motif * 255).astype(np.uint8)
    png(tmp_path / "map.png", np.dstack([codes(normals), alpha]))
    report = tmp_path / "r.json"
    files = ("relief", tmp_path / "map.png", "-o", tmp_path / "m.stl", "--overwrite", "--height", "4mm")
    chosen = run(*files, "--edge", "auto", "--base", "2mm", "--report", report)
    assert "of the motif is flat; --edge blend lets it run down)" in chosen.err
    assert json.loads(report.read_text())["edge"] == "wall"
    blend = run(*files)
    assert "of the motif is flat and becomes rounded towards its outline; --edge wall keeps it flat" in blend.err
    wall = run(*files, "--edge", "wall", "--edge-height", "3mm")
    assert "edge: a wall of 3 mm on average\n" in wall.err


def test_islands_are_found_by_their_sides():
    motif = np.array([[1, 1, 0, 0], [1, 1, 0, 1], [0, 0, 0, 1]], bool)
    assert Standing(motif).mean_edge(np.arange(20.0).reshape(4, 5)) == pytest.approx(
        np.arange(20.0).reshape(4, 5)[touching_vertices(motif) & (touching_vertices(~motif) | border(motif))].mean()
    )


def border(motif):
    """(H+1, W+1) bool: vertices on the border of the picture."""
    out = np.ones((motif.shape[0] + 1, motif.shape[1] + 1), bool)
    out[1:-1, 1:-1] = False
    return out
