"""Plates with exact outlines in parts: closed, with the same vertices on both sides of every cut."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from part_cases import along
from solid_cases import circle, options, plate, random_plate

import nmaptool as nm
from nmaptool.solids.cutting.clip import split


def parts_of(height, counts, given, origin="whole"):
    wanted = nm.PartOptions(parts=counts, part_origin=origin)
    return {(row, col): part for row, col, part in nm.parts(height, wanted, given)}


def check_closed(part: nm.Solid) -> None:
    """Closed, consistently wound, also in single precision, and as large as it says."""
    mesh = part.to_mesh()
    assert len(mesh.faces) == part.face_count
    shape = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert shape.is_watertight
    assert shape.is_winding_consistent
    assert shape.volume == pytest.approx(part.volume_mm3, rel=1e-9)
    assert trimesh.Trimesh(mesh.vertices.astype(np.float32), mesh.faces, process=True).is_watertight
    assert np.array_equal(shape.bounds, part.bounds_mm)


def test_random_plates_in_parts_are_closed_and_fill_the_whole(trials):
    for seed in range(trials(100)):
        height = random_plate(seed)
        px, (rows, cols) = height.pitch_mm, height.frame.shape
        thick = {"base": f"{40 * px}mm"}
        backs = (thick, {"shell": f"{3 * px}mm"}, {}, {**thick, "max_error": f"{px / 2}mm"})
        given = options(**backs[seed % 4])
        try:
            whole = nm.solid(height, given)
        except nm.InputError:  # the base is thinner than the relief is deep
            continue
        rng = np.random.default_rng([seed, 5])
        counts = f"{rng.integers(1, min(cols, 5) + 1)}x{rng.integers(1, min(rows, 5) + 1)}"
        parts = parts_of(height, counts, given, ["whole", "own"][seed % 2])
        if given.is_closed:
            for part in parts.values():
                check_closed(part)
            assert sum(part.volume_mm3 for part in parts.values()) == pytest.approx(whole.volume_mm3, rel=2e-4), seed


def test_the_parts_of_a_round_plate_have_its_volume_and_share_their_cuts():
    rings = [circle(8, 8, 7.3, 300), circle(8.4, 7.7, 2, 60, is_hole=True)]
    height = plate(rings, lambda x, y: 0.3 * np.sin(x) * np.cos(y), 160, 160)
    for given in (options(base="2mm"), options(shell="0.5mm"), options(base="2mm", triangles="6k")):
        whole, parts = nm.solid(height, given), parts_of(height, "2x2", given)
        assert len(parts) == 4
        for part in parts.values():
            check_closed(part)
            assert part.facts["outline"] == "curve"
        assert sum(part.volume_mm3 for part in parts.values()) == pytest.approx(whole.volume_mm3, rel=2e-6)
        for row in range(2):
            shared = along(parts[row, 0], 0, 8.0)
            assert len(shared) > 20
            assert shared == along(parts[row, 1], 0, 8.0)
        for col in range(2):
            assert along(parts[0, col], 1, 8.0) == along(parts[1, col], 1, 8.0)
        assert all((part.bounds_mm[1, :2] - part.bounds_mm[0, :2] <= 8).all() for part in parts.values())


def test_the_parts_of_a_coin_with_a_raised_motif_and_letters_are_closed():
    y, x = np.mgrid[1:-1:96j, -1:1:96j]
    normal_map = nm.NormalMap.from_array(np.dstack([x, y, np.ones_like(x)]), np.hypot(x, y) < 0.9, 0.5, "dome")
    design = nm.PlateDesign(nm.PlateOptions(shape="round"), nm.FrameOptions(frame="2mm"))
    for edge in ("blend", "wall"):
        chosen = nm.ReliefOptions(
            height=nm.length("2mm"), edge=edge, edge_height=nm.length("1mm") if edge == "wall" else None
        )
        relief = nm.plate(normal_map, design=design, options=chosen)
        given = options(base="2mm")
        whole, parts = nm.solid(relief, given), parts_of(relief, "3x2", given)
        for part in parts.values():
            check_closed(part)
        assert sum(part.volume_mm3 for part in parts.values()) == pytest.approx(whole.volume_mm3, rel=1e-4)


def test_an_open_plate_is_cut_without_walls():
    height = plate([circle(4, 4, 3.5, 100)], 1.0, 80, 80)
    parts = parts_of(height, "2x2", None)
    assert not any(part.is_closed for part in parts.values())
    area = sum(trimesh.Trimesh(*_arrays(part), process=False).area for part in parts.values())
    assert area == pytest.approx(height.outline.area_mm2, rel=1e-6)


def _arrays(part):
    mesh = part.to_mesh()
    return mesh.vertices, mesh.faces


def test_parts_of_a_plate_can_have_their_own_origin_and_pieces():
    rings = [np.array([[0.55, 0.55], [5.45, 0.55], [5.45, 5.45], [0.55, 5.45]])]
    rings.append(np.array([[1.55, 1.55], [1.55, 4.45], [4.45, 4.45], [4.45, 1.55]]))
    height = plate(rings, 1.0, 60, 60)
    own = parts_of(height, "1x3", options(base="1mm"), "own")
    assert [len(part.bodies) for part in own.values()] == [1, 2, 1]
    assert own[0, 0].bounds_mm[0].min() >= -1
    assert own[0, 0].bounds_mm[:, :2] == pytest.approx(np.array([[0, 0], [4.9, 4.9 / 3]]), abs=2e-4)
    with pytest.raises(nm.InputError, match="`one_piece`: part 1, 0 has 2 separate pieces"):
        parts_of(height, "1x3", options(base="1mm", one_piece=True))
    assert len(parts_of(height, "1x1", options(base="1mm", one_piece=True))) == 1


def test_a_plate_that_is_a_whole_number_of_parts_wide_is_cut_into_that_many():
    height = plate([circle(7, 7, 6, 400)], 1.0, 140, 140)
    for part, count in (("6mm", 4), ("5.9mm", 9), ("12mm", 1), ("11.9mm x 12.1mm", 2)):
        made = list(nm.parts(height, nm.PartOptions(part=part), options(base="1mm")))
        assert len(made) == count
        sizes = np.array([solid.size_mm[:2] for *_, solid in made])
        assert (sizes.max(axis=0) <= float(part.split("mm")[0]) + 0.2001 * ("x" in part) + 1e-4).all()


def test_a_plate_is_not_hollowed_and_cut():
    height = plate([circle(4, 4, 3.5, 100)], 1.0, 80, 80)
    with pytest.raises(nm.UsageError, match="`hollow='1mm'`: parts of a plate with an exact outline would be open"):
        parts_of(height, "2x2", options(base="3mm", hollow="1mm"))


def test_a_plate_that_would_touch_itself_on_a_cut_is_refused():
    notched = np.array([[0.5, 0.5], [5.5, 0.5], [5.5, 2.5], [3, 3], [5.5, 3.5], [5.5, 5.5], [0.5, 5.5]])
    height = plate([notched], 1.0, 60, 60)
    with pytest.raises(nm.InputError, match="cannot be cut at x = 3 mm, where its section touches itself near y = 3"):
        parts_of(height, "2x1", options(base="1mm"))
    for part in parts_of(height, "3x1", options(base="1mm")).values():
        check_closed(part)


def test_vertices_beside_a_cut_keep_away_from_it():
    box = trimesh.creation.box((2, 2, 2))
    box.apply_translation((1.0005, 0, 0))
    vertices, below, above = split(np.array(box.vertices), np.array(box.faces, np.int64), 0, 0.0, 1e-2, is_closed=True)
    assert len(below) == 0
    assert vertices[:, 0].min() == 1e-2
    assert len(above) == 12
