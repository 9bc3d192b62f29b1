"""Written heights, meshes, previews and reports, read back by independent readers."""

import itertools
import json

import cv2
import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own documentation's name
import pytest
import trimesh

import nmaptool as nm
from nmaptool.core.errors import InputError, OutputError, UsageError
from nmaptool.core.grid import corner_mean, height_slopes, touching_vertices
from nmaptool.core.vectors import unit
from nmaptool.figures.lambert import lambert

ROWS, COLS = 40, 56
MESHES = [".stl", ".ply", ".obj", ".glb"]
FLOATS = [".exr", ".tif", ".npy"]


def dome_map():
    row, col = np.mgrid[0 : ROWS + 1, 0 : COLS + 1]
    p, q = height_slopes(9 * np.exp(-((col - 28) ** 2 + (row - 20) ** 2) / 90))
    disc = np.hypot(*(np.mgrid[0:ROWS, 0:COLS] + 0.5 - np.array([20, 28])[:, None, None])) < 15
    normals = unit(np.stack([-p, -q, np.ones_like(p)], axis=-1))
    normals[~disc] = (0, 0, 1)
    return nm.NormalMap(normals, disc.astype(np.float32), nm.Frame(ROWS, COLS))


@pytest.fixture(scope="module", params=["plane", "cut"])
def carved(request):
    options = nm.ReliefOptions(height=nm.length("4mm"), width=nm.length("80mm"), background=request.param)
    return nm.relief(dome_map(), options=options)


def open_picture(path):
    source = oiio.ImageInput.open(str(path))
    spec = source.spec()
    return source.read_image(oiio.UNKNOWN), spec, {a.name: a.value for a in spec.extra_attribs}


@pytest.mark.parametrize("ending", FLOATS)
def test_float_heights_are_mm_at_pixel_centres(carved, tmp_path, ending):
    path = tmp_path / f"h{ending}"
    nm.write_relief(carved, path)
    expected = corner_mean(carved.z_mm)
    if ending == ".npy":
        found = np.load(path)
        assert np.array_equal(np.isnan(found), ~carved.mask)
    else:
        pixels, spec, _ = open_picture(path)
        found = pixels[..., 0]
        assert spec.nchannels == (1 if carved.mask.all() else 2)
        if not carved.mask.all():
            assert np.array_equal(pixels[..., 1], carved.mask.astype(np.float32))
            assert not found[~carved.mask].any()
    assert np.abs((found - expected)[carved.mask]).max() < 1e-6


def test_png_heights_are_16_bit_with_their_range_in_mm(carved, tmp_path):
    path = tmp_path / "h.png"
    nm.write_relief(carved, path)
    pixels = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    _, _, text = open_picture(path)
    assert pixels.dtype == np.uint16
    grey = pixels if pixels.ndim == 2 else pixels[..., 0]
    low, high = float(text["nmaptool:height_min_mm"]), float(text["nmaptool:height_max_mm"])
    found = low + grey / 65535 * (high - low)
    inside = carved.mask
    assert np.abs(found - corner_mean(carved.z_mm))[inside].max() <= (high - low) / 65535 / 2 * 1.001
    assert high - low == pytest.approx(4, abs=1e-6)  # black to white spans the requested height
    assert np.ptp(grey[inside]) > 60000


@pytest.mark.parametrize("ending", [".exr", ".png", ".tif"])
def test_images_have_metadata(carved, tmp_path, ending):
    path = tmp_path / f"h{ending}"
    nm.write_relief(carved, path)
    own = nm.read_raster(path).attributes
    assert own["kind"] == "height"
    assert own["unit"] == "mm"
    assert float(own["pitch_mm"]) == 80 / COLS
    assert own["version"] == nm.__version__
    assert json.loads(own["options"])["height"] == "4mm"
    assert nm.read_raster(path).color_chunks == ()


@pytest.mark.parametrize("ending", MESHES)
def test_meshes_have_the_exact_size_and_face_outwards(carved, tmp_path, ending):
    path = tmp_path / f"m{ending}"
    nm.write_relief(carved, path)
    mesh = trimesh.load(path, force="mesh")
    if ending == ".glb":  # in metres, as its specification requires
        assert nm.read_mesh(path).mm_per_unit == 1000
        mesh.apply_scale(1000)
    rows, cols = np.nonzero(touching_vertices(carved.mask))
    pitch = 80 / COLS
    expected = [(cols.min() * pitch, cols.max() * pitch), ((ROWS - rows.max()) * pitch, (ROWS - rows.min()) * pitch)]
    assert np.allclose(mesh.bounds[:, :2].T, expected, atol=1e-5)
    assert mesh.extents[2] == pytest.approx(4, abs=1e-6)
    assert len(mesh.faces) == 2 * carved.mask.sum()
    assert (mesh.face_normals[:, 2] > 0).all()
    assert mesh.area_faces.min() > 0


def test_mesh_heights_match_the_relief_and_its_orientation(carved, tmp_path):
    nm.write_relief(carved, tmp_path / "m.ply")
    mesh = trimesh.load(tmp_path / "m.ply", process=False)
    pitch = carved.pitch_mm
    col, row = np.rint(mesh.vertices[:, 0] / pitch).astype(int), ROWS - np.rint(mesh.vertices[:, 1] / pitch).astype(int)
    assert np.abs(mesh.vertices[:, 2] - carved.z_mm[row, col]).max() < 1e-5
    assert len(mesh.vertices) == touching_vertices(carved.mask).sum()


def test_the_mesh_outline_follows_the_mask():
    mask = np.zeros((6, 7), bool)
    mask[1:4, 2:6] = True
    mask[2, 3] = False
    mesh = nm.surface_mesh(nm.Height(np.zeros((7, 8)), mask, nm.Frame(6, 7, 1.0)))
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    assert (counts == 1).sum() == 2 * (3 + 4) + 4  # edges around the block and around its hole
    assert counts.max() == 2


def test_diagonals_follow_a_ridge():
    z = np.abs(np.subtract.outer(np.arange(6.0), np.arange(6.0)))  # a valley from the upper left to the lower right
    for heights in (z, z[:, ::-1].copy()):
        mesh = nm.surface_mesh(nm.Height(heights, np.ones((5, 5), bool), nm.Frame(5, 5, 1.0)))
        valley = np.flatnonzero(heights.ravel() == 0)
        edges = {tuple(sorted(e)) for e in mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()}
        assert all((a, b) in edges for a, b in itertools.pairwise(valley.tolist()))


def test_the_preview_is_lit_from_the_upper_left(carved, tmp_path):
    nm.write_relief(carved, preview=tmp_path / "p.png")
    picture = cv2.imread(str(tmp_path / "p.png"))
    assert max(picture.shape) >= 900
    light = lambert(carved.height)
    assert light[14, 22] > light[26, 34] + 0.1
    if carved.mask.all():
        plate = light[:4]
        assert np.ptp(plate) < 1e-12
        assert 0.4 < plate[0, 0] < 0.8


def test_the_report_describes_the_run(carved, tmp_path):
    nm.write_relief(carved, report=tmp_path / "r.json")
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert report["height_range_mm"] == pytest.approx(4)
    assert report["options"]["width"] == "80mm"
    assert report["residual"] <= 1e-8
    assert len(report["history"]) == report["iterations"]


def test_all_files_appear_or_none(carved, tmp_path, monkeypatch):
    targets = [tmp_path / "a.exr", tmp_path / "a.stl"]

    def fail(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("nmaptool.io.solids.stl._records", fail)
    with pytest.raises(OutputError, match=r"a.stl: cannot be written \(No space left on device\)"):
        nm.write_relief(carved, *targets)
    assert list(tmp_path.iterdir()) == []


def test_existing_files_are_kept_without_overwrite(carved, tmp_path):
    path = tmp_path / "a.npy"
    path.write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match="already exists; give another name, or `overwrite`"):
        nm.write_relief(carved, tmp_path / "b.npy", path)
    assert path.read_text(encoding="utf-8") == "mine"
    assert not (tmp_path / "b.npy").exists()
    nm.write_relief(carved, path, overwrite=True)
    assert np.load(path).shape == (ROWS, COLS)


def test_a_file_that_appears_meanwhile_is_not_replaced(carved, tmp_path, monkeypatch):
    path = tmp_path / "a.stl"
    written = nm.solid

    def late(relief):
        path.write_text("another program's", encoding="utf-8")
        return written(relief)

    monkeypatch.setattr("nmaptool.solids.solid.solid", late)
    with pytest.raises(OutputError, match="already exists"):
        nm.write_relief(carved, path)
    assert path.read_text(encoding="utf-8") == "another program's"
    assert list(tmp_path.iterdir()) == [path]


def test_endings_are_checked_first(carved, tmp_path):
    with pytest.raises(UsageError, match=r"a.xyz: ends in .xyz; a relief is written as .exr, .tif"):
        nm.write_relief(carved, tmp_path / "a.xyz")
    with pytest.raises(UsageError, match="a: has no ending"):
        nm.write_relief(carved, tmp_path / "a")
    with pytest.raises(UsageError, match=r"a preview is written as \.png"):
        nm.write_relief(carved, preview=tmp_path / "a.jpg")
    with pytest.raises(UsageError, match="is named twice as an output"):
        nm.write_relief(carved, tmp_path / "a.png", preview=tmp_path / "a.png")


@pytest.mark.parametrize("ending", [*FLOATS, ".png"])
def test_heights_are_read_back_as_a_curved_background(tmp_path, ending):
    row, col = np.mgrid[0 : ROWS + 1, 0 : COLS + 1]
    z = 0.1 * col + 0.05 * row  # a plane: its corner heights follow exactly from those at centres
    height = nm.Height(z, np.ones((ROWS, COLS), bool), nm.Frame(ROWS, COLS, 0.5))
    from nmaptool.io.pictures.heights import write_height

    write_height(height, tmp_path / f"h{ending}", {})
    back = nm.read_height(tmp_path / f"h{ending}", pitch_mm=0.5)
    assert np.abs(back.z_mm - z).max() < 3 * np.ptp(z) / 65535
    assert back.pitch_mm == 0.5


def test_bad_height_files_are_named(tmp_path):
    np.save(tmp_path / "three.npy", np.zeros((3, 4, 5)))
    np.save(tmp_path / "nan.npy", np.full((3, 4), np.nan))
    (tmp_path / "text.npy").write_text("no array", encoding="utf-8")
    cv2.imwrite(str(tmp_path / "plain.png"), np.zeros((5, 6), np.uint16))
    for name, message in {
        "three.npy": r"must hold one \(rows, columns\) array",
        "nan.npy": "holds NaN or infinite heights",
        "text.npy": "is not a NumPy array file",
        "plain.png": "does not state its height range in mm",
        "none.npy": "no such file",
    }.items():
        with pytest.raises(InputError, match=message):
            nm.read_height(tmp_path / name, pitch_mm=1.0)


def test_height_checks_its_parts():
    frame, inside = nm.Frame(3, 4, 1.0), np.ones((3, 4), bool)
    good = np.zeros((4, 5))
    for z, domain, size, message in (
        (np.zeros((3, 4)), inside, frame, r"expected float64 \(4, 5\)"),
        (good, np.ones((4, 5), bool), frame, r"expected bool \(3, 4\)"),
        (good, ~inside, frame, "the domain of the height field is empty"),
        (np.full((4, 5), np.nan), inside, frame, "heights must be finite"),
        (good, inside, nm.Frame(3, 4), "needs a pixel size in mm; set pitch_mm of its frame"),
    ):
        with pytest.raises(InputError, match=message):
            nm.Height(z, domain, size)
