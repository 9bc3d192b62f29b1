"""The train command, and trained filters in bake, smooth and compare."""

import json

import numpy as np
import pytest
from learned_cases import examples, hilly
from mesh_files import obj

import nmaptool as nm

QUICK = ("--stages", "2", "--clusters", "2", "--hidden", "3", "--steps", "6", "--samples", "800")


@pytest.fixture
def meshes(tmp_path):
    """Mesh files of two roofs."""
    paths = []
    for seed in (0, 1):
        mesh = hilly(seed)
        paths.append(tmp_path / f"roof{seed}.obj")
        paths[-1].write_bytes(obj(mesh.vertices, mesh.faces))
    return paths


@pytest.fixture
def trained(run, meshes, tmp_path):
    """A filter trained on the two roofs."""
    done = run("train", *meshes, *QUICK, "-o", tmp_path / "mine.npz")
    assert done.code == 0, done.err
    return tmp_path / "mine.npz"


def test_a_filter_is_written_and_reported(run, meshes, tree, tmp_path):
    words = ("--sigma-s", "2", "--sigma-s", "4%", "--report", tmp_path / "r.json", "--json")
    done = run("train", *meshes, *QUICK, *words, "-o", tmp_path / "f.npz")
    assert done.code == 0, done.err
    model = nm.read_filter_model(tmp_path / "f.npz")
    assert f"trained on 2 meshes, 2304 faces: filter {model.digest}\n" in done.err
    assert "mean angle to the targets" in done.err
    assert f"wrote {tmp_path / 'f.npz'}\n" in done.err
    metadata = json.loads(done.out)
    assert metadata == json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert metadata["filter"] == model.digest
    assert [mesh["sigma_s"] for mesh in metadata["meshes"]] == [2.0, "4%"]
    assert metadata["options"]["hidden"] == 3
    assert metadata["outputs"] == [str(tmp_path / "f.npz"), str(tmp_path / "r.json")]
    assert sorted(tree()) == ["f.npz", "r.json", "roof0.obj", "roof1.obj"]


def test_the_command_gives_the_filter_of_the_function(run, meshes, trained):
    made = [nm.training_example(nm.read_mesh(path), nm.FilterOptions(filter="grnf")) for path in meshes]
    options = nm.TrainOptions(stages=2, clusters=2, hidden=3, steps=6, samples=800)
    assert nm.train(made, options).digest == nm.read_filter_model(trained).digest


def test_an_interrupted_training_resumes(run, meshes, trained, tree, tmp_path, monkeypatch):
    from nmaptool.io.output.filter_models import TrainingFile

    keep, kept = TrainingFile.keep, []

    def stop(file, state):
        keep(file, state)
        kept.append(state)
        if len(kept) == 2:
            raise KeyboardInterrupt

    words = ("train", *meshes, *QUICK, "-o", tmp_path / "f.npz", "--state", tmp_path / "state.npz")
    monkeypatch.setattr(TrainingFile, "keep", stop)
    done = run(*words)
    assert done.code == 130
    assert done.err == "nmap: error: interrupted; nothing was written\n"
    assert set(tree()) == {"mine.npz", "roof0.obj", "roof1.obj", "state.npz"}
    monkeypatch.setattr(TrainingFile, "keep", keep)
    done = run(*words)
    assert done.code == 0, done.err
    assert f"resumed from {tmp_path / 'state.npz'} with 2 networks finished\n" in done.err
    assert set(tree()) == {"f.npz", "mine.npz", "roof0.obj", "roof1.obj"}
    assert (tmp_path / "f.npz").read_bytes() == trained.read_bytes()


def test_a_state_with_other_options_is_refused(run, meshes, refused, tmp_path):
    state = tmp_path / "state.npz"
    nm.write_training(nm.TrainingState("another"), state)
    words = ("-o", tmp_path / "f.npz", "--state", state)
    refused(3, r"state\.npz: belongs to a training with other meshes or options", "train", *meshes, *QUICK, *words)


def test_bake_smooth_and_compare_accept_a_trained_filter(run, meshes, trained, tmp_path):
    base = {}
    for name, more in (("own", ("--model", trained)), ("shipped", ())):
        out = tmp_path / name
        words = ("--filter", "learned", *more)
        done = run("bake", meshes[0], "-o", out, "--size", "60x60", "--renderer", "numpy", *words, "--json")
        assert done.code == 0, done.err
        used = nm.read_filter_model(trained) if name == "own" else nm.shipped_filter()
        assert f"learned filter {used.digest}\n" in done.err
        (layers,) = json.loads(done.out)["layers"]
        assert layers["model"] == used.digest
        assert layers["options"]["filter"] == "learned"
        assert "sigma_s" not in layers["options"]
        assert json.loads(done.out)["files"].get("model") == (str(trained) if name == "own" else None)
        base[name] = nm.read_normal_map(out / "base.exr").normals
        done = run("smooth", meshes[0], "-o", tmp_path / f"{name}.ply", *words, "--json")
        assert done.code == 0, done.err
        assert json.loads(done.out)["filter"] == {"filter": "learned"}
    assert not np.array_equal(base["own"], base["shipped"])
    assert (tmp_path / "own.ply").read_bytes() != (tmp_path / "shipped.ply").read_bytes()


def test_train_refuses_wrong_arguments(run, meshes, refused, trained, tmp_path):
    out = ("-o", tmp_path / "f.npz")
    (tmp_path / "text.npz").write_text("hello", encoding="utf-8")
    refused(2, r"no meshes given: add one or more, such as a\.ply b\.ply", "train", *out)
    refused(2, r"no output given: add one, such as -o filter\.npz", "train", *meshes)
    refused(2, "-: a mesh is read from a file", "train", "-", *out)
    refused(
        2, r"f\.bin: learned filters and trainings are written as \.npz", "train", *meshes, "-o", tmp_path / "f.bin"
    )
    refused(
        2,
        r"s\.txt: learned filters and trainings are written as \.npz",
        "train",
        *meshes,
        *out,
        "--state",
        tmp_path / "s.txt",
    )
    refused(2, r"f\.npz: is named twice as an output", "train", *meshes, *out, "--state", tmp_path / "f.npz")
    refused(5, r"mine\.npz: already exists; give another name, or --overwrite", "train", *meshes, "-o", trained)
    refused(3, r"text\.npz: cannot be used as an unfinished training: it is not a \.npz file", "train", *meshes, *out,
            "--state", tmp_path / "text.npz")  # fmt: skip
    three = [word for size in "345" for word in ("--sigma-s", size)]
    refused(
        2,
        "--sigma-s: given 3 times for 2 meshes; give it once, or once for each mesh",
        "train",
        *meshes,
        *out,
        *three,
    )
    refused(2, "--sigma-s 3px: a mesh has no pixels", "train", *meshes, *out, "--sigma-s", "3px")
    refused(2, "--hidden 0: must lie between 1 and 256", "train", *meshes, *out, "--hidden", "0")
    refused(2, "--steps '1.5': must be a whole number", "train", *meshes, *out, "--steps", "1.5")
    refused(3, "missing.obj: no such file", "train", tmp_path / "missing.obj", *out)


def test_arguments_that_a_learned_filter_cannot_take_are_refused(run, meshes, refused, trained, tmp_path):
    for command, out in (("bake", tmp_path / "m"), ("smooth", tmp_path / "s.stl"), ("compare", tmp_path / "c.png")):
        words = (command, meshes[0], "-o", out)
        refused(2, "--model: only applies to --filter learned, found rnf", *words, "--model", trained)
        refused(2, "--sigma-r 0.3: a learned filter has no parameters; leave it out", *words, "--filter", "learned",
                "--sigma-r", "0.3")  # fmt: skip
        words = (*words, "--filter", "learned", "--model")
        refused(3, r"roof0\.obj: cannot be used as a learned filter: it is not a \.npz file", *words, meshes[0])
        missing = tmp_path / "missing.npz"
        refused(3, r"missing\.npz: cannot be used as a learned filter: it cannot be read", *words, missing)


def test_too_few_faces_are_refused(refused, tmp_path):
    mesh = examples()[0].mesh
    few = tmp_path / "few.obj"
    few.write_bytes(obj(mesh.vertices, mesh.faces[:300]))
    refused(
        3,
        "the meshes have only 300 faces in total, but training needs at least 500; give more meshes, or denser ones",
        "train",
        few,
        "-o",
        tmp_path / "f.npz",
    )
