"""Heights at the pixel corners: files restore heights and surface exactly."""

import numpy as np
import pytest
from relief_cases import dome, solve

import nmaptool as nm
from nmaptool.core.grid import touching_vertices
from nmaptool.io.pictures.height_samples import to_vertices
from nmaptool.io.pictures.heights import write_height
from nmaptool.io.pictures.writer import write_image

ROWS, COLS = 24, 31
EXACT = [".npy", ".exr", ".tif"]


def everywhere():
    return np.ones((ROWS, COLS), bool)


def with_holes():
    """A domain with a one-pixel hole, a slit and a checkerboard, reaching the image edge."""
    domain = everywhere()
    domain[5, 7] = False
    domain[10, 3:20] = False
    domain[14:18, 22:26] = np.indices((4, 4)).sum(axis=0) % 2 == 0
    domain[:, 0] = False
    domain[-1, 12:] = False
    return domain


def rough(domain):
    z = np.random.default_rng(8).normal(2, 1, (ROWS + 1, COLS + 1))
    return nm.Height(np.where(touching_vertices(domain), z, 0), domain, nm.Frame(ROWS, COLS, 0.4))


@pytest.mark.parametrize("ending", EXACT)
@pytest.mark.parametrize("domain", [everywhere(), with_holes()])
def test_corner_heights_are_read_back_exactly(tmp_path, ending, domain):
    height, path = rough(domain), tmp_path / f"h{ending}"
    write_height(height, path, {}, at="corners")
    back = nm.read_height(path, pitch_mm=0.4)
    kind = np.float64 if ending == ".npy" else np.float32
    assert np.array_equal(back.z_mm.astype(kind), height.z_mm.astype(kind))
    assert np.array_equal(back.domain, domain)
    assert back.frame == height.frame
    write_height(back, path, {}, at="corners")  # and written once more
    assert np.array_equal(nm.read_height(path, pitch_mm=0.4).z_mm, back.z_mm)


@pytest.mark.parametrize("ending", EXACT)
@pytest.mark.parametrize("background", ["plane", "cut"])
def test_a_relief_is_read_back_exactly(tmp_path, ending, background):
    relief, path = solve(dome(bumps=1)[0], background=background, height=nm.length("4mm")), tmp_path / f"h{ending}"
    nm.write_relief(relief, path, at="corners")
    back = nm.read_height(path, pitch_mm=relief.pitch_mm)
    kind = np.float64 if ending == ".npy" else np.float32
    assert np.array_equal(back.z_mm.astype(kind), relief.z_mm.astype(kind))
    assert np.array_equal(back.domain, relief.height.domain)


@pytest.mark.parametrize("domain", [everywhere(), with_holes()])
def test_corner_heights_in_a_png_are_exact_within_half_a_code(tmp_path, domain):
    height, path = rough(domain), tmp_path / "h.png"
    write_height(height, path, {}, at="corners")
    back = nm.read_height(path)
    low, high = height.range_mm
    assert np.abs(back.z_mm - height.z_mm).max() <= (high - low) / 65535 * 0.501
    assert np.array_equal(back.domain, domain)
    assert back.frame == height.frame


@pytest.mark.parametrize("ending", EXACT)
def test_heights_at_centres_are_the_default_and_not_exact(tmp_path, ending):
    height, path = rough(everywhere()), tmp_path / f"h{ending}"
    write_height(height, path, {})
    back = nm.read_height(path, pitch_mm=0.4)
    stored = height.at_pixels().astype(np.float64 if ending == ".npy" else np.float32)
    assert np.array_equal(back.z_mm, to_vertices(stored.astype(np.float64)))
    assert np.abs(back.z_mm - height.z_mm).max() > 0.1


def test_files_mark_the_corners_that_have_heights(tmp_path):
    height = rough(with_holes())
    write_height(height, tmp_path / "h.exr", {}, at="corners")
    image = nm.read_raster(tmp_path / "h.exr")
    assert image.attributes["at"] == "corners"
    assert image.frame.shape == (ROWS + 1, COLS + 1)
    assert np.array_equal(image.alpha > 0, height.vertex_mask)
    assert np.array_equal(image.alpha[:-1, :-1] == 1, height.domain)
    write_height(height, tmp_path / "h.npy", {}, at="corners")
    records = np.load(tmp_path / "h.npy")
    assert np.array_equal(records["z_mm"], height.z_mm)
    assert np.array_equal(records["inside"][:-1, :-1], height.domain)


def test_corner_heights_give_an_exact_curved_background(tmp_path):
    normals = np.zeros((ROWS, COLS, 3), np.float32)
    normals[..., 2] = 1
    motif = nm.NormalMap(normals, np.ones((ROWS, COLS), np.float32), nm.Frame(ROWS, COLS, 0.4))
    for ending in EXACT:
        height, path = rough(everywhere()), tmp_path / f"ground{ending}"
        write_height(height, path, {}, at="corners")
        ground = nm.read_surface(path, like=motif, pitch_mm=0.4)
        assert isinstance(ground, nm.Height)
        assert np.abs(ground.z_mm - height.z_mm).max() <= (0 if ending == ".npy" else 4e-7)
    write_height(rough(with_holes()), tmp_path / "holes.exr", {}, at="corners")
    ground = nm.read_surface(tmp_path / "holes.exr", like=motif, pitch_mm=0.4)
    with pytest.raises(nm.InputError, match="the curved background has holes; it must be defined everywhere"):
        nm.relief(motif, surface=ground, options=nm.ReliefOptions(background="surface"))


def test_wrong_options_and_damaged_files_are_named(tmp_path):
    height = rough(everywhere())
    with pytest.raises(nm.UsageError, match="`at='middle'`: use one of centers, corners"):
        write_height(height, tmp_path / "h.exr", {}, at="middle")
    with pytest.raises(nm.UsageError, match="`at='edges'`: use one of centers, corners"):
        nm.write_relief(nm.Relief(height, everywhere(), None), tmp_path / "h.stl", at="edges")
    assert not list(tmp_path.iterdir())
    said = {"kind": "height", "pitch_mm": "1"}
    values = np.zeros((5, 4, 1), np.float32)
    write_image(values, tmp_path / "edges.exr", ("Y",), {**said, "at": "edges"})
    write_image(values[:1], tmp_path / "row.exr", ("Y",), {**said, "at": "corners"})
    write_image(values * np.float32(np.nan), tmp_path / "nan.exr", ("Y",), {**said, "at": "corners"})
    np.save(tmp_path / "other.npy", np.zeros((3, 4), [("z", "f8"), ("inside", "?")]))
    np.save(tmp_path / "text.npy", np.zeros((3, 4), [("z_mm", "S3"), ("inside", "?")]))
    for name, message in {
        "edges.exr": r"edges\.exr: declares heights at 'edges'; accepted values are centers and corners",
        "row.exr": r"row\.exr: holds heights at 4 x 1 corners; at least 2 x 2 are needed",
        "nan.exr": r"nan\.exr: holds NaN or infinite heights",
        "other.npy": r"other\.npy: must hold one \(rows, columns\) array of heights in mm",
        "text.npy": r"text\.npy: must hold one \(rows, columns\) array of heights in mm",
    }.items():
        with pytest.raises(nm.InputError, match=message):
            nm.read_height(tmp_path / name, pitch_mm=1.0)


def test_the_flag_at_corners_writes_corner_heights(run, refused, tmp_path, clean_map):
    same = ("relief", clean_map, "--width", "40mm", "--height", "4mm")
    files = [tmp_path / f"z{ending}" for ending in (*EXACT, ".png")]
    outputs = [word for path in (*files, tmp_path / "m.ply") for word in ("-o", path)]
    assert run(*same, *outputs, "--at", "corners").code == 0
    assert run(*same, "-o", tmp_path / "plain.ply").code == 0
    assert (tmp_path / "m.ply").read_bytes() == (tmp_path / "plain.ply").read_bytes()
    heights = [nm.read_height(path, pitch_mm=40 / 96) for path in files]
    exact = heights[0]
    assert exact.z_mm.shape == (97, 97)
    assert np.ptp(exact.z_mm) == pytest.approx(4, abs=1e-6)
    for height in heights[1:3]:
        assert np.array_equal(height.z_mm.astype(np.float32), exact.z_mm.astype(np.float32))
    assert np.abs(heights[3].z_mm - exact.z_mm).max() <= 4 / 65535
    refused(2, r"middle", *same, "-o", tmp_path / "x.exr", "--at", "middle")
