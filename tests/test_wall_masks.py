"""Walls for some layers or some parts of a motif: the wall mask, from a recipe to the solid."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from solid_cases import check_solid, crossings

import nmaptool as nm
from nmaptool.core.grid import dilated, touching_vertices


def plate(rows=40, cols=60):
    """(H, W, 3) flat normals."""
    normals = np.zeros((rows, cols, 3), np.float32)
    normals[..., 2] = 1
    return normals


def two_parts():
    """Normals with a dome at the left and a flat slab at the right, the motif, and the mask of the slab."""
    normals = plate()
    y, x = np.mgrid[-19.5:20, -14.5:45]
    dome = np.hypot(x, y) < 12
    normals[dome, 0], normals[dome, 1] = x[dome] / 12, -y[dome] / 12
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    slab = np.zeros(dome.shape, bool)
    slab[8:32, 36:52] = True
    return normals, dome | slab, slab


def walls(**values):
    return nm.ReliefOptions(edge="wall", width=nm.length("60mm"), **values)


def test_only_the_masked_part_stands():
    normals, motif, slab = two_parts()
    options = walls(height=nm.length("4mm"), edge_height=nm.length("2mm"))
    relief = nm.relief(normals, options=options, mask=motif, wall_mask=slab)
    assert np.array_equal(relief.height.raised, slab)
    assert relief.z_mm[touching_vertices(slab)] == pytest.approx(2, abs=0.01)
    dome = motif & ~slab
    assert relief.z_mm[touching_vertices(dome) & touching_vertices(~motif)] == pytest.approx(0, abs=1e-12)
    assert relief.z_mm[touching_vertices(dome)].max() == pytest.approx(4)
    assert relief.report.edge_height_mm == pytest.approx(2)
    # the dome is that of the whole motif with its outline held
    held = nm.relief(normals, options=nm.ReliefOptions(width=nm.length("60mm")), mask=motif)
    found, expected = (each.z_mm[touching_vertices(dome)] for each in (relief, held))
    assert found / found.max() == pytest.approx(expected / expected.max(), abs=1e-6)


def test_a_pixel_of_plate_lies_between_what_stands_and_what_does_not():
    normals = plate()
    motif = np.zeros((40, 60), bool)
    motif[10:30, 10:50] = True
    right = motif & (np.arange(60) >= 30)
    relief = nm.relief(normals, options=walls(height=nm.length("3mm")), mask=motif, wall_mask=right)
    assert not (relief.foreground & dilated(right, 1) & ~right).any()
    centres = relief.height.at_pixels()
    assert (centres[10:30, 29] == 0).all()
    solid = nm.solid(relief, nm.SolidOptions(base=nm.length("2mm")))
    check_solid(solid)
    assert solid.size_mm == pytest.approx((60, 40, 5))


def test_random_wall_masks_give_manifold_solids(trials):
    backs = (
        {"base": "8mm"},
        {"base": "8mm", "hollow": "1mm"},
        {"shell": "1mm"},
        {"base": "8mm", "max_error": "0.05mm"},
    )
    for seed in range(trials(200)):
        rng = np.random.default_rng(seed)
        shape = rng.integers(6, 50, 2)

        def noise(blur, rng=rng, shape=shape):
            field = ndimage.gaussian_filter(rng.standard_normal(shape), blur)
            return field / field.std()

        coverage = np.clip(noise(rng.choice([1, 2, 3])) * rng.choice([1, 5]) + 0.7, 0, 1).astype(np.float32)
        wall_mask = noise(rng.choice([1, 3])) > 0
        normals = np.dstack([0.3 * noise(2), 0.3 * noise(2), np.ones(shape)])
        options = walls(height=nm.length("3mm"), beta=0.05, per_pixel=True, delta=5.0)
        if not (wall_mask & (coverage >= 0.5)).any():
            continue
        relief = nm.relief(normals, options=options, mask=coverage, wall_mask=wall_mask)
        lengths = {name: nm.length(text) for name, text in backs[seed % 4].items()}
        solid = nm.solid(relief, nm.SolidOptions(outline=("auto", "exact", "smooth")[seed % 3], **lengths))
        check_solid(solid)
        if shape.prod() < 220:
            mesh = solid.to_mesh()
            assert crossings(mesh.vertices, mesh.faces) == 0, seed


def test_masks_that_cannot_be_are_refused():
    normals, motif, slab = two_parts()
    with pytest.raises(nm.UsageError, match="`wall_mask`: needs `edge='wall'`"):
        nm.relief(normals, mask=motif, wall_mask=slab)
    with pytest.raises(nm.InputError, match="the wall mask selects nothing of the motif: paint what stands with walls"):
        nm.relief(normals, options=walls(), mask=motif, wall_mask=~motif)
    with pytest.raises(nm.InputError, match="is 60 x 40 pixels but the wall mask is 30 x 30"):
        nm.relief(normals, options=walls(), mask=motif, wall_mask=np.ones((30, 30), bool))
    # a mask chooses walls where "auto" would not
    relief = nm.relief(normals, options=nm.ReliefOptions(edge="auto"), mask=motif, wall_mask=slab)
    assert relief.report.edge == "wall"


def layer(mask, edge="blend", **more):
    """A flat layer of the size of the plate."""
    normal_map = nm.NormalMap.from_array(plate(), mask)
    return nm.Layer(normal_map, nm.LayerOptions(edge=edge, **more))


def square(left, right):
    mask = np.zeros((40, 60), bool)
    mask[10:30, left:right] = True
    return mask


def test_the_walls_of_a_composition_are_its_layers_with_walls():
    ground = nm.NormalMap.from_array(plate())
    both = nm.paste(ground, [layer(square(5, 20)), layer(square(30, 50), "wall")])
    assert np.array_equal(both.walls, square(30, 50))
    assert np.array_equal(both.placed, square(5, 20) | square(30, 50))
    # a layer without walls hides those below it, a mode that adds detail does not
    hidden = nm.paste(ground, [layer(square(30, 50), "wall"), layer(square(40, 55))])
    assert np.array_equal(hidden.walls, square(30, 40))
    kept = nm.paste(ground, [layer(square(30, 50), "wall"), layer(square(40, 55), mode="rnm")])
    assert np.array_equal(kept.walls, square(30, 50))
    faded = nm.paste(ground, [layer(square(30, 50), "wall", strength=0.25)])
    assert faded.walls[20, 40] == pytest.approx(0.25)


def test_a_group_keeps_the_walls_of_its_layers():
    ground = nm.NormalMap.from_array(plate())
    group = nm.LayerGroup([layer(square(5, 20)), layer(square(30, 50), "wall")], mask=np.float32(square(0, 40)))
    assert np.array_equal(nm.paste(ground, [group]).walls, square(30, 40))


def test_from_a_recipe_to_a_solid(tmp_path, run, codes, png):
    rng = np.random.default_rng(4)
    slopes = [0.2 * ndimage.gaussian_filter(rng.standard_normal((20, 20)), 3) for _ in range(2)]
    leaf = np.dstack([*slopes, np.ones((20, 20))])
    leaf /= np.linalg.norm(leaf, axis=-1, keepdims=True)
    png(tmp_path / "leaf.png", np.dstack([codes(leaf), np.full((20, 20), 255, np.uint8)]))
    (tmp_path / "scene.toml").write_text(
        '[canvas]\nsize = "80x40"\nwidth = "80mm"\n'
        '[[layer]]\nfile = "leaf.png"\nat = "20px,20px"\n'
        '[[layer]]\nfile = "leaf.png"\nat = "60px,20px"\nedge = "wall"\n',
        encoding="utf-8",
    )
    scene, mask = tmp_path / "scene.exr", tmp_path / "walls.png"
    assert run("compose", "stack", tmp_path / "scene.toml", "-o", scene, "--walls", mask).code == 0
    words = ("relief", scene, "--edge", "wall", "--wall-mask", mask, "--height", "4mm", "--edge-height", "3mm")
    done = run(*words, "-o", tmp_path / "scene.stl", "--base", "2mm")
    assert done.code == 0, done.err
    assert "edge: a wall of 3 mm on average" in done.err
    mesh = nm.read_mesh(tmp_path / "scene.stl")
    x, _, z = mesh.vertices.T
    # the right leaf stands 3 mm high on average, the left one begins at the plate
    assert z[(np.abs(x - 60) < 9) & (z > 0)].min() > 2
    assert 0 < z[(np.abs(x - 20) < 9) & (z > 0)].min() < 1


def test_a_picture_of_walls_needs_a_layer_with_walls(tmp_path, refused, codes, png):
    png(tmp_path / "slab.png", codes(plate(20, 20)))
    (tmp_path / "scene.toml").write_text('[[layer]]\nfile = "slab.png"\n', encoding="utf-8")
    words = ("compose", "stack", tmp_path / "scene.toml", "-o", tmp_path / "a.exr", "--walls", tmp_path / "w.png")
    refused(2, r"w\.png: no layer has walls; give one --edge wall", *words)
