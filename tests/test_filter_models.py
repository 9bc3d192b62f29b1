"""Files of learned filters: equal filters give equal bytes, no code is executed, damage is reported in one line."""

import io
import pickle
import zipfile

import numpy as np
import pytest
from learned_cases import DESCRIPTOR, network, same, small_filter

import nmaptool as nm
from nmaptool.filters.learned.arrays import filter_to_arrays
from nmaptool.filters.learned.model import FilterModel, Stage


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "f.npz"
    nm.write_filter_model(small_filter(), path)
    return path


def test_a_filter_is_read_back_unchanged(file, tmp_path):
    read = nm.read_filter_model(file)
    assert same(read, small_filter())
    assert read.descriptor == DESCRIPTOR
    assert read.metadata == small_filter().metadata
    nm.write_filter_model(read, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == file.read_bytes()


def test_the_digest_distinguishes_filters():
    stage = Stage(np.zeros((1, 19), np.float32), (network(),))
    other = Stage(np.zeros((1, 19), np.float32), (network(seed=1),))
    one = FilterModel(DESCRIPTOR, (stage,), {"name": "a"})
    assert same(one, FilterModel(DESCRIPTOR, (stage,), {"name": "b"}))
    assert not same(one, FilterModel(DESCRIPTOR, (other,)))
    assert not same(one, FilterModel(DESCRIPTOR, (stage, stage)))
    assert len(one.digest) == 12


def test_existing_files_are_not_overwritten(file):
    with pytest.raises(nm.OutputError, match=r"f\.npz: already exists; give another name, or `overwrite`"):
        nm.write_filter_model(small_filter(), file)
    nm.write_filter_model(small_filter(), file, overwrite=True)
    with pytest.raises(nm.UsageError, match=r"f\.bin: learned filters and trainings are written as \.npz"):
        nm.write_filter_model(small_filter(), file.with_suffix(".bin"))


class Touch:
    """Code that a pickle would run."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return (open, (self.path, "w"))


def npz(path, arrays):
    with path.open("wb") as stream:
        np.savez(stream, **arrays)


def without(name):
    return {key: value for key, value in filter_to_arrays(small_filter()).items() if key != name}


def header(text):
    return without("header") | {"header": np.frombuffer(text, np.uint8)}


def deflated_zeros(path):
    held = io.BytesIO()
    np.lib.format.write_array(held, np.zeros(9_000_000))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("header.npy", held.getvalue())


def many_arrays(path):
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(4001):
            archive.writestr(f"{number}.npy", b"")


@pytest.mark.parametrize(
    ("write", "message"),
    [
        (lambda p: None, r"it cannot be read \(No such file or directory\)"),
        (lambda p: p.write_bytes(b"hello"), "it is not a .npz file, or it is damaged"),
        (lambda p: p.write_bytes(b""), "it is not a .npz file, or it is damaged"),
        (many_arrays, "it has 4001 arrays, more than the limit of 4000$"),
        (deflated_zeros, "it unpacks to more than the limit of 64000000 bytes"),
        (lambda p: npz(p, {"a": np.zeros(3)}), r"it is not a filter of nmaptool \(its header is missing or damaged\)"),
        (lambda p: npz(p, header(b"[1]")), r"it is not a filter of nmaptool \(its header is missing or damaged\)"),
        (lambda p: npz(p, header(b'{"kind": "cake"}')), "its header says 'cake', expected 'nmaptool filter 1'"),
        (lambda p: npz(p, header(b'{"kind": "nmaptool filter 1"}')), "its header lacks a value or has an invalid one"),
        (
            lambda p: npz(p, header(b'{"kind": "nmaptool filter 1", "descriptor": {"sigma_s": [0]}}')),
            "its header lacks a value or has an invalid one",
        ),
        (lambda p: npz(p, without("stage1_centers")), "it lacks the array 'stage1_centers'"),
        (lambda p: npz(p, without("stage0_network1_w2")), "it lacks the array 'stage0_network1_w2'"),
        (
            lambda p: npz(p, without("stage0_centers") | {"stage0_centers": np.zeros((2, 20), np.float32)}),
            "a network has 19 inputs, but the cluster centres have 20",
        ),
    ],
)
def test_files_that_are_not_filters_are_refused(tmp_path, write, message):
    path = tmp_path / "f.npz"
    write(path)
    with pytest.raises(nm.InputError, match=rf"f\.npz: cannot be used as a learned filter: {message}"):
        nm.read_filter_model(path)


def test_pickled_objects_are_refused_and_not_run(tmp_path):
    mark = tmp_path / "run"
    npz(tmp_path / "f.npz", {"header": np.array([Touch(mark)], object)})
    (tmp_path / "g.npz").write_bytes(pickle.dumps(Touch(tmp_path / "run")))
    mark.unlink(missing_ok=True)
    for name in ("f.npz", "g.npz"):
        with pytest.raises(nm.InputError, match=r"it is not a \.npz file, or it is damaged"):
            nm.read_filter_model(tmp_path / name)
    assert not mark.exists()


def test_damaged_files_give_an_input_error_or_a_sound_filter(file):
    """Files cut or with bits flipped anywhere give an InputError or a sound filter."""
    data = file.read_bytes()
    rng = np.random.default_rng(0)
    damaged = file.with_name("damaged.npz")
    outcomes = {"read": 0, "refused": 0}
    for _ in range(150):
        broken = bytearray(data[: rng.integers(1, len(data))] if rng.random() < 0.3 else data)
        broken[rng.integers(len(broken))] ^= 1 << rng.integers(8)
        damaged.write_bytes(bytes(broken))
        try:
            nm.read_filter_model(damaged)
            outcomes["read"] += 1
        except nm.InputError:
            outcomes["refused"] += 1
    assert outcomes["refused"] > 100


def test_training_states_and_filters_are_not_confused(file, tmp_path):
    with pytest.raises(
        nm.InputError, match="unfinished training: its header says 'nmaptool filter 1', expected 'nmaptool training 1'"
    ):
        nm.read_training(file)
    nm.write_training(nm.TrainingState("abc"), tmp_path / "t.npz")
    assert nm.read_training(tmp_path / "t.npz").fingerprint == "abc"
    with pytest.raises(
        nm.InputError, match="filter: its header says 'nmaptool training 1', expected 'nmaptool filter 1'"
    ):
        nm.read_filter_model(tmp_path / "t.npz")


def test_the_shipped_filter_is_small_and_states_how_it_was_made():
    from importlib.resources import files

    data = files("nmaptool.filters.learned").joinpath("filter.npz").read_bytes()
    assert len(data) < 2_000_000
    metadata = nm.shipped_filter().metadata
    assert len(metadata["meshes"]) >= 23
    assert metadata["options"] == {name: getattr(nm.TrainOptions(), name) for name in metadata["options"]}
    assert nm.shipped_filter().descriptor == nm.DescriptorOptions()
    assert len(nm.shipped_filter().stages) == 3
    assert {len(stage.networks) for stage in nm.shipped_filter().stages} == {4}
