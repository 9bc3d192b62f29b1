"""From meshes through composed maps to reliefs."""

import numpy as np
import pytest
from compose_cases import angles_deg, as_map, from_slopes
from scipy import ndimage

import nmaptool as nm
from nmaptool.core.grid import height_slopes

CAMERA = {"size": "240x240", "pitch": nm.length("1mm"), "renderer": "numpy", "shading": "smooth"}


def bumpy_mesh():
    """A height field of 400 x 400 mm, larger than the image, with edges 2 px long."""
    x, y = np.meshgrid(np.linspace(-200, 200, 201), np.linspace(-200, 200, 201))
    z = 25 * np.exp(-((x / 60) ** 2) - (y / 40) ** 2) + 4 * np.sin(x / 15) * np.cos(y / 20)
    at = np.arange(201 * 201, dtype=np.int32).reshape(201, 201)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, 1:].ravel(), at[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return nm.Mesh(np.stack([x.ravel(), y.ravel(), z.ravel()], 1), faces)


@pytest.fixture(scope="module")
def baked():
    mesh = bumpy_mesh()
    filters = nm.FilterOptions(iterations=1, sigma_s=1.0)
    return {
        roll: nm.bake(mesh, nm.BakeOptions(roll=roll, target="0,0,0", **CAMERA), filters).original for roll in (0, 30)
    }


def test_rotating_a_baked_map_equals_baking_a_rotated_mesh(baked):
    turned = nm.transform(baked[0], nm.TransformOptions(rotate=30, keep_size=True)).normal_map
    seen = turned.coverage == 1
    assert seen.mean() > 0.8
    error = angles_deg(turned.normals, baked[30].normals)[seen]
    assert error.mean() < 0.2
    assert error.max() < 2


@pytest.mark.parametrize(("how", "axis"), [({"flip_h": True}, 0), ({"flip_v": True}, 1)])
def test_mirroring_a_baked_map_equals_baking_a_mirrored_mesh(baked, how, axis):
    mesh = bumpy_mesh()
    sign = np.ones(3)
    sign[axis] = -1
    mirrored = nm.Mesh(mesh.vertices * sign, mesh.faces[:, ::-1].copy())
    filters = nm.FilterOptions(iterations=1, sigma_s=1.0)
    first = nm.bake(mirrored, nm.BakeOptions(target="0,0,0", **CAMERA), filters).original
    error = angles_deg(first.normals, nm.transform(baked[0], nm.TransformOptions(**how)).normal_map.normals)
    assert error.mean() < 0.05


def roof(side=160, rise=0.6):
    """A ridge along the middle, like an edge of a dodecahedron."""
    x = np.arange(side) + 0.5 - side / 2
    p = np.broadcast_to(np.where(x < 0, rise, -rise), (side, side))
    return as_map(from_slopes(p, np.zeros_like(p)), pitch_mm=0.1, name="roof")


def wavy_disc(side=100):
    """A gently sloped motif with fine waves."""
    y, x = np.mgrid[0:side, 0:side] + 0.5 - side / 2
    p, q = 0.3 * np.cos(x / 3), 0.3 * np.sin(y / 4)
    return as_map(from_slopes(p, q), np.hypot(x, y) < side * 0.4, name="motif")


def test_a_motif_on_a_ridge_has_no_step_and_keeps_its_detail():
    ground, motif = roof(), wavy_disc()
    composed = nm.paste(ground, [nm.Layer(motif)])
    options = nm.ReliefOptions(background="surface", beta=0.0001, delta=20)
    relief = nm.relief(composed.normal_map, mask=composed.placed, surface=ground, options=options)
    z = relief.z_mm / relief.pitch_mm
    inner = np.hypot(*(np.mgrid[0:160, 0:160] + 0.5 - 80)) < 32
    p, _ = height_slopes(z)
    asked = -composed.normal_map.normals[..., 0] / composed.normal_map.normals[..., 2]
    # the fine waves keep their shape, across the ridge, too, although the form follows the roof
    made_waves, asked_waves = (a - ndimage.gaussian_filter(a, 6) for a in (p, asked))
    on_ridge = inner & (np.abs(np.arange(160) - 79.5) < 8)
    for where in (inner, on_ridge):
        assert np.corrcoef(made_waves[where], asked_waves[where])[0, 1] > 0.98
        assert np.abs(made_waves[where]).mean() == pytest.approx(np.abs(asked_waves[where]).mean(), rel=0.1)
    assert np.abs(np.diff(z, axis=1))[50:110, 60:100].max() < 0.6 + 0.3  # slopes of roof and waves, no wall
    # and the ground outside is unchanged
    away = np.hypot(*(np.mgrid[0:161, 0:161] - 80.0)) > 42
    own = nm.integrate(ground)
    assert np.abs((z - own)[away] - (z - own)[away].mean()).max() < 1e-3


def test_two_models_on_one_plate_give_their_two_reliefs():
    motif = wavy_disc(60)
    layers = [nm.Layer(motif, nm.LayerOptions(at=at)) for at in ("25%,50%", "75%,50%")]
    both = nm.compose(layers, nm.CanvasOptions(size="200x100", ground="flat", width="100mm"))
    relief = nm.relief(both.normal_map)
    alone = nm.compose(layers[:1], nm.CanvasOptions(size="200x100", ground="flat", width="100mm"))
    single = nm.relief(alone.normal_map)
    assert relief.report.islands == 2
    assert np.abs(relief.z_mm[:, :101] - single.z_mm[:, :101]).max() < 1e-6
    assert np.abs(relief.z_mm[:, :101] - relief.z_mm[:, 100:]).max() < 1e-6
    assert relief.report.foreground_share == pytest.approx(2 * single.report.foreground_share)
