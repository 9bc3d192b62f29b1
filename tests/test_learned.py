"""The learned filter: its parts against their definitions, and its effect on meshes."""

import dataclasses

import numpy as np
import pytest
from learned_cases import DESCRIPTOR, OPTIONS, examples, hilly, network, same, small_filter
from mesh_cases import angles, divided, joined, sheet, sphere

import nmaptool as nm
from nmaptool.filters.descriptor import Describer
from nmaptool.filters.learned.canonical import canonical_frames, in_frames
from nmaptool.filters.learned.fitting import find_clusters, fit_network, nearest_cluster
from nmaptool.filters.learned.model import FilterModel, Stage
from nmaptool.filters.learned.network import Network, Shape, TrainingLoss
from nmaptool.filters.rolling import rolling_guidance
from nmaptool.filters.surface import gather_surface
from nmaptool.meshes.clean import clean_mesh

RNG = np.random.default_rng(3)
TURN = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
TURN *= np.linalg.det(TURN)
MIRROR = TURN @ np.diag([1.0, 1.0, -1.0])


def described(*shape):
    """Descriptors with random unit normals and agreements."""
    agreement = np.random.default_rng(8).uniform(0.5, 1, shape).astype(np.float32)
    return np.concatenate([directions(*shape), agreement[..., None]], axis=-1)


def directions(*shape):
    v = np.random.default_rng(7).normal(size=(*shape, 3)) + np.array([0, 0, 2])
    return (v / np.linalg.norm(v, axis=-1, keepdims=True)).astype(np.float32)


@pytest.mark.parametrize("turn", [TURN, MIRROR], ids=["turned", "mirrored"])
def test_frames_rotate_with_the_normals_and_inputs_do_not(turn):
    given = described(200, 15)
    normals = given[..., :3]
    own = normals.mean(axis=1, dtype=np.float64)
    turned = given.copy()
    turned[..., :3] = normals @ turn.T
    one, other = canonical_frames(given), canonical_frames(turned)
    assert np.allclose(one @ one.swapaxes(-1, -2), np.eye(3), atol=1e-5)
    assert np.allclose(other, one @ turn.T, atol=1e-3)
    assert np.allclose(in_frames(own, given, one), in_frames(own @ turn.T, turned, other), atol=1e-3)
    products = np.einsum("mij,mkj,mkl,mnl->min", one, normals, normals, one)
    size = np.abs(np.einsum("mii->mi", products))
    assert (np.diff(size, axis=1) <= 1e-4).all()  # the first axis is along most of the normals
    assert np.allclose(products, products * np.eye(3), atol=1e-4)
    assert (np.einsum("mij,mj->mi", one, own) >= -1e-6).all()  # each axis points to the side of the mean


def test_inputs_are_own_and_filtered_normals_and_their_agreements():
    given = described(50, 4)
    frames = canonical_frames(given)
    inputs = in_frames(given[:, 1, :3].astype(float), given, frames)
    inside = inputs[:, :15].reshape(50, 5, 3)
    assert np.allclose(np.einsum("mij,mki->mkj", frames, inside[:, 1:]), given[..., :3], atol=1e-6)
    assert np.allclose(inside[:, 0], inside[:, 2], atol=1e-6)
    assert np.array_equal(inputs[:, 15:], given[..., 3])


def test_a_network_mixes_its_input_normals():
    normals = directions(300, 5)
    found = network(mixed=5, more=0)(normals.reshape(300, -1))
    assert np.allclose(np.linalg.norm(found, axis=1), 1, atol=1e-6)
    weights = np.linalg.lstsq(normals[0].T, found[0], rcond=None)[0]
    assert np.allclose(normals[0].T @ weights, found[0], atol=1e-5)
    one_kind = np.repeat(normals[:, :1], 5, axis=1).reshape(300, -1)
    more = np.random.default_rng(2).normal(size=(300, 4)).astype(np.float32)
    assert (
        angles(network(mixed=5)(np.hstack([one_kind, more])), normals[:, 0]).max() < 0.05
    )  # equal normals give themselves
    picks = Network(*(np.zeros(s, np.float32) for s in ((2, 15), (2,), (5, 2))), np.float32([0, 0, 60, 0, 0]))
    assert np.allclose(picks(normals.reshape(300, -1)), normals[:, 2], atol=1e-6)


def test_the_gradient_matches_the_loss():
    more = np.random.default_rng(2).uniform(size=(5000, 2)).astype(np.float32)
    inputs, targets = np.hstack([directions(5000, 4).reshape(5000, -1), more]), directions(5000)
    shape = Shape(inputs=14, hidden=3, mixed=4)
    lesson = TrainingLoss(inputs, targets, inputs.mean(axis=0, dtype=float), inputs.std(axis=0, dtype=float))
    flat = np.random.default_rng(1).normal(size=shape.weights) * 0.7
    _, slope = lesson.loss(flat, shape, 1e-3)
    for k in range(0, len(flat), 3):
        step = np.zeros_like(flat)
        step[k] = 0.02
        rise = (lesson.loss(flat + step, shape, 1e-3)[0] - lesson.loss(flat - step, shape, 1e-3)[0]) / 0.04
        assert slope[k] == pytest.approx(rise, rel=0.02, abs=2e-5)


def test_the_loss_is_computed_on_the_normalised_normal():
    normals = directions(400, 4)
    lesson = TrainingLoss(normals.reshape(400, -1), normals[:, 1], np.zeros(12), np.ones(12))
    shape = Shape(inputs=12, hidden=2, mixed=4)
    flat = np.zeros(shape.weights)
    mean = normals.mean(axis=1)
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    assert lesson.loss(flat, shape, 0.0)[0] == pytest.approx(((mean - normals[:, 1]) ** 2).sum(axis=1).mean(), rel=1e-4)


def test_a_network_learns_which_of_its_normals_is_right():
    normals = directions(3000, 4)
    right = np.where(normals[:, :1, 0] > 0, normals[:, 1], normals[:, 3])
    inputs = normals.reshape(3000, -1)
    shares = []
    learned, loss = fit_network(
        inputs,
        right,
        mixed=4,
        hidden=4,
        steps=150,
        weight_decay=0,
        rng=np.random.default_rng(0),
        step_done=shares.append,
    )
    blind = normals.mean(axis=1)
    blind /= np.linalg.norm(blind, axis=1, keepdims=True)
    assert angles(learned(inputs), right).mean() < 0.25 * angles(blind, right).mean()
    assert loss == pytest.approx(((learned(inputs) - right) ** 2).sum(axis=1).mean(), rel=1e-3, abs=1e-9)
    assert shares == sorted(shares)
    assert 0 < shares[0] <= shares[-1] <= 1


def test_clusters_are_found_and_assigned_by_the_nearest_centre():
    rng = np.random.default_rng(0)
    groups = (np.float32([[0, 0], [9, 0], [0, 9]])[:, None] + rng.normal(size=(3, 100, 2))).astype(np.float32)
    centers = find_clusters(groups.reshape(-1, 2), 3, np.random.default_rng(1))
    kinds = nearest_cluster(groups.reshape(-1, 2), centers).reshape(3, 100)
    assert all(len(set(kind)) == 1 for kind in kinds.tolist())
    assert len(set(kinds[:, 0])) == 3


def test_descriptors_match_the_filtered_normals():
    """They match those of gather_surface, except for how finely patches are divided."""
    mesh = clean_mesh(hilly(5))[0]
    normals = mesh.geometry.normals
    found = Describer(mesh, DESCRIPTOR)()
    led = Describer(mesh, DESCRIPTOR)(found[:, 0, :3].astype(float))
    for place, (size, likeness) in enumerate((s, r) for s in DESCRIPTOR.sigma_s for r in DESCRIPTOR.sigma_r):
        gather = gather_surface(mesh, size * mesh.mean_edge, likeness)
        exact = rolling_guidance(normals, gather, 2)
        assert angles(found[:, place, :3], exact).mean() < 0.5
        sums = gather(found[:, 0, :3].astype(float))
        length = np.linalg.norm(sums[:, :3], axis=1)
        assert angles(led[:, place, :3], sums[:, :3] / length[:, None]).mean() < 0.5
        assert np.abs(led[:, place, 3] - length / sums[:, 3]).mean() < 0.01
    assert angles(found[:, 0, :3], found[:, 3, :3]).mean() > 3


def test_every_stage_gets_closer_to_the_targets():
    before, *after = small_filter().metadata["mean_angle_deg"]
    assert after[0] < 0.7 * before
    assert after[1] < after[0] + 0.1
    new = nm.training_example(hilly(9), nm.FilterOptions(filter="grnf"))
    found = nm.decompose_normals(new.mesh, nm.FilterOptions(filter="learned"), model=small_filter())
    assert angles(found.base, new.targets).mean() < 0.7 * angles(found.normals, new.targets).mean()


@pytest.mark.parametrize("turn", [TURN, MIRROR], ids=["turned", "mirrored"])
def test_the_learned_base_rotates_with_the_mesh(turn):
    mesh = clean_mesh(hilly(9))[0]
    faces = mesh.faces if np.linalg.det(turn) > 0 else np.ascontiguousarray(mesh.faces[:, ::-1])
    options = nm.FilterOptions(filter="learned")
    one = nm.decompose_normals(mesh, options)
    other = nm.decompose_normals(nm.Mesh(mesh.vertices @ turn.T + 5, faces), options)
    assert angles(one.normals, one.base).mean() > 1
    error = angles(one.base @ turn.T, other.base)
    assert np.percentile(error, 99) < 0.5
    assert error.mean() < 0.05


def test_size_and_unit_do_not_change_the_learned_base():
    mesh = clean_mesh(hilly(9))[0]
    options = nm.FilterOptions(filter="learned")
    one, other = (nm.decompose_normals(nm.Mesh(mesh.vertices * s, mesh.faces), options).base for s in (1.0, 1000.0))
    assert angles(one, other).mean() < 0.01


def test_the_shipped_filter_removes_bumps_and_keeps_forms():
    """A bumpy sphere, a smooth sphere and a box, without any parameter."""
    options = nm.FilterOptions(filter="learned")
    ball = sphere(30)
    v = ball.vertices
    bumps = 0.02 * np.sin(40 * v[:, :1]) * np.sin(40 * v[:, 1:2]) * np.sin(40 * v[:, 2:])
    rough = nm.decompose_normals(nm.Mesh(v * (1 + bumps), ball.faces), options)
    true = ball.geometry.normals
    before = angles(rough.normals, true).mean()
    assert before > 12
    assert angles(rough.filtered, true).mean() < 0.25 * before
    assert angles(rough.base, true).mean() < 0.3 * before
    assert angles(nm.decompose_normals(ball, options).base, true).mean() < 0.1
    side = sheet(lambda x, y: 0 * x + 8, 16, 16).vertices
    box = clean_mesh(
        joined(
            *(
                nm.Mesh(
                    np.roll(side * [1, 1, s] * [s, 1, 1], k, axis=1),
                    sheet(lambda x, y: 0 * x, 16, 16).faces,
                )
                for k in range(3)
                for s in (1.0, -1.0)
            )
        )
    )[0]
    kept = nm.decompose_normals(box, options)
    assert angles(kept.base, kept.normals).max() < 0.1
    assert angles(kept.filtered, kept.normals).mean() < 0.5


def test_refining_the_mesh_changes_the_learned_base_little():
    mesh = clean_mesh(hilly(9))[0]
    options = nm.FilterOptions(filter="learned")
    one = nm.decompose_normals(mesh, options)
    fine = nm.decompose_normals(divided(mesh), options)
    moved = angles(np.repeat(one.base, 4, axis=0), fine.base).mean()
    assert moved < 0.5 * angles(one.base, one.normals).mean()


def test_base_and_residual_give_the_original_bit_for_bit():
    found = nm.decompose_normals(hilly(9), nm.FilterOptions(filter="learned"))
    assert np.array_equal(found.base + found.residual, found.normals)
    assert np.array_equal(found.is_detail, np.linalg.norm(found.normals - found.filtered, axis=1) > found.mixture.theta)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sigma_s": 5.0}, "`sigma_s=5.0`: a learned filter has no parameters; leave it out, or use `filter='grnf'`"),
        ({"sigma_r": 0.3}, "`sigma_r=0.3`: a learned filter has no parameters"),
        ({"iterations": 3}, "`iterations=3`: a learned filter has no parameters"),
        ({"neighborhood": "ring"}, "`neighborhood='ring'`: a learned filter has no parameters"),
    ],
)
def test_a_learned_filter_takes_no_parameters(changes, message):
    with pytest.raises(nm.UsageError, match=message):
        nm.FilterOptions(filter="learned", **changes)


def test_a_model_is_refused_by_other_filters():
    with pytest.raises(nm.UsageError, match="`model`: only applies to `filter='learned'`, found rnf"):
        nm.decompose_normals(hilly(0), model=small_filter())
    with pytest.raises(nm.UsageError, match="`model`: only applies to `filter='learned'`, found grnf"):
        nm.bake(hilly(0), filter=nm.FilterOptions(filter="grnf"), model=small_filter())


def test_inconsistent_models_are_refused():
    good = network()
    with pytest.raises(nm.InputError, match=r"the weights b1 must be float32 \(3,\); found float32 \(4,\)"):
        dataclasses.replace(good, b1=np.zeros(4, np.float32))
    with pytest.raises(nm.InputError, match=r"the weights w1 must be float32 .*; found float64"):
        dataclasses.replace(good, w1=good.w1.astype(float))
    with pytest.raises(nm.InputError, match="the weights w2 must be finite"):
        dataclasses.replace(good, w2=good.w2 * np.float32(np.nan))
    centers = np.zeros((2, 19), np.float32)
    with pytest.raises(nm.InputError, match="a stage needs one network per cluster: networks 1, clusters 2"):
        Stage(centers, (good,))
    with pytest.raises(
        nm.InputError, match=r"the cluster centres must be finite float32 \(K, C\); found float64 \(2, 19\)"
    ):
        Stage(centers.astype(float), (good, good))
    with pytest.raises(nm.InputError, match="a network has 19 inputs, but the cluster centres have 21"):
        Stage(np.zeros((2, 21), np.float32), (good, good))
    with pytest.raises(nm.InputError, match="a learned filter needs at least one stage"):
        FilterModel(DESCRIPTOR, ())
    mixes = network(mixed=4, more=7)
    with pytest.raises(nm.InputError, match="a network mixes 4 normals, expected 5"):
        FilterModel(DESCRIPTOR, (Stage(centers, (mixes, mixes)),))
    with pytest.raises(nm.InputError, match="a network has 19 inputs, but the descriptor has 63"):
        FilterModel(nm.DescriptorOptions(), (Stage(centers, (good, good)),))


def test_the_seed_determines_the_filter():
    again = nm.train(examples(), OPTIONS, descriptor=DESCRIPTOR)
    assert same(again, small_filter())
    other = nm.train(examples(), dataclasses.replace(OPTIONS, seed=2), descriptor=DESCRIPTOR)
    assert not same(other, small_filter())
