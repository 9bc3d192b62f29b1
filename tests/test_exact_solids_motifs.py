"""Plates with an exact outline: fewer triangles, raised motifs, foot lines, files, and what is refused."""

from __future__ import annotations

import dataclasses

import manifold3d
import numpy as np
import pytest
import trimesh
from matplotlib.tri import LinearTriInterpolator, Triangulation
from solid_cases import PLATE, check_solid, circle, crossings, options, plate, random_plate

import nmaptool as nm
from nmaptool.core.grid import touching_vertices
from nmaptool.io.solids.writer import write_solid
from nmaptool.solids.wording import describe_solid

X0, Y0 = 5.03, 5.04
RINGS = [circle(X0, Y0, 4.2, 300), circle(5.5, 7.1, 0.8, 61, is_hole=True)]
BOX = [np.array([(1.02, 1.03), (9.02, 1.03), (9.02, 7.03), (1.02, 7.03)])]
TILTED = [np.array([(1.0, 4.0), (6.0, 0.5), (9.0, 5.0), (4.0, 8.5)])]


def waves(x, y):
    return 0.5 * np.sin(x) * np.cos(y)


def below(x, y):
    """Waves along one side, flat elsewhere."""
    return np.where(y < 2.3, 0.3 * np.sin(6 * x) * (2.3 - y), 0.0)


def front_of(solid):
    """Vertices and faces of what faces up."""
    mesh = solid.to_mesh()
    corners = mesh.vertices[mesh.faces]
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 1e-12
    used, faces = np.unique(mesh.faces[up], return_inverse=True)
    return mesh.vertices[used], faces.reshape(-1, 3)


@pytest.mark.parametrize("error_mm", [0.001, 0.02, 0.1])
@pytest.mark.parametrize("z", [waves, below])
@pytest.mark.parametrize("rings", [RINGS, BOX, TILTED], ids=["round", "box", "tilted"])
def test_no_vertex_of_the_full_front_lies_further_off_than_the_error(rings, z, error_mm):
    height = plate(rings, z, 100, 100)
    vertices, full = front_of(nm.solid(height))
    solid = nm.solid(height, options(base="2mm", max_error=f"{error_mm}mm"))
    check_solid(solid)
    found, faces = front_of(solid)
    surface = LinearTriInterpolator(Triangulation(found[:, 0], found[:, 1], faces), found[:, 2])
    off = np.abs(surface(vertices[:, 0], vertices[:, 1]) - vertices[:, 2])
    assert np.ma.count_masked(off) <= 120  # points on the outline itself
    assert off.max() <= solid.facts["max_error_mm"] + 1e-12
    assert solid.facts["max_error_mm"] <= error_mm
    assert len(faces) < {0.001: 0.8, 0.02: 0.3, 0.1: 0.25}[error_mm] * len(full)


@pytest.mark.parametrize(("rings", "most"), [(BOX, 400), (RINGS, 361 * 4 + 300)], ids=["box", "round"])
def test_flat_plates_need_few_triangles(rings, most):
    solid = nm.solid(plate(rings, 1.0, 100, 100), options(base="2mm", max_error="0.001mm"))
    check_solid(solid)
    # each corner has a triangle of the strip, two of the wall and one of the back
    assert solid.face_count < most
    assert solid.facts["max_error_mm"] == 0


def test_heights_far_outside_do_not_matter():
    inside = plate(RINGS, 1.0, 100, 100)
    away = np.hypot(*(np.mgrid[100:-1:-1, :101] * 0.1 - np.array([Y0, X0])[:, None, None])) > 4.2 + 0.2
    other = dataclasses.replace(inside, z_mm=np.where(away, 0.0, 1.0))
    for given in ({}, {"max_error": "0.001mm"}):
        first, second = (nm.solid(each, options(base="2mm", **given)) for each in (inside, other))
        assert first.face_count == second.face_count
        assert first.volume_mm3 == second.volume_mm3


def test_a_limit_of_triangles_holds_with_an_exact_outline():
    for given in ({"base": "2mm"}, {"base": "2mm", "hollow": "0.5mm"}, {"shell": "0.6mm"}, {}):
        for rings in (RINGS, BOX):
            solid = nm.solid(plate(rings, waves, 100, 100), options(triangles="8000", **given))
            assert 7000 < solid.face_count <= 8000
            if given:
                check_solid(solid)
    with pytest.raises(nm.InputError, match="`triangles='200'`: the outline alone needs"):
        nm.solid(plate(RINGS, waves, 100, 100), options(triangles="200"))


def test_random_plates_stay_manifold_with_fewer_triangles(trials):
    for seed in range(trials(300)):
        rng = np.random.default_rng([seed, 3])
        back = ({"base": "3mm"}, {"base": "3mm", "hollow": "0.5mm"}, {"shell": "0.4mm"})[seed % 3]
        solid = nm.solid(random_plate(seed), options(max_error=str(rng.choice(["0.001mm", "0.05mm", "1mm"])), **back))
        check_solid(solid)
        if solid.face_count < 250:
            mesh = solid.to_mesh()
            assert crossings(mesh.vertices, mesh.faces) == 0, seed


def raised_plate(mask, z_mm=1.5, rings=RINGS):
    """A motif of some pixels that stands on a plate."""
    height = plate(rings, 0.0, 100, 100)
    return dataclasses.replace(height, z_mm=np.where(touching_vertices(mask), z_mm, 0.0), raised=mask)


def block():
    mask = np.zeros((100, 100), bool)
    mask[50:75, 35:60] = True
    return mask


@pytest.mark.parametrize("given", [{}, {"max_error": "0.01mm"}, {"triangles": "6000"}], ids=str)
def test_a_raised_motif_stands_on_a_plate(given):
    solid = nm.solid(raised_plate(block()), options(base="2mm", **given))
    check_solid(solid)
    area = plate(RINGS, 0.0, 100, 100).outline.area_mm2
    assert solid.volume_mm3 == pytest.approx(2 * area + 1.5 * 2.5**2, rel=1e-12)
    assert solid.bounds_mm[:, 2].tolist() == [-2, 1.5]
    if "triangles" in given:
        assert solid.face_count <= 6000


HOLLOW, SHELL = {"base": "2mm", "hollow": "0.5mm"}, {"shell": "0.6mm"}
THINNED = [("plain", {"base": "2mm"}), ("plain", HOLLOW), ("plain", SHELL), ("plain", {})]


@pytest.mark.parametrize(("kind", "back"), [*THINNED, ("raised", {"base": "2mm"}), ("raised", {})], ids=str)
def test_a_limit_that_is_too_low_is_refused_with_the_lowest_one(kind, back):
    height = plate(RINGS, waves, 100, 100) if kind == "plain" else raised_plate(block())
    with pytest.raises(nm.InputError, match=r"the outline alone needs [0-9,]+ triangles") as refused:
        nm.solid(height, options(triangles="100", **back))
    lowest = str(refused.value).split("needs ")[1].split(" ")[0].replace(",", "")
    assert nm.solid(height, options(triangles=lowest, **back)).face_count == int(lowest)


@pytest.mark.parametrize("back", [HOLLOW, SHELL], ids=str)
def test_a_raised_motif_stands_on_a_curved_back(back):
    solid = nm.solid(raised_plate(block()), options(**back))
    check_solid(solid)
    for limit in ({"max_error": "0.1mm"}, {"triangles": "5k"}):
        name, kind = next(iter(limit)), "shell" if "shell" in back else "hollow"
        with pytest.raises(nm.UsageError, match=f"`{name}` and `{kind}` do not go together with a raised motif"):
            nm.solid(raised_plate(block()), options(**limit, **back))


def disc_coverage(radius, x=50.3, y=61.2):
    row, col = np.mgrid[:100, :100]
    return np.clip(radius + 0.5 - np.hypot(col + 0.5 - x, row + 0.5 - y), 0, 1).astype(np.float32)


def test_a_raised_motif_has_a_smooth_outline():
    coverage = disc_coverage(14.0)
    mask = coverage > 0.5
    relief = nm.Relief(raised_plate(mask), mask, PLATE, coverage)
    smooth = nm.solid(relief, options(base="2mm"))
    check_solid(smooth)
    area = plate(RINGS, 0.0, 100, 100).outline.area_mm2
    assert smooth.volume_mm3 - 2 * area == pytest.approx(1.5 * np.pi * 1.4**2, rel=5e-3)
    assert smooth.facts["outline"] == "curve"
    assert 0.01 < smooth.facts["outline_deviation_mm"] < 0.07
    exact = nm.solid(relief, options(base="2mm", outline="exact"))
    assert exact.facts["outline_deviation_mm"] == 0


@pytest.mark.parametrize("radius", [14.0, 39.0, 60.0])
@pytest.mark.parametrize("given", [{}, {"max_error": "0.01mm"}], ids=str)
def test_foot_lines_move_also_where_a_motif_runs_across_the_outline(radius, given):
    coverage = disc_coverage(radius)
    mask = coverage > 0.5
    row, col = np.mgrid[:101, :101]
    z_mm = np.maximum(0.0, 1.0 - ((col - 50.3) ** 2 + (row - 61.2) ** 2) / radius**2)
    for given_back in ({"base": "2mm"}, {"shell": "0.6mm"}, {"base": "2mm", "hollow": "0.5mm"}):
        relief = nm.Relief(plate(RINGS, z_mm, 100, 100), mask, PLATE, coverage)
        solid = nm.solid(relief, options(**given_back, **given))
        check_solid(solid)
        assert solid.facts["outline_deviation_mm"] > (0.01 if radius < 60 else -1)


def test_a_raised_motif_beside_the_outline_is_refused():
    mask = np.zeros((100, 100), bool)
    mask[40:60, 5:30] = True
    message = "the raised motif comes nearer than about 2 px to the outline of its plate, at [0-9]+ px; use a larger"
    with pytest.raises(nm.InputError, match=message):
        nm.solid(raised_plate(mask), options(base="2mm"))


@pytest.mark.parametrize("ending", [".stl", ".ply", ".obj", ".glb", ".3mf"])
@pytest.mark.parametrize("back", [{"base": "2mm"}, {"shell": "0.6mm"}], ids=str)
def test_files_of_plates_pass_their_check_and_other_programs(ending, back, tmp_path):
    rings = [circle(105.03, 5.04, 4.2, 5000), circle(105.5, 7.1, 0.8, 900, is_hole=True)]
    solid, path = nm.solid(plate(rings, waves, 100, 1100), options(**back)), tmp_path / f"a{ending}"
    write_solid(solid, path)
    if ending in (".stl", ".ply"):
        shape = trimesh.load(path, process=True)
        assert shape.is_watertight
        assert shape.volume == pytest.approx(solid.volume_mm3, rel=1e-5)
        mesh = manifold3d.Mesh(np.asarray(shape.vertices, np.float32), np.asarray(shape.faces, np.uint32))
        assert manifold3d.Manifold(mesh).volume() == pytest.approx(solid.volume_mm3, rel=1e-5)


def test_corners_that_files_cannot_keep_apart_are_joined(tmp_path):
    ring = circle(X0, Y0, 4.2, 300)
    doubled = np.repeat(ring, 3, axis=0)
    doubled[1::3] += 3e-6
    doubled[2::3] -= 1e-6
    solid = nm.solid(plate([doubled], 1.0, 100, 100), options(base="2mm"))
    assert solid.face_count == nm.solid(plate([ring], 1.0, 100, 100), options(base="2mm")).face_count
    write_solid(solid, tmp_path / "a.stl")


def test_the_curve_is_described():
    solid = nm.solid(plate(RINGS, 1.0, 100, 100, tolerance_mm=0.002), options(base="2mm"))
    lines = list(describe_solid(solid))
    area = plate(RINGS, 1.0, 100, 100).outline.area_mm2
    assert f"the outline follows its curve within 0.002 mm and encloses {area:.5g} mm2" in lines
    assert solid.to_dict()["outline_tolerance_mm"] == 0.002


REFUSED = {
    "the outline has 2 outer rings, which run counter-clockwise": [circle(2.5, 5, 2, 30), circle(7.5, 5, 2, 30)],
    "the outline has 0 outer rings": [circle(5, 5, 2, 30, is_hole=True)],
    "the outline lies 0.5 mm outside of the heights, which are 10 x 10 mm": [np.array([(1, 1), (10.5, 1), (5, 9.0)])],
    "the outline crosses itself": [np.array([(1, 1), (9, 1), (4, 9), (6, 9.0)])],
    "the outline crosses or touches itself near x =": [circle(5, 5, 3, 90), circle(7.99, 5, 0.03, 30, is_hole=True)],
    "the outline touches itself at x = 5 mm, y = 5 mm": [np.array([(1, 1), (5, 5), (9, 1), (9, 9), (5, 5), (1, 9.0)])],
    "a ring of the outline is smaller than 1e-05 mm": [circle(5, 5, 3, 90), circle(5, 5, 1e-6, 5, is_hole=True)],
}


@pytest.mark.parametrize("message", REFUSED)
def test_outlines_that_are_not_one_plate_are_refused(message):
    with pytest.raises(nm.InputError, match=message):
        nm.solid(plate(REFUSED[message], 0.0, 100, 100), options(base="2mm"))


def test_an_outline_that_is_not_that_of_the_heights_is_refused():
    height = plate(RINGS, 0.0, 100, 100)
    message = (
        "the outline is not that of the heights: [0-9]+ px of their domain lie outside of it, or the other way round"
    )
    for rings in ([circle(X0, Y0, 3.7, 300)], [circle(X0, Y0, 4.6, 300)]):
        other = dataclasses.replace(height, outline=plate(rings, 0.0, 100, 100).outline)
        with pytest.raises(nm.InputError, match=message):
            nm.solid(other, options(base="2mm"))


def test_a_base_thinner_than_the_plate_is_deep_is_refused():
    with pytest.raises(nm.InputError, match=r"`base='1mm'`: the relief reaches 1.5 mm below height 0"):
        nm.solid(plate(RINGS, -1.5, 100, 100), options(base="1mm"))
