"""Values have a one-line repr, and maps and reliefs show an image in a notebook."""

import dataclasses
import io
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

import nmaptool as nm
from nmaptool.figures.notebook import picture_of


@pytest.fixture(scope="module")
def values():
    """A small example of each type with its own repr."""
    y, x = np.mgrid[1:-1:32j, -1:1:32j]
    normal_map = nm.NormalMap.from_array(np.dstack([x, y, np.ones_like(x)]), np.hypot(x, y) < 0.9, 0.5, "dome")
    sphere = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=3))
    small = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=1))
    relief = nm.relief(normal_map)
    composition = nm.blend(normal_map, normal_map)
    depth = nm.depth_to_normals(x * x + y)
    layers = nm.bake(small, nm.BakeOptions(size="48x32", renderer="numpy"))
    smoothed = nm.smooth(small)
    comparison = nm.compare(small, nm.CompareOptions(size="64x64", renderer="numpy"))
    workspace = nm.pack([nm.PackedMap(normal_map, mask=np.ones((32, 32), np.float32))])
    unpacked = nm.unpack(workspace)
    states, quick = [], nm.TrainOptions(stages=1, clusters=1, hidden=2, steps=1)
    example = nm.training_example(sphere)
    model = nm.train([example], quick, descriptor=nm.DescriptorOptions((3.0,), (0.5,), 1), keep=states.append)
    leaf = {"file": "leaf.png", "mask": "mask.png"}
    recipe = nm.parse_recipe({"layer": [leaf, {"layer": [leaf]}, {"recipe": "other.toml"}]})
    found = [
        normal_map,
        nm.RasterImage(np.zeros((4, 6, 3), np.uint8), ("R", "G", "B")),
        nm.inspect_map(np.full((64, 64, 3), (128, 128, 255), np.uint8)),
        nm.decode_image(np.full((64, 64, 3), (128, 128, 255), np.uint8)),
        nm.Layer(normal_map),
        nm.LayerGroup([normal_map]),
        nm.PackedMap(normal_map),
        small,
        nm.decompose_normals(small),
        nm.reconstruct(small, small.geometry.normals),
        model,
        states[-1],
        example,
        recipe,
        *recipe.layers,
    ]
    found += [nm.read_font("DejaVu Sans"), nm.Contours((np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]),))]
    found.append(nm.solid(relief))
    coin = nm.PlateDesign(nm.PlateOptions(shape="round"), nm.FrameOptions(frame="1mm"))
    found += [coin, nm.plate(normal_map, design=coin).plate]
    found.append(nm.RecipePlate({"shape": "round"}, texts=({"text": "ANNO"},)))
    found.append(nm.ReliefSession(normal_map).parts())
    found.append(nm.read_scene(Path(__file__).parents[1] / "samples" / "scene.toml"))
    found.append(nm.BatchResult(("a.png",), ("a.stl",), 0, "done"))
    results = [relief, composition, depth, layers, smoothed]
    found += [*results, *(result.report for result in results), relief.height, layers.report.mixture]
    found += [comparison, *comparison.contenders.values(), *comparison.rendered_views.values(), workspace, unpacked]
    found += [*workspace.layers, workspace.layers[0].mask, *unpacked.layers, smoothed.report.reconstruction]
    return {type(value).__name__: value for value in found if value is not None}


def test_every_repr_is_one_short_line_without_array_contents(values):
    for name, value in values.items():
        line = repr(value)
        assert line == str(value)
        assert line.startswith(f"<{name} ")
        assert line.endswith(">")
        assert "\n" not in line
        assert "array(" not in line
        assert len(line) < (1000 if name.endswith("Report") else 200), line


def test_no_public_value_prints_its_arrays(values):
    for name in nm.__all__:
        kind = getattr(nm, name)
        fields = dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()
        if any("Float" in str(field.type) or "NDArray" in str(field.type) for field in fields):
            assert name in values, name


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("NormalMap", "<NormalMap dome: 32 x 32 px, 0.5 mm per px, 60% covered>"),
        ("RasterImage", "<RasterImage image: 6 x 4 px, pitch unknown, channels R, G, B, 8-bit codes>"),
        ("Decoded", "<Decoded picture: 64 x 64 px, pitch unknown, background flat>"),
        ("Inspection", "<Inspection picture: 64 x 64 px, 8 bits, 1 finding (no-foreground)>"),
        ("Mesh", "<Mesh mesh: 42 vertices, 80 faces, 1 mm per unit (assumed)>"),
        ("LayerGroup", "<LayerGroup group: 1 layer>"),
        ("Workspace", "<Workspace workspace: 32 x 32 px, 0.5 mm per px, 16 bits, 1 layer>"),
        ("Recipe", "<Recipe recipe: 3 layers, 2 files, canvas of the lowest layer's size>"),
        ("RecipeLink", "<RecipeLink recipe: layer 3 (other.toml): other.toml>"),
        ("PlateDesign", "<PlateDesign round, frame 1mm flat>"),
        ("RecipePlate", "<RecipePlate shape round, text 'ANNO'>"),
    ],
)
def test_the_repr_states_the_main_facts(name, line, values):
    assert repr(values[name]) == line


def test_reprs_of_reports_show_sizes_of_arrays_and_counts_of_lists(values):
    line = repr(values["ReliefReport"])
    assert "solver='multigrid'" in line
    assert "history=7 entries" in line
    assert "deviation_mm" not in repr(values["Contender"])
    assert repr(values["RenderedView"]).startswith("<RenderedView deviation_mm=float32 (")


def test_a_name_with_line_breaks_stays_on_one_line():
    flat = np.zeros((2, 2, 3))
    flat[..., 2] = 1
    assert repr(nm.NormalMap.from_array(flat, name="a\nb")).startswith("<NormalMap a b: 2 x 2 px")


@pytest.mark.parametrize("name", ["NormalMap", "Height", "Relief", "LayerSet", "Composition", "DepthResult"])
def test_a_notebook_shows_a_small_image(name, values):
    image = Image.open(io.BytesIO(values[name]._repr_png_()))
    assert image.format == "PNG"
    assert 256 <= max(image.size) <= 512
    assert len(np.unique(np.asarray(image))) > 10


def test_the_image_of_a_map_shows_its_codes(values):
    picture = picture_of(values["NormalMap"])
    codes = ((values["NormalMap"].normals + 1) * 127.5 + 0.5).astype(np.uint8)
    np.testing.assert_array_equal(picture[8::16, 8::16], codes)


@pytest.mark.parametrize("shape", [(3000, 5000), (1, 5000), (5000, 2), (1, 1)])
def test_images_of_any_size_are_shown_small(shape):
    z_mm = np.zeros((shape[0] + 1, shape[1] + 1))
    picture = picture_of(nm.Height(z_mm, np.ones(shape, bool), nm.Frame(*shape, pitch_mm=1.0)))
    assert max(picture.shape[:2]) == 512
    assert picture.dtype == np.uint8


def test_values_without_an_image_are_refused():
    with pytest.raises(nm.UsageError, match="int has no picture"):
        picture_of(3)
    assert not hasattr(nm.Frame(1, 1), "_repr_png_")
