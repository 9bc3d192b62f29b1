"""Parts that are made from windows of a relief, and heights that are read by windows."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh
from part_cases import (
    PITCH_MM,
    along,
    area,
    cap,
    height_of,
    plane,
    ramp_with_holes,
    random_counts,
    random_height,
    triangles,
)
from solid_cases import check_solid, options

import nmaptool as nm
from nmaptool.io.stores.height_windows import ArrayHeights, frame_of, height_window, range_of, surface_range
from nmaptool.io.stores.part_files import check_parts, export_parts, part_frame, small_height, write_part
from nmaptool.solids.cutting.cut import part_of
from nmaptool.solids.cutting.whole import PartFrame

SMOOTH = nm.SolidOptions(outline="smooth")


def window_of(height: nm.Height, rows: slice, cols: slice) -> nm.Height | None:
    """A window as a height field, or None if it holds nothing."""
    domain = height.domain[rows, cols]
    z_mm = height.z_mm[rows.start : rows.stop + 1, cols.start : cols.stop + 1]
    raised = None if height.raised is None else height.raised[rows, cols]
    return nm.Height(z_mm, domain, nm.Frame(*domain.shape, PITCH_MM), raised) if domain.any() else None


def from_windows(height, given, counts, origin="whole"):
    parts = nm.PartOptions(parts=counts, part_origin=origin)
    whole = PartFrame(height.frame, *height.range_mm, given, 0.0, origin)
    found = {}
    for part in nm.plan_parts(*height.frame.shape, PITCH_MM, parts):
        window = window_of(height, *whole.window_of(part))
        solid = None if window is None else part_of(window, whole, part)
        if solid is not None:
            found[part.row, part.col] = solid
    return found


@pytest.mark.parametrize("origin", ["whole", "own"])
@pytest.mark.parametrize("back", [{"base": "2mm"}, {"shell": "0.7mm"}, {"base": "2mm", "hollow": "0.5mm"}, {}], ids=str)
def test_a_part_of_a_window_is_the_part_of_the_whole(back, origin):
    height, given = plane(33, 47), options(**back)
    parts = nm.parts(height, nm.PartOptions(parts="3x2", part_origin=origin), given)
    whole = {(row, col): part for row, col, part in parts}
    found = from_windows(height, given, "3x2", origin)
    assert found.keys() == whole.keys()
    for place, part in found.items():
        assert triangles([part]) == triangles([whole[place]])
        assert np.array_equal(part.bounds_mm, whole[place].bounds_mm)


def test_random_windows_are_watertight_and_fill_the_whole(trials):
    thick = {"base": "9mm"}
    backs = (thick, {"shell": "0.35mm"}, {}, {**thick, "max_error": "0.05mm"})
    for seed in range(trials(100)):
        height, given = random_height(seed), options(**backs[seed % len(backs)])
        counts = random_counts(seed, height)
        whole, found = from_windows(height, given, "1x1"), from_windows(height, given, counts)
        for part in found.values():
            if given.is_closed:
                check_solid(part)
        if given.max_error is None:
            assert triangles(found.values()) == triangles(whole.values()), (seed, counts)
            assert area(found.values()) == pytest.approx(area(whole.values()), rel=1e-9)


def stored(height: nm.Height) -> ArrayHeights:
    """Heights at corners, NaN outside the surface."""
    return ArrayHeights(np.where(height.vertex_mask, height.z_mm, np.nan), PITCH_MM, "corners")


@pytest.mark.parametrize("name", ["plane", "cap"])
def test_parts_of_a_store_are_files_that_join_to_the_whole(name, tmp_path):
    height = {"plane": plane, "cap": cap}[name]()
    given = options(base="2mm")
    folder = tmp_path / "parts"
    made = export_parts(
        stored(height),
        folder / "{row}_{col}.stl",
        options=nm.PartOptions(part="4.5mm"),
        solid=given,
        assembly=[tmp_path / "parts.json", tmp_path / "parts.png"],
    )
    meshes = [trimesh.load(folder / part.files[0]) for part in made.parts]
    assert all(mesh.is_watertight for mesh in meshes)
    assert all(max(part.size_mm[:2]) <= 4.5 for part in made.parts)
    # a cap is cut out: its corners belong to single pixels, which a store of corners cannot leave out
    assert sum(mesh.volume for mesh in meshes) == pytest.approx(nm.solid(height, given).volume_mm3, rel=1e-5)
    index = json.loads((tmp_path / "parts.json").read_text())
    assert [entry["files"] for entry in index["parts"]] == [list(part.files) for part in made.parts]
    assert nm.read_raster(tmp_path / "parts.png").frame.longer_side == 1600


def test_heights_at_centres_become_the_same_corners_in_every_window():
    height = ramp_with_holes()
    source = ArrayHeights(height.at_pixels(), PITCH_MM)
    whole = height_window(source, slice(0, 41), slice(0, 53))
    assert whole is not None
    assert np.array_equal(whole.domain, height.domain)
    inside = height.vertex_mask
    assert np.abs(whole.z_mm - height.z_mm)[inside].max() < 1e-12  # exact for a plane, also beside holes
    for top, left in ((0, 0), (5, 20), (20, 30)):
        window = height_window(source, slice(top, top + 20), slice(left, left + 20))
        assert window is not None
        within = slice(top + 1, top + 20), slice(left + 1, left + 20)
        assert np.array_equal(window.z_mm[1:-1, 1:-1], whole.z_mm[within])


def test_a_pixel_of_a_store_is_surface_if_all_its_corners_are():
    z_mm = np.ones((4, 5))
    z_mm[1, 2] = np.nan
    window = height_window(ArrayHeights(z_mm, 1.0, "corners"), slice(0, 3), slice(0, 4))
    assert window is not None
    assert np.argwhere(~window.domain).tolist() == [[0, 1], [0, 2], [1, 1], [1, 2]]
    assert height_window(ArrayHeights(z_mm, 1.0, "corners"), slice(0, 1), slice(1, 2)) is None


def test_the_range_of_a_store_is_that_of_its_surface():
    height = plane()
    low, high = height.range_mm
    found = surface_range(ArrayHeights(height.at_pixels(), PITCH_MM))
    assert (found.low_mm, found.high_mm) == pytest.approx((low, high), abs=1e-12)
    assert range_of(stored(cap())).has_gaps
    with pytest.raises(nm.InputError, match="the heights hold no surface: all of them are NaN"):
        range_of(ArrayHeights(np.full((3, 3), np.nan), 1.0))
    with pytest.raises(nm.InputError, match="the heights hold infinite values; use NaN for what is not surface"):
        range_of(ArrayHeights(np.full((3, 3), np.inf), 1.0))
    alone = np.full((3, 3), np.nan)
    alone[1, 1] = 1
    with pytest.raises(nm.InputError, match="no pixel has heights at all its corners"):
        surface_range(ArrayHeights(alone, 1.0, "corners"))
    with pytest.raises(nm.InputError, match="the heights are 5 x 1 corners; at least 2 x 2 are needed"):
        frame_of(ArrayHeights(np.ones((1, 5)), 1.0, "corners"))


def test_parts_divide_the_box_around_the_surface(tmp_path):
    domain = np.zeros((60, 90), bool)
    domain[20:41, 37:77] = True
    for source in (stored(height_of(np.ones((61, 91)), domain)), ArrayHeights(np.where(domain, 1.0, np.nan), PITCH_MM)):
        assert surface_range(source).box == (slice(20, 41), slice(37, 77))
        made = export_parts(source, tmp_path / "{row}_{col}.stl", options=nm.PartOptions(part="5mm"), overwrite=True)
        assert [part.size_mm[:2] for part in made.parts] == [(5, 2.5), (5, 2.5), (5, 2.75), (5, 2.75)]


def test_a_part_is_not_replaced_and_one_that_holds_nothing_is_not_written(tmp_path):
    domain = np.zeros((20, 30), bool)
    domain[:, :12] = True
    source, given = stored(height_of(np.ones((21, 31)), domain)), nm.PartOptions(parts="2x1")
    whole, plan = part_frame(source, given, options(base="1mm")), nm.plan_parts(20, 30, PITCH_MM, given)
    template = str(tmp_path / "{row}_{col}.ply")
    written = write_part(source, whole, plan[0], [template])
    assert written is not None
    assert (written.files, written.size_mm) == (("0_0.ply",), (3.0, 5.0, 2.0))
    assert write_part(source, whole, plan[1], [template]) is None
    assert [file.name for file in tmp_path.iterdir()] == ["0_0.ply"]
    with pytest.raises(nm.OutputError, match=r"0_0\.ply: already exists"):
        write_part(source, whole, plan[0], [template])


def test_the_picture_of_a_large_map_has_few_pixels():
    rows, cols = 60, 90
    source = ArrayHeights(np.add.outer(np.arange(rows) * 1.0, np.arange(cols) * 0.5), 2.0)
    small = small_height(source, 30)
    assert small is not None
    assert (small.frame.shape, small.pitch_mm) == ((20, 30), 6.0)
    assert np.diff(small.at_pixels(), axis=0) == pytest.approx(np.full((19, 30), 3.0))


def test_a_window_must_fit_its_part():
    height = plane(20, 30)
    whole = PartFrame(height.frame, *height.range_mm)
    part = nm.plan_parts(20, 30, PITCH_MM, nm.PartOptions(parts="2x2"))[3]
    with pytest.raises(
        nm.InputError,
        match=r"the window of part 1, 1 is 30 x 20 px, 0\.25 mm per px; expected 17 x 12 px, 0\.25 mm per px",
    ):
        part_of(height, whole, part)
    smooth = PartFrame(height.frame, *height.range_mm, nm.SolidOptions(outline="smooth"))
    with pytest.raises(nm.UsageError, match="`outline='smooth'`: the parts of a large map follow its pixels"):
        part_of(window_of(height, *smooth.window_of(part)), smooth, part)


def test_the_whole_must_be_known():
    frame = nm.Frame(20, 30, 0.5)
    with pytest.raises(nm.InputError, match="parts need a pixel size in mm; set pitch_mm of the frame of the whole"):
        PartFrame(nm.Frame(20, 30), 0, 1)
    for low, high in ((2, 1), (0, np.nan)):
        with pytest.raises(nm.InputError, match=r"heights of the whole are .* mm; expected"):
            PartFrame(frame, low, high)
    with pytest.raises(nm.InputError, match="`base='2mm'`: the relief reaches 3 mm below height 0"):
        PartFrame(frame, -3, 1, options(base="2mm"))
    assert PartFrame(frame, 0, 1, options(shell="1.2mm")).ring_px == 5
    assert PartFrame(frame, 0, 1, nm.SolidOptions(base=nm.length("10%"))).solid.base == nm.length("1.5mm")


def test_borders_of_windows_agree_bit_by_bit():
    height = random_height(2)
    rows, cols = height.frame.shape
    for given in (options(base="9mm"), options(shell="0.6mm"), options(base="9mm", max_error="0.1mm")):
        left, right = from_windows(height, given, "2x1").values()
        shared = along(left, 0, cols // 2 * PITCH_MM)
        assert len(shared) == 2 * (rows + 1)
        assert shared == along(right, 0, cols // 2 * PITCH_MM)


@pytest.mark.parametrize(
    ("name", "given", "more", "error", "pattern"),
    [
        ("a.stl", {"parts": "2x2"}, {}, nm.UsageError, r"a\.stl: does not name \{row\} and \{col\}"),
        ("{row}_{col}.stl", {}, {}, nm.UsageError, "no parts are asked for"),
        ("{row}_{col}.stl", {"part": "0.1mm"}, {}, nm.InputError, "is smaller than a pixel"),
        ("no/such/{row}_{col}.stl", {"parts": "2x2"}, {}, nm.OutputError, "the folder no does not exist"),
        ("{row}_{col}.stl", {"parts": "2x2"}, {"assembly": ["a.txt"]}, nm.UsageError, r"written as \.json, \.png"),
        (
            "{row}_{col}.stl",
            {"parts": "2x2"},
            {"solid": nm.SolidOptions(outline="smooth")},
            nm.UsageError,
            "follow its",
        ),
    ],
)
def test_wrong_parts_are_refused_before_any_height_is_read(name, given, more, error, pattern, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    class Unread(ArrayHeights):
        def window(self, rows, cols):
            raise AssertionError("read")

    source = Unread(np.ones((20, 30)), PITCH_MM)
    with pytest.raises(error, match=pattern):
        export_parts(source, name, options=nm.PartOptions(**given), **more)
    with pytest.raises(error, match=pattern):
        check_parts(frame_of(source), [name], nm.PartOptions(**given), **more)
    assert list(tmp_path.iterdir()) == []
