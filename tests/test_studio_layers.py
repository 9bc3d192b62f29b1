"""Layers of the studio's document: they are edited, ordered, dropped and inspected."""

import json
import re
import struct
import zlib

import numpy as np
import pytest
from stack_cases import SCENE, write_maps
from studio_cases import ask, served, until

import nmaptool as nm
from nmaptool.core.errors import InputError, UsageError
from nmaptool.studio import layers
from nmaptool.studio.document import Document, opened
from nmaptool.studio.files.drops import kind_of, opened_recipe
from nmaptool.studio.files.store import Store, plain_name


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def letters(document):
    """The names of the layers, those of groups in brackets."""

    def of(entries):
        return [one["label"] if not one["layers"] else [one["label"], *of(one["layers"])] for one in entries]

    return of(layers.described(document.layers))


@pytest.fixture
def abc():
    group = {"name": "g", "layer": [{"file": "x"}, {"file": "y"}]}
    return Document.of(nm.parse_recipe({"layer": [{"file": "a"}, {"file": "b"}, group, {"file": "c"}]}))


@pytest.mark.parametrize(
    ("place", "to", "after"),
    [
        ((0,), (2,), ["b", "a", ["g", "x", "y"], "c"]),
        ((0,), (4,), ["b", ["g", "x", "y"], "c", "a"]),
        ((3,), (0,), ["c", "a", "b", ["g", "x", "y"]]),
        ((3,), (2, 1), ["a", "b", ["g", "x", "c", "y"]]),
        ((0,), (2, 2), ["b", ["g", "x", "y", "a"], "c"]),
        ((2, 0), (0,), ["x", "a", "b", ["g", "y"], "c"]),
        ((2, 1), (2, 0), ["a", "b", ["g", "y", "x"], "c"]),
        ((1,), (1,), ["a", "b", ["g", "x", "y"], "c"]),
        ((1,), (2,), ["a", "b", ["g", "x", "y"], "c"]),
    ],
)
def test_layers_are_moved_below_others(abc, place, to, after):
    assert letters(layers.moved(abc, place, to)) == after


def test_layers_are_removed_and_doubled(abc):
    assert letters(layers.removed(abc, (1,))) == ["a", ["g", "x", "y"], "c"]
    assert letters(layers.removed(layers.removed(abc, (2, 0)), (2, 0))) == ["a", "b", "c"]  # no empty group
    assert letters(layers.doubled(abc, (2, 1))) == ["a", "b", ["g", "x", "y", "y"], "c"]
    with pytest.raises(UsageError, match="a group cannot be moved into itself"):
        layers.moved(abc, (2,), (2, 0))
    for place in ((4,), (0, 0), (2, 5), ()):
        with pytest.raises(UsageError, match="named a layer that is not there"):
            layers.removed(abc, place) if place else layers.place_of(list(place))


def test_options_of_a_layer_are_set_and_taken_back(abc):
    edited = layers.edited(abc, (2, 0), {"rotate": 30, "mode": "rnm", "feather": "2px", "read": {"green": "down"}})
    entry = layers.entry_at(edited.layers, (2, 0))
    assert (entry.options.rotate, entry.options.mode, str(entry.options.feather)) == (30, "rnm", "2px")
    assert entry.read == {"green": "down"}
    back = {"rotate": None, "mode": None, "feather": None, "read": {"green": None}}
    assert layers.edited(edited, (2, 0), back) == abc
    hidden = layers.edited(abc, (2,), {"hidden": True})
    assert [place for place, _ in layers.maps_of(hidden.layers)] == [(0,), (1,), (3,)]
    with pytest.raises(UsageError, match=r"`rotate`: is not an option of a layer"):
        layers.edited(abc, (2,), {"rotate": 30})  # of a group
    with pytest.raises(UsageError, match=r"`swirl`: is not an option of reading a map"):
        layers.edited(abc, (0,), {"read": {"swirl": 1}})
    with pytest.raises(UsageError, match=r"`strength=3`"):
        layers.edited(abc, (0,), {"strength": 3})


def test_a_moved_layer_turns_its_vectors(folder):
    with served(folder / "plate.exr", folder / "bunny.exr") as client, client.live() as live:
        placed = until(live, "placements")
        assert placed["canvas"] == {"cols": 80, "rows": 60, "pitch_mm": 0.5}
        assert placed["layers"][1] == {"place": [1], "cols": 30, "rows": 40, "matrix": [[1, 0, 25], [0, 1, 10]]}
        until(live, "frame")
        ask(live, do="set-layer", place=[1], values={"at": "25%,50%", "rotate": 90})
        matrix = np.array(until(live, "placements")["layers"][1]["matrix"])
        assert np.allclose(matrix, [[0, 1, 0], [-1, 0, 45]])  # the middle lies at 20,30
        engine = client.studio.engine
        turned = engine.scene.composition.normal_map.normals[20:40, 10:30]
        own = nm.read_normal_map(folder / "bunny.exr").normals
        expected = np.rot90(own)[5:25, 10:30]  # the part around the middle
        expected = np.stack([-expected[..., 1], expected[..., 0], expected[..., 2]], axis=-1)
        assert np.abs(turned - expected).max() < 2e-3


def test_maps_are_inspected_and_a_remedy_is_offered(folder, dome):
    d = dome()
    bumps = nm.NormalMap(d.normals.astype(np.float32), d.inside.astype(np.float32), nm.Frame(*d.inside.shape))
    nm.write_normal_map(bumps, folder / "down.exr")
    with served(folder / "down.exr") as client, client.live() as live:
        found = until(live, "findings", lambda message: message["layers"])["layers"]
        assert found == [{"place": [0], "findings": []}]
        ask(live, do="set-layer", place=[0], values={"read": {"green": "down"}})
        found = until(live, "findings", lambda message: message["layers"] and message["layers"][0]["findings"])
        (one,) = [one for one in found["layers"][0]["findings"] if one["code"] == "green-wrong"]
        assert one["offers"] == [{"label": 'green = "up"', "of": "read", "values": {"green": "up"}}]
        assert one["remedy"] == 'try green = "up"'


def _slope(normal_map):
    x, y, z = np.moveaxis(normal_map.normals, -1, 0)
    return float(np.median(np.hypot(x, y) / z))


def test_dropped_files_become_layers(folder, png):
    grey = np.linspace(0, 255, 60 * 80).reshape(60, 80).astype(np.uint8)
    png(folder / "ramp.png", grey)
    with served(root=folder / "state") as client, client.live() as live:
        assert until(live, "state")["layers"] == []
        assert client.drop(folder / "plate.exr") == {"file": "plate.exr", "kind": "map"}
        assert client.drop(folder / "plate.exr") == {"file": "plate-2.exr", "kind": "map"}
        ask(live, do="add-layer", file="plate.exr")
        assert until(live, "state")["name"] == "plate"
        until(live, "frame")
        assert client.drop(folder / "ramp.png")["kind"] == "grey"
        ask(live, do="add-depth", file="ramp.png", values={"depth_scale": "20%"})
        state = until(live, "state", lambda found: len(found["layers"]) == 2)
        made = state["layers"][1]["file"]
        assert made.endswith("ramp-normals.exr")
        assert state["depths"][made]["depth_scale"] == "20%"
        expected = nm.depth_to_normals(
            nm.read_raster(folder / "ramp.png", holds="depth"), nm.DepthOptions(depth_scale=nm.length("20%"))
        )
        assert np.allclose(nm.read_normal_map(made).normals, expected.normal_map.normals, atol=1e-6)
        ask(live, do="set-depth", place=[1], values={"depth_scale": "40%"})
        again = until(live, "state", lambda found: found["layers"][1]["file"] != made)["layers"][1]
        assert _slope(nm.read_normal_map(again["file"])) == pytest.approx(2 * _slope(expected.normal_map), rel=1e-3)
        ask(live, do="set-file", role="mask", file="ramp.png")
        assert until(live, "state")["files"]["mask"].endswith("ramp.png")
        ask(live, do="set-file", role="mask", file=None)
        assert until(live, "state")["files"]["mask"] is None
        ask(live, do="use-as-detail", place=[1])
        state = until(live, "state")
        assert (len(state["layers"]), state["files"]["detail"]) == (1, again["file"])
        for wrong in ("../plate.exr", "", "none.png", "/etc/passwd", 3):
            ask(live, do="add-layer", file=wrong)
            assert "which was not dropped" in until(live, "error")["text"]
        ask(live, do="set-file", role="hat", file="ramp.png")
        assert "'hat', which a relief does not have" in until(live, "error")["text"]


def test_errors_name_dropped_files_as_the_user_does(folder, png):
    rng = np.random.default_rng(3)
    png(folder / "noise.png", rng.integers(0, 100, (20, 20, 3)).astype(np.uint8))  # no vector is of unit length
    with served(root=folder / "state") as client, client.live() as live:
        client.drop(folder / "noise.png")
        ask(live, do="add-layer", file="noise.png")
        text = until(live, "error")["text"]
        assert re.match(r"noise: noise\.png: does not look like a normal map", text), text
        assert "state" not in text


def test_what_a_dropped_file_holds(folder, png):
    png(folder / "colour.png", np.random.default_rng(1).integers(0, 255, (8, 8, 3)).astype(np.uint8))
    png(folder / "grey.png", np.repeat(np.arange(64, dtype=np.uint8).reshape(8, 8, 1), 3, axis=2))
    assert kind_of(folder / "colour.png") == "map"
    assert kind_of(folder / "grey.png") == "grey"
    assert kind_of(folder / "half.png") == "grey"
    assert kind_of(folder / "a.toml") == "recipe"
    assert kind_of(folder / "a.PLY") == "mesh"
    assert kind_of(folder / "a.bin") == "part"


def test_bad_files_are_refused_in_one_line(folder):
    header = b"IHDR" + struct.pack(">IIBBBBB", 100_000, 100_000, 8, 2, 0, 0, 0)
    huge = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))
    with served(root=folder / "state") as client:
        answer = client.send(None, huge, "huge.png")
        assert answer.status == 400
        text = json.loads(answer.body)["text"]
        assert text.startswith("huge.png: ")
        assert "100000 x 100000" in text
        assert "\n" not in text
        answer = client.send(None, b"no picture", "bad.png")
        assert json.loads(answer.body)["text"].startswith("bad.png: ")
        assert client.send(None, b"x", "..").status in (400, 404)
        assert client.send(None, b"x", "a%3Fb.png").status == 400
        store = next((folder / "state").iterdir())
        assert [path.name for path in store.iterdir()] == []


@pytest.mark.parametrize("name", ["", "..", "a?b.png", "x" * 130, "a\nb.png", "con:.png"])
def test_names_that_no_file_can_have(name):
    with pytest.raises(InputError, match=r"is not the name of a file|cannot hold"):
        plain_name(name)


def test_folders_of_names_are_dropped():
    assert plain_name("C:\\maps\\a.png") == "a.png"
    assert plain_name("../../a.png") == "a.png"


def test_a_dropped_recipe_finds_its_files(folder, tmp_path):
    store = Store(tmp_path / "state")
    (store.folder / "scene.toml").write_text(SCENE, encoding="utf-8")
    home = tmp_path / "home"
    home.mkdir()
    needs = r"scene\.toml: needs plate\.exr, bunny\.exr, half\.png, leaf\.png, wide\.png; drop the recipe together"
    with pytest.raises(InputError, match=needs):
        opened_recipe(store.folder / "scene.toml", Document(folder=home), store)
    (folder / "plate.exr").rename(home / "plate.exr")
    for name in ("bunny.exr", "half.png", "wide.png", "leaf.png"):
        (folder / name).rename(store.folder / name)
    document = opened_recipe(store.folder / "scene.toml", Document(folder=home), store)
    assert document.files[0] == "plate.exr"
    assert document.files[1] == str(store.folder / "bunny.exr")
    (store.folder / "far.toml").write_text('[[layer]]\nfile = "../state"\n', encoding="utf-8")
    with pytest.raises(InputError, match="needs"):
        opened_recipe(store.folder / "far.toml", Document(folder=home), store)
    assert opened([]).layers == ()
