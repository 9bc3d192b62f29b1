"""Training: resumed runs give the same result, and invalid training data are refused."""

import dataclasses

import numpy as np
import pytest
from learned_cases import DESCRIPTOR, OPTIONS, examples, same, small_filter
from mesh_cases import sheet

import nmaptool as nm


def states():
    """The saved training states of `small_filter`, one per network."""
    kept = []
    model = nm.train(examples(), OPTIONS, descriptor=DESCRIPTOR, keep=kept.append)
    assert same(model, small_filter())
    return kept


def test_training_resumed_from_any_state_gives_the_same_filter(tmp_path):
    kept = states()
    assert [(len(s.stages), len(s.networks)) for s in kept] == [(0, 1), (1, 0), (1, 1), (2, 0)]
    for number, state in enumerate(kept):
        file = tmp_path / f"{number}.npz"
        nm.write_training(state, file)
        read = nm.read_training(file)
        assert read.fingerprint == state.fingerprint
        assert read.losses == state.losses
        assert [len(s.networks) for s in read.stages] == [len(s.networks) for s in state.stages]
        more = []
        again = nm.train(examples(), OPTIONS, descriptor=DESCRIPTOR, state=read, keep=more.append)
        assert same(again, small_filter())
        assert again.metadata == small_filter().metadata
        assert len(more) == len(kept) - number - 1  # finished networks are not trained again


def test_a_state_from_another_training_is_refused():
    state = states()[0]
    for others, changes in ((examples(1), {}), (examples(), {"hidden": 5}), (examples(), {"seed": 4})):
        with pytest.raises(
            nm.InputError,
            match="the state: belongs to a training with other meshes or options; use the same ones, or another",
        ):
            nm.train(others, dataclasses.replace(OPTIONS, **changes), descriptor=DESCRIPTOR, state=state)


def test_the_metadata_state_how_a_filter_was_made():
    metadata = small_filter().metadata
    assert metadata["options"]["seed"] == OPTIONS.seed
    assert [mesh["name"] for mesh in metadata["meshes"]] == ["roof 0", "roof 1"]
    assert [mesh["faces"] for mesh in metadata["meshes"]] == [1152, 1152]
    assert metadata["meshes"][0]["filter"] == "grnf"
    assert len(metadata["losses"]) == OPTIONS.stages * OPTIONS.clusters
    assert len(metadata["mean_angle_deg"]) == 1 + OPTIONS.stages


def test_the_targets_of_an_example_are_the_grnf_base():
    mesh = examples()[0].mesh
    options = nm.FilterOptions(filter="grnf")
    base = nm.decompose_normals(mesh, options).base
    assert np.array_equal(examples()[0].targets, base)
    assert not np.array_equal(nm.training_example(mesh, nm.FilterOptions(filter="grnf", sigma_s=1.5)).targets, base)


def test_progress_increases_to_the_end():
    told = []
    nm.train(examples(), OPTIONS, descriptor=DESCRIPTOR, progress=lambda word, share: told.append((word, share)))
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert 0 <= shares[0] < 0.1
    assert 0.9 < shares[-1] <= 1
    assert {word for word, _ in told} == {f"stage {k}, {work}" for k in (1, 2) for work in ("describing", "fitting")}


def test_invalid_training_data_are_refused():
    mesh = nm.clean_mesh(sheet(lambda x, y: 0 * x, 4, 4))[0]
    flat = nm.TrainingExample(mesh, np.tile([0, 0, 1.0], (32, 1)))
    with pytest.raises(
        nm.InputError, match="the meshes have only 32 faces in total, but training needs at least 500; give more"
    ):
        nm.train([flat])
    with pytest.raises(nm.InputError, match=r"mesh: targets must have shape \(32, 3\); found \(31, 3\)"):
        nm.TrainingExample(mesh, flat.targets[1:])
    with pytest.raises(nm.InputError, match="mesh: targets must be finite and of unit length"):
        nm.TrainingExample(mesh, flat.targets * 1.1)
    with pytest.raises(nm.InputError, match="mesh: targets must be finite and of unit length"):
        nm.TrainingExample(mesh, flat.targets * np.nan)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stages": 0}, "`stages=0`: must lie between 1 and 10"),
        ({"clusters": 65}, "`clusters=65`: must lie between 1 and 64"),
        ({"hidden": 0}, "`hidden=0`: must lie between 1 and 256"),
        ({"steps": 0}, "`steps=0`: must lie between 1 and 100000"),
        ({"samples": 0}, "`samples=0`: must lie between 1 and 10000000"),
        ({"weight_decay": -1.0}, "`weight_decay=-1`: must lie between 0 and 1, such as 1e-4"),
        ({"seed": -1}, "`seed=-1`: must lie between 0 and 4294967295"),
    ],
)
def test_invalid_train_options_are_refused(changes, message):
    with pytest.raises(nm.UsageError, match=message):
        nm.TrainOptions(**changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sigma_s": ()}, "`sigma_s`: found 0 values, expected 1 to 16"),
        ({"sigma_s": (0.0,)}, "`sigma_s=0`: must lie between 0.1 and 1000"),
        ({"sigma_r": (0.2, np.nan)}, "`sigma_r=nan`: must lie between 0.01 and 10"),
        ({"passes": 0}, "`passes=0`: must lie between 1 and 20"),
    ],
)
def test_invalid_descriptors_are_refused(changes, message):
    with pytest.raises(nm.UsageError, match=message):
        nm.DescriptorOptions(**changes)
