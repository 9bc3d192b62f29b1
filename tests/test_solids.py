"""Closed solids: manifold on every mask, exactly as large as asked for, with the volume of the heights."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from solid_cases import HARD_MASKS, PLATE, check_solid, crossings, mask_of, random_options, random_relief

import nmaptool as nm
from nmaptool.solids.flat_back import rectangles_of


def relief_of(mask, z_mm=None, coverage=None, pitch_mm=0.5, report=PLATE):
    mask = np.asarray(mask, bool)
    rows, cols = mask.shape
    z_mm = np.full((rows + 1, cols + 1), 1.0) if z_mm is None else z_mm
    height = nm.Height(z_mm, mask, nm.Frame(rows, cols, pitch_mm=pitch_mm))
    return nm.Relief(height, mask, report, coverage)


def options(**values):
    return nm.SolidOptions(
        **{name: nm.length(v) if name in ("base", "shell", "hollow") else v for name, v in values.items()}
    )


@pytest.mark.parametrize("outline", ["exact", "smooth"])
@pytest.mark.parametrize("back", [{"base": "2mm"}, {"base": "2mm", "hollow": "0.6mm"}, {"shell": "0.8mm"}], ids=str)
@pytest.mark.parametrize("name", HARD_MASKS)
def test_every_hard_mask_gives_a_manifold_solid(name, back, outline):
    mask = mask_of(HARD_MASKS[name])
    z_mm = np.add.outer(np.arange(mask.shape[0] + 1) * 0.1, np.arange(mask.shape[1] + 1) * 0.07)
    check_solid(nm.solid(relief_of(mask, z_mm), options(outline=outline, **back)))


def test_random_masks_give_manifold_solids(trials):
    for seed in range(trials(300)):
        check_solid(nm.solid(random_relief(seed), random_options(seed)))


def test_a_box_has_the_size_and_volume_asked_for():
    solid = nm.solid(relief_of(np.ones((6, 8))), options(base="2mm"))
    assert solid.bounds_mm.tolist() == [[0, 0, -2], [4, 3, 1]]
    assert solid.volume_mm3 == pytest.approx(36, abs=1e-12)
    assert solid.size_mm == (4, 3, 3)


def test_a_flat_back_of_a_plate_needs_as_many_triangles_as_its_outline_has_edges():
    solid = nm.solid(relief_of(np.ones((6, 8))), options(base="2mm"))
    edges = 2 * (6 + 8)
    assert solid.face_count == 2 * 6 * 8 + 2 * edges + edges


def test_the_base_is_measured_from_the_lowest_point_where_there_is_no_plate():
    z_mm = np.linspace(3, 5, 9 * 7).reshape(9, 7)
    for background, lowest in (("plane", -2.0), ("cut", 1.0), ("free", 1.0), ("surface", 1.0)):
        report = dataclasses.replace(PLATE_REPORT, options=nm.ReliefOptions(background=background))
        solid = nm.solid(relief_of(np.ones((8, 6)), z_mm, report=report), options(base="2mm"))
        assert solid.bounds_mm[:, 2].tolist() == pytest.approx([lowest, 5.0])


@dataclasses.dataclass
class Report:
    options: nm.ReliefOptions


PLATE_REPORT = Report(nm.ReliefOptions())


def test_islands_become_bodies_and_can_be_refused():
    mask = mask_of(HARD_MASKS["hole and island"])
    solid = nm.solid(relief_of(mask), options(base="1mm"))
    assert [body.name for body in solid.bodies] == ["relief 1", "relief 2"]
    assert solid.facts["pieces"] == 2
    with pytest.raises(
        nm.InputError,
        match="`one_piece`: the relief has 2 separate pieces, the largest of 16 px and the smallest of 1 px",
    ):
        nm.solid(relief_of(mask), options(base="1mm", one_piece=True))


def test_a_base_thinner_than_an_engraving_is_refused_with_a_base_that_works():
    z_mm = np.zeros((5, 5))
    z_mm[2, 2] = -2.25
    message = (
        "`base='2mm'`: the relief reaches 2.25 mm below height 0, so its base must be thicker, such as `base='3.2mm'`"
    )
    with pytest.raises(nm.InputError, match=message):
        nm.solid(relief_of(np.ones((4, 4)), z_mm), options(base="2mm"))
    check_solid(nm.solid(relief_of(np.ones((4, 4)), z_mm), options(base="3.2mm")))


def test_a_shell_is_at_least_as_thick_as_asked_for_square_to_its_surface():
    y, x = np.mgrid[-20:21, -20:21] * 0.5
    z_mm = np.sqrt(np.maximum(14.0**2 - x**2 - y**2, 1.0))
    solid = nm.solid(relief_of(np.ones((40, 40)), z_mm), options(shell="1.5mm"))
    check_solid(solid)
    mesh = solid.to_mesh()
    front, back = mesh.vertices[: 41 * 41], mesh.vertices[41 * 41 :]
    away = np.linalg.norm(front[:, None] - back[None], axis=2).min(axis=0)
    assert away.min() == pytest.approx(1.5, abs=0.02)
    assert away.max() < 2.5


def test_a_hollow_solid_keeps_its_walls_and_its_footing():
    z_mm = np.full((41, 41), 6.0)
    full = nm.solid(relief_of(np.ones((40, 40)), z_mm), options(base="2mm"))
    hollow = nm.solid(relief_of(np.ones((40, 40)), z_mm), options(base="2mm", hollow="1.5mm"))
    check_solid(hollow)
    assert hollow.bounds_mm.tolist() == full.bounds_mm.tolist()
    # a pocket of 8 - 1.5 mm; its side, one pixel wide, begins between 1.5 and 2.5 mm from the outline
    low, high = (20 - 2 * 3.0) ** 2 * 6.5, (20 - 2 * 1.5) ** 2 * 6.5
    assert low <= full.volume_mm3 - hollow.volume_mm3 <= high
    floor = hollow.to_mesh().vertices
    inner = floor[(np.abs(floor[:, :2] - 10) < 6).all(axis=1) & (floor[:, 2] < 5)]
    assert inner[:, 2] == pytest.approx(4.5)


def test_an_open_surface_is_that_of_surface_mesh():
    rng = np.random.default_rng(3)
    relief = relief_of(rng.random((9, 7)) > 0.2, rng.random((10, 8)))
    solid = nm.solid(relief, options(outline="exact"))
    assert not solid.is_closed
    assert np.isnan(solid.volume_mm3)
    ours, theirs = (mesh.vertices[mesh.faces].mean(axis=1) for mesh in (solid.to_mesh(), nm.surface_mesh(relief)))
    # vertices where pixels touch at a corner are drawn apart by a hundredth of a pixel
    assert np.sort(ours[:, 2]) == pytest.approx(np.sort(theirs[:, 2]), abs=1e-12)
    assert len(ours) == len(theirs)


def test_rectangles_tile_a_mask():
    rng = np.random.default_rng(5)
    for share in (0.2, 0.5, 0.9):
        mask = rng.random((23, 17)) < share
        found = rectangles_of(mask)
        painted = np.zeros(mask.shape, int)
        for left, right, top, bottom in zip(found.left, found.right, found.top, found.bottom, strict=True):
            painted[top:bottom, left:right] += 1
        assert np.array_equal(painted, mask.astype(int))
        rows, cols = np.nonzero(mask)
        of = found.of_pixels(rows, cols)
        assert ((found.left[of] <= cols) & (cols < found.right[of])).all()
        assert ((found.top[of] <= rows) & (rows < found.bottom[of])).all()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"base": "2mm", "shell": "1mm"}, "`base` and `shell` are two kinds of back; give one of them"),
        ({"hollow": "1mm"}, "`hollow='1mm'`: needs `base`, such as `base='3mm'`"),
    ],
)
def test_options_that_contradict_each_other_are_refused(values, message):
    with pytest.raises(nm.UsageError, match=message):
        options(**values)


def test_both_limits_of_triangles_are_refused():
    with pytest.raises(nm.UsageError, match="`max_error` and `triangles` both set how many triangles remain"):
        nm.SolidOptions(max_error=nm.length("0.1mm"), triangles="20k")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("many", "`triangles='many'`: expected a whole number, such as 200k or 1500000"),
        ("1.2345k", "`triangles='1.2345k'`: expected a whole number"),
        ("12", "`triangles='12'`: must be at least 100, such as 200k"),
    ],
)
def test_bad_numbers_of_triangles_are_refused(text, message):
    with pytest.raises(nm.UsageError, match=message):
        nm.SolidOptions(triangles=text)


def test_numbers_of_triangles_are_read():
    counts = [nm.SolidOptions(triangles=text).triangle_count for text in ("200k", "1.5M", "1234", 900)]
    assert counts == [200_000, 1_500_000, 1234, 900]


def test_triangles_that_cross_are_found():
    flat = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0]], float)
    upright = np.array([[0.5, 0.5, -1], [0.5, 0.5, 1], [3, 3, 0]], float)
    faces = np.arange(6).reshape(2, 3)
    assert crossings(np.concatenate([flat, upright]), faces) == 1
    assert crossings(np.concatenate([flat, upright + 5]), faces) == 0
    assert crossings(np.concatenate([flat, flat + np.array([0.5, 0.2, 0])]), faces) == 1  # in one plane
    beside = np.array([[2, 0, 0], [0, 2, 0], [2, 2, 1]], float)
    assert crossings(np.concatenate([flat, beside]), faces) == 0  # only an edge in common


def test_no_triangles_of_a_solid_cross(trials):
    checked = 0
    for seed in range(trials(300)):
        relief, given = random_relief(seed), random_options(seed)
        if relief.height.domain.size < 220:
            mesh = nm.solid(relief, given).to_mesh()
            assert crossings(mesh.vertices, mesh.faces) == 0, seed
            checked += 1
    assert checked >= trials(300) // 10


def test_no_triangles_cross_behind_a_foot_line(trials):
    for seed in range(1, trials(100), 2):  # with coverage
        relief = random_relief(seed)
        if relief.height.domain.size < 220:
            height = dataclasses.replace(relief.height, domain=np.ones_like(relief.height.domain))
            given = options(**({"base": "3mm"}, {"base": "3mm", "hollow": "0.5mm"}, {"shell": "0.4mm"})[seed % 3])
            mesh = nm.solid(dataclasses.replace(relief, height=height), given).to_mesh()
            assert crossings(mesh.vertices, mesh.faces) == 0, seed
