"""Detail maps in the studio: they follow the layers they belong to, or are split off."""

import dataclasses

import numpy as np
import pytest
from bake_cases import write_plate
from mesh_cases import sphere
from stack_cases import waves, write_maps
from studio_cases import ask, served, until
from test_studio_meshes import QUICK, ended, ready, studio, undated

import nmaptool as nm
from nmaptool.io.recipes.scenes import read_scene
from nmaptool.studio.document import opened
from nmaptool.studio.files.store import Store
from nmaptool.studio.layers import edited
from nmaptool.studio.meshes.details import Details, content_of
from nmaptool.types.recipe import RecipeGroup


@pytest.fixture
def folder(tmp_path, png):
    """Maps, and for ``bunny.exr`` a detail map that covers the same pixels."""
    write_maps(tmp_path, png)
    bunny = waves(40, 30, 9, 0.5, disc=True)
    detail = waves(40, 30, 40, 0.5, disc=True)
    assert np.array_equal(bunny.coverage, detail.coverage)
    nm.write_normal_map(detail, tmp_path / "bunny-detail.exr")
    return tmp_path


@pytest.fixture
def details(folder):
    made = Details(Store(folder / "state"))
    made.add(folder / "bunny.exr", folder / "bunny-detail.exr")
    return made


PLACED = {"at": "40%,60%", "scale": "0.8", "rotate": 30.0, "flip_h": True, "mask": "half.png"}


def test_the_detail_of_a_layer_is_placed_like_it(folder, details):
    document = details.followed(opened([str(folder / "bunny.exr")]))
    assert document.relief.files.detail == "bunny-detail.exr"
    both = details.followed(opened([str(folder / "plate.exr"), str(folder / "bunny.exr")]))
    moved = edited(both, (1,), PLACED)
    assert details.follow(both, moved)
    assert not details.follow(moved, dataclasses.replace(moved, relief=both.relief))
    moved = details.followed(moved)
    assert moved.relief.files.detail != both.relief.files.detail
    scene = read_scene(moved.recipe)
    bunny = moved.layers[1]
    wanted = nm.compose(
        [
            nm.NormalMap.from_array(np.full((60, 80, 3), (0.0, 0, 1)), pitch_mm=0.5),
            nm.Layer(nm.read_normal_map(folder / "bunny-detail.exr"), bunny.options, nm.read_grey(folder / "half.png")),
        ],
    )
    assert np.abs(scene.detail.normals - wanted.normal_map.normals).max() < 1e-6
    assert (scene.detail.normals[..., 2] < 0.99).sum() > 100


def test_a_layer_without_detail_is_flat_and_covers_the_detail_below(folder, details):
    """The leaf is a picture with a flat background, of which only the motif counts."""
    document = opened([str(folder / "plate.exr"), str(folder / "bunny.exr"), str(folder / "leaf.png")])
    scene = read_scene(details.followed(document).recipe)
    without = read_scene(details.followed(dataclasses.replace(document, layers=document.layers[:2])).recipe)
    full = read_scene(document.recipe).composition
    below = read_scene(dataclasses.replace(document, layers=document.layers[:2]).recipe).composition
    leaf = np.abs(full.normal_map.normals - below.normal_map.normals).max(axis=2) > 1e-6
    flat = np.array([0, 0, 1], np.float32)
    inside = leaf & (np.abs(without.detail.normals - flat).max(axis=2) > 1e-3)
    assert inside.sum() > 50
    assert (np.abs(scene.detail.normals[inside] - flat).max(axis=1) < 1e-3).mean() > 0.9
    assert np.abs(scene.detail.normals - without.detail.normals)[~leaf].max() < 1e-6


def test_hidden_layers_and_groups_have_their_detail_in_place(folder, details):
    document = opened([str(folder / "plate.exr"), str(folder / "bunny.exr")])
    plate, bunny = document.layers
    grouped = dataclasses.replace(
        document, layers=(plate, RecipeGroup((bunny, dataclasses.replace(bunny, hidden=True))))
    )
    flat = read_scene(details.followed(document).recipe).detail.normals
    assert np.abs(read_scene(details.followed(grouped).recipe).detail.normals - flat).max() < 1e-6
    hidden = dataclasses.replace(document, layers=(plate, dataclasses.replace(bunny, hidden=True)))
    assert details.followed(hidden).relief.files.detail is None
    assert content_of(hidden) != content_of(document)


def test_the_details_of_an_opened_recipe_are_known_again(folder, details):
    document = details.followed(opened([str(folder / "plate.exr"), str(folder / "bunny.exr")]))
    later = Details(Store(folder / "state"))
    assert later.can_follow(document)
    moved = edited(document, (1,), PLACED)
    assert later.follow(document, moved)
    ours, theirs = (read_scene(one.followed(moved).recipe).detail for one in (details, later))
    assert np.array_equal(ours.normals, theirs.normals)
    # one map for all layers does not belong to any of them
    strange = edited(document, (0,), {"rotate": 5.0})
    assert not Details(Store(folder / "state")).can_follow(strange)
    given = opened([str(folder / "bunny.exr")])
    files = dataclasses.replace(given.relief.files, detail="bunny-detail.exr")
    given = dataclasses.replace(given, relief=dataclasses.replace(given.relief, files=files))
    turned = later.followed(edited(given, (0,), {"rotate": 90.0}))
    scene = read_scene(turned.recipe)
    wanted = nm.compose(
        [nm.Layer(nm.read_normal_map(folder / "bunny-detail.exr"), nm.LayerOptions(rotate=90))],
        nm.CanvasOptions(size="30x40"),
    )
    assert np.abs(scene.detail.normals - wanted.normal_map.normals).max() < 1e-6


def test_two_bakes_are_saved_with_their_details_and_make_the_relief_of_the_studio(tmp_path, run):
    nm.write_mesh(sphere(6), tmp_path / "ball.ply")
    plate = write_plate(tmp_path / "plate.obj")
    with studio(tmp_path, plate, tmp_path / "ball.ply") as client, client.live() as live:
        ready(live)
        ask(live, do="bake", id="1", values=QUICK)
        ended(live)
        ask(live, do="bake", id="2", values={"camera": {**QUICK["camera"], "size": "30x30"}})
        seen = ended(live)
        assert "not used" not in seen["bake"]["text"]
        assert seen["meshes"]["detail"]["is_followed"] is True
        ask(live, do="set-layer", place=[1], values={"at": "30%,40%", "scale": "0.7"})
        ask(live, do="set", values={"mu": 1.0, "height": "3mm"})
        ask(live, do="save", name="scene")
        saved = until(live, "saved")
        assert "scene-detail.toml" in saved["files"]
        assert not any("state" in (tmp_path / name).read_text() for name in ("scene.toml", "scene-detail.toml"))
        ask(live, do="set-layer", place=[1], values={"at": "60%,40%"})
        state = until(live, "state", lambda found: found["layers"][1]["options"]["at"] == "60%,40%")
        assert state["files"]["detail"] != "scene-detail.toml"
        ask(live, do="save")
        saved = until(live, "saved")
        assert "scene-detail.toml" in saved["files"]
    assert sorted(path.name for path in tmp_path.glob("*.toml")) == ["scene-detail.toml", "scene.toml"]
    scene = nm.read_scene(tmp_path / "scene.toml")
    assert scene.detail is not None
    done = run("relief", tmp_path / "scene.toml", "-o", tmp_path / "scene.stl")
    assert done.code == 0, done.err


def test_unsaved_details_are_recovered(tmp_path):
    plate = write_plate(tmp_path / "plate.obj")
    with studio(tmp_path, plate) as client, client.live() as live:
        ready(live)
        ask(live, do="bake", id="1", values=QUICK)
        ended(live)
        ask(live, do="set-layer", place=[0], values={"rotate": 10.0})
        state = until(live, "state", lambda found: found["layers"][0]["options"]["rotate"] == 10)
        assert state["files"]["detail"].endswith(".toml")
    with served(root=tmp_path / "state") as client, client.live() as live:
        (item,) = until(live, "unsaved")["items"]
        ask(live, do="recover", id=item["id"])
        found = until(live, "meshes", lambda found: found["detail"]["name"] is not None)
        assert found["detail"]["is_followed"] is True
        assert until(live, "frame")[1]["first"].any()


def test_split_off_detail_is_that_of_the_command_line(folder, run):
    with served(folder / "plate.exr") as client, client.live() as live:
        assert until(live, "meshes")["detail"]["name"] is None
        ask(live, do="split-detail", values={"sigma_s": "3px", "filter": "grnf"})
        seen = ended(live, "detail")
        assert "mu sets how much of it is kept" in seen["detail"]["text"]
        detail = folder / seen["state"]["files"]["detail"]
        assert seen["meshes"]["detail"]["split"] == {"sigma_s": "3px", "filter": "grnf"}
        assert seen["meshes"]["detail"]["is_stale"] is False
        words = ("--sigma-s", "3px", "--filter", "grnf", "-o", folder / "maps")
        assert run("compose", "split", folder / "plate.exr", *words).code == 0
        assert undated(detail) == undated(folder / "maps" / "detail.exr")
        ask(live, do="split-detail", values={"sigma_s": "0.01px"})
        assert "use at least 0.3px" in ended(live, "detail")["detail"]["text"]
        ask(live, do="split-detail", values={"sigma_s": 3})
        assert until(live, "error")["text"]


def test_split_off_detail_of_several_layers_becomes_stale(folder):
    with served(folder / "plate.exr", folder / "bunny.exr") as client, client.live() as live:
        ask(live, do="split-detail", values={})
        ended(live, "detail")
        ask(live, do="set", values={"mu": 1.0})
        assert until(live, "meshes")["detail"]["is_stale"] is False
        ask(live, do="set-layer", place=[1], values={"rotate": 40.0})
        found = until(live, "meshes", lambda found: found["detail"]["is_stale"])
        assert found["detail"]["is_followed"] is False
        ask(live, do="split-detail", values={})
        assert ended(live, "detail")["meshes"]["detail"]["is_stale"] is False


def test_a_bake_beside_a_detail_of_its_own_says_what_is_not_used(folder):
    plate = write_plate(folder / "plate.obj")
    with studio(folder, plate, maps=(folder / "plate.exr", folder / "bunny.exr")) as client, client.live() as live:
        ready(live)
        ask(live, do="split-detail", values={})
        ended(live, "detail")
        ask(live, do="bake", id="1", values=QUICK)
        seen = ended(live)
        assert "its detail is not used: the document has a detail map of its own" in seen["bake"]["text"]
        assert seen["meshes"]["detail"]["is_offered"] is True
        ask(live, do="follow-details")
        found = until(live, "meshes", lambda found: found["detail"]["is_followed"])
        assert found["detail"]["is_offered"] is False
        ask(live, do="undo")
        assert until(live, "meshes")["detail"]["is_followed"] is False


def test_a_dropped_file_of_layers_brings_its_detail(tmp_path, run):
    plate = write_plate(tmp_path / "plate.obj")
    done = run("bake", plate, "-o", tmp_path / "maps.exr", "--size", "60x50", "--renderer", "numpy")
    assert done.code == 0, done.err
    with served(root=tmp_path / "state") as client, client.live() as live:
        assert client.drop(tmp_path / "maps.exr")["kind"] == "map"
        ask(live, do="add-layer", file="maps.exr")
        state = until(live, "state", lambda found: found["layers"])
        assert state["layers"][0]["file"].endswith("maps.exr:original")
        assert state["files"]["detail"].endswith("maps.exr:detail")
        until(live, "frame")
        assert client.studio.engine.scene.detail is not None
        ask(live, do="undo")
        assert until(live, "state", lambda found: not found["layers"])["files"]["detail"] is None
