"""Layer sets written and read back: the contents and metadata of each file, and what cannot be written."""

import dataclasses
import json

import cv2
import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own documentation's name
import pytest
from bake_cases import plate_mesh
from mesh_files import FACES, VERTICES

import nmaptool as nm
from nmaptool.core.errors import LimitError, OutputError, UsageError
from nmaptool.io.output import layers as layer_files
from nmaptool.types.mesh import Mesh

MAPS = ("original", "base", "detail")
QUICK = {"size": "60x50", "renderer": "numpy"}


@pytest.fixture(scope="module")
def layers():
    return nm.bake(plate_mesh(), nm.BakeOptions(**QUICK))


@pytest.fixture(scope="module", params=["exr", "png"])
def folder(request, layers, tmp_path_factory):
    """A folder with all layers, in either format."""
    out = tmp_path_factory.mktemp("layers") / "maps"
    nm.write_layers(layers, out, format=request.param, depth=True, faces=True)
    return out


def of(folder, name):
    (path,) = folder.glob(f"{name}.[ep][xn][rg]")
    return path


def pixels_of(path):
    source = oiio.ImageInput.open(str(path))
    return source.read_image(oiio.UNKNOWN), source.spec()


@pytest.mark.parametrize("name", MAPS)
def test_maps_are_read_back_unchanged(folder, layers, name):
    path = of(folder, name)
    found, expected = nm.read_normal_map(path), getattr(layers, name)
    assert found.frame == layers.frame
    within = 1e-7 if path.suffix == ".exr" else 1.01 / 65535
    assert np.abs(found.coverage - layers.coverage).max() <= within / 2
    seen = layers.coverage > 0
    assert 0.5 < seen.mean() < 0.9
    assert np.abs(found.normals - expected.normals)[seen].max() <= 2 * within
    assert np.allclose(np.linalg.norm(found.normals[seen], axis=-1), 1, atol=1e-6)
    decoding = found.decoding
    assert (decoding.green, decoding.green_from) == ("up", "file")
    assert decoding.swizzle == "r,g,b"
    assert (found.normals[~seen] == (0, 0, 1)).all()


def test_green_is_up(folder):
    found = nm.read_normal_map(of(folder, "original"))
    upper, lower = found.normals[8, 20:40, 1].mean(), found.normals[-9, 20:40, 1].mean()
    assert upper > 0.1
    assert lower < -0.1


def test_base_and_detail_differ_and_give_the_original(folder, layers):
    original, base, detail = (nm.read_normal_map(of(folder, name)).normals for name in MAPS)
    seen = layers.coverage > 0
    assert np.abs(detail - (0, 0, 1))[seen].max() > 0.2
    t, u = base + np.array([0, 0, 1]), detail * (-1, -1, 1)
    again = t * (t * u).sum(axis=-1, keepdims=True) / t[..., 2:] - u
    assert np.abs(again - original)[seen].max() < 2e-4


def test_depth_is_in_mm(folder, layers):
    path = of(folder, "depth")
    own = nm.read_raster(path).attributes
    near, far = float(own["near_mm"]), float(own["far_mm"])
    seen = layers.coverage > 0
    assert near == pytest.approx(layers.depth_mm[seen].min())
    assert far == pytest.approx(layers.depth_mm[seen].max())
    assert 0 <= near < 0.2 < 2 < far < 2.5  # the plate is 2.4 mm deep
    pixels, spec = pixels_of(path)
    if path.suffix == ".exr":
        assert sorted(spec.channelnames) == ["A", "Z"]
        z, alpha = (pixels[..., spec.channelnames.index(channel)] for channel in "ZA")
        assert np.array_equal(z[seen], layers.depth_mm[seen])
    else:
        codes = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        grey, alpha = codes[..., 0], codes[..., -1] / 65535
        assert codes.dtype == np.uint16
        z = near + (1 - grey / 65535) * (far - near)
        assert np.abs(z - layers.depth_mm)[seen].max() <= (far - near) / 65535
        assert np.ptp(grey[seen]) == 65535
    assert np.array_equal(alpha, seen)


def test_coverage_is_grey(folder, layers):
    path = of(folder, "coverage")
    found = cv2.imread(str(path), cv2.IMREAD_UNCHANGED) / 65535 if path.suffix == ".png" else pixels_of(path)[0][..., 0]
    assert np.abs(found - layers.coverage).max() < 1e-5
    assert len(np.unique(layers.coverage)) > 2  # its rim is anti-aliased


def numbers_in(path):
    if path.suffix == ".exr":
        return pixels_of(path)[0][..., 0]
    blue, green, red = (cv2.imread(str(path))[..., k].astype(int) for k in range(3))
    return red + 256 * green + 65536 * blue - 1


def test_faces_are_numbered(folder, layers):
    found = numbers_in(of(folder, "faces"))
    assert np.array_equal(found, layers.faces)
    assert np.array_equal(found >= 0, layers.coverage > 0)
    assert (found[layers.coverage == 0] == -1).all()
    middle, upper = found[25, 30], found[10, 30]  # rows of the mesh are numbered upwards
    assert 400 < middle < 720
    assert upper > 900


@pytest.mark.parametrize("format", ["exr", "png"])
def test_face_numbers_are_those_of_the_file_even_if_faces_were_dropped(tmp_path, format):
    given = plate_mesh()
    bad = np.append(given.vertices, [[np.nan, 0, 0]], axis=0)
    number = np.arange(len(given.faces)) * 3 + 2  # two degenerate faces precede each good one
    faces = np.zeros((len(given.faces) * 3, 3), np.int32)
    faces[number] = given.faces
    faces[number - 1] = [0, 1, len(bad) - 1]
    options = nm.BakeOptions(**QUICK)
    nm.write_layers(nm.bake(Mesh(bad, faces), options), tmp_path / "m", format=format, faces=True)
    found = numbers_in(tmp_path / "m" / f"faces.{format}")
    plain = nm.bake(given, options).faces
    assert np.array_equal(found, np.where(plain >= 0, number[plain], -1))


def test_face_numbers_may_exceed_two_bytes(layers, tmp_path):
    large = dataclasses.replace(layers, faces=np.where(layers.faces >= 0, layers.faces + 16_770_000, -1))
    for kind in ("exr", "png"):
        nm.write_layers(large, tmp_path / kind, format=kind, faces=True)
        assert np.array_equal(numbers_in(tmp_path / kind / f"faces.{kind}"), large.faces)


def test_every_file_states_its_contents(folder, layers):
    for name in (*MAPS, "coverage", "depth", "faces"):
        own = nm.read_raster(of(folder, name)).attributes
        assert own["layer"] == name
        assert own["view"] == "front"
        assert own["version"] == nm.__version__
        assert float(own["pitch_mm"]) == layers.frame.pitch_mm
        recipe = json.loads(own["recipe"])
        assert (recipe["size"], recipe["sigma_s"], recipe["filter"]) == ("60x50", 3.0, "rnf")
    kinds = [nm.read_raster(of(folder, name)).attributes["kind"] for name in ("coverage", "depth", "faces")]
    assert kinds == ["coverage", "depth", "faces"]


def test_the_contact_sheet_shows_every_layer(folder):
    sheet = cv2.imread(str(folder / "sheet.png"))
    assert sheet.shape[1] > 4 * sheet.shape[0] / 2 * 0.8  # two rows of four tiles
    assert 300 < min(sheet.shape[:2]) < max(sheet.shape[:2]) < 2400
    rows, cols = sheet.shape[:2]
    for row in range(2):
        for col in range(4):
            tile = sheet[row * rows // 2 : (row + 1) * rows // 2, col * cols // 4 : (col + 1) * cols // 4]
            assert tile.reshape(-1, 3).std(axis=0).max() > 15, (row, col)


def test_the_plot_shows_the_curves(layers, tmp_path):
    nm.write_layers(layers, tmp_path / "m.exr", plot=tmp_path / "p.png")
    plot = cv2.imread(str(tmp_path / "p.png"))
    assert plot.shape == (675, 1200, 3)
    assert (plot == 255).all(axis=-1).mean() > 0.4  # white background
    blue, red = (
        (plot.astype(int) - np.array(color)).__abs__().max(axis=-1) < 30 for color in ((180, 119, 31), (40, 39, 214))
    )
    assert blue.sum() > 200
    assert red.sum() > 200  # the curve of the base and the threshold


def test_a_flat_mesh_can_be_plotted(tmp_path):
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    flat = nm.bake(Mesh(square, np.array([[0, 1, 2], [0, 2, 3]], np.int32)), nm.BakeOptions(**QUICK))
    assert flat.report.mixture.form == "none"
    nm.write_layers(flat, tmp_path / "m", format="png", depth=True, plot=tmp_path / "p.png")
    assert np.ptp(cv2.imread(str(tmp_path / "p.png"))) > 200
    depth = nm.read_raster(tmp_path / "m" / "depth.png")
    assert float(depth.attributes["near_mm"]) == float(depth.attributes["far_mm"]) == 0


def test_the_report_of_the_layers_is_written_unless_another_is_given(layers, tmp_path):
    nm.write_layers(layers, tmp_path / "a", report=tmp_path / "a.json")
    found = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert found["layers"] == json.loads(json.dumps([layers.report.to_dict()]))
    nm.write_layers(layers, tmp_path / "b", report=tmp_path / "b.json", metadata={"mine": 1})
    assert json.loads((tmp_path / "b.json").read_text(encoding="utf-8")) == {"mine": 1}


@pytest.mark.parametrize("name", ["depth", "faces"])
def test_missing_layers_are_refused(layers, tmp_path, tree, name):
    less = dataclasses.replace(layers, **{"depth_mm" if name == "depth" else name: None})
    with pytest.raises(UsageError, match=f"`{name}`: these layers have no .*only layers of a mesh do"):
        nm.write_layers(less, tmp_path / "m", **{name: True})
    assert tree() == {}
    nm.write_layers(less, tmp_path / "m")  # the contact sheet works without either layer
    assert (tmp_path / "m" / "sheet.png").exists()


def test_face_numbers_too_large_for_an_image_are_refused(layers, tmp_path, tree):
    large = dataclasses.replace(layers, faces=layers.faces + (1 << 24))
    with pytest.raises(LimitError, match="`faces`: a mesh of more than 16777216 faces"):
        nm.write_layers(large, tmp_path / "m", faces=True)
    assert tree() == {}


def test_the_written_paths_are_returned(layers, tmp_path):
    written = nm.write_layers(layers, str(tmp_path / "m"), depth=True, plot=tmp_path / "p.png")
    names = ["original", "base", "detail", "coverage", "depth"]
    assert written == [
        *(tmp_path / "m" / f"{name}.exr" for name in names),
        tmp_path / "m" / "sheet.png",
        tmp_path / "p.png",
    ]
    assert sorted(p.name for p in (tmp_path / "m").iterdir()) == sorted(p.name for p in written[:-1])


@pytest.mark.parametrize("ending", ["m", "m.exr"])
@pytest.mark.parametrize(
    ("error", "expected", "words"),
    [
        (OSError(28, "No space left on device"), OutputError, r"p\.png: cannot be written \(No space left"),
        (KeyboardInterrupt("now"), KeyboardInterrupt, "now"),
    ],
    ids=["full", "interrupted"],
)
def test_a_failure_while_writing_leaves_no_file(layers, tmp_path, tree, monkeypatch, ending, error, expected, words):
    def fail(*_):
        raise error

    monkeypatch.setattr(layer_files, "mixture_plot", fail)
    with pytest.raises(expected, match=words):
        nm.write_layers(layers, tmp_path / ending, plot=tmp_path / "p.png")
    assert tree() == {}


def test_a_tetrahedron_is_baked_from_every_side(tmp_path):
    options = nm.BakeOptions(**QUICK, view="front,back,left,right,top,bottom,iso")
    sets = nm.bake_views(Mesh(VERTICES.astype(float), FACES), options)
    nm.write_layers(sets, tmp_path / "all.exr", depth=True, faces=True)
    source = oiio.ImageInput.open(str(tmp_path / "all.exr"))
    names = []
    while source.seek_subimage(len(names), 0):
        names.append(source.spec().get_string_attribute("oiio:subimagename"))
    layer_names = (*MAPS, "coverage", "depth", "faces")
    assert names == [f"{view}.{name}" for view in options.views for name in layer_names]
    for view, expected in zip(options.views, sets, strict=True):
        found = nm.read_normal_map(f"{tmp_path / 'all.exr'}:{view}.base")
        assert np.array_equal(found.coverage, expected.coverage)
