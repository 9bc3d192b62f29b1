"""Changes that an editor made to a layer: detected from codes, signature and curl, and repaired where possible."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from workspace_cases import bumpy, codes_found, codes_of, packed, recolored, turned_freely

import nmaptool as nm
from nmaptool.core.vectors import unit


def message(workspace, code):
    return next(finding for finding in nm.unpack(workspace).findings if finding.code == code)


def test_an_untouched_workspace_has_no_finding():
    workspace = packed()
    unpacked = nm.unpack(workspace)
    assert unpacked.findings == ()
    assert unpacked.has_metadata
    assert [layer.repairs for layer in unpacked.layers] == [(), ()]
    step = np.abs(unpacked.layers[0].normal_map.normals - bumpy().normals)
    assert step.max() < 2 / 65535
    outside = bumpy().coverage <= 0
    assert np.all(unpacked.layers[0].normal_map.normals[outside] == (0, 0, 1))


TURNS = {
    "flip-h": (lambda a: a[:, ::-1], "mirrored left to right", "`flip_h` `vectors_only`"),
    "flip-v": (lambda a: a[::-1], "mirrored top to bottom", "`flip_v` `vectors_only`"),
    "90": (
        lambda a: np.rot90(a, 1),
        "90 degrees counter-clockwise, but its vectors were not",
        "`rotate=90` `vectors_only`",
    ),
    "180": (lambda a: np.rot90(a, 2), "180 degrees", "`rotate=180` `vectors_only`"),
    "270": (lambda a: np.rot90(a, 3), "90 degrees clockwise, but its vectors were not", "`rotate=-90` `vectors_only`"),
    "transpose": (lambda a: a.swapaxes(0, 1), "clockwise and mirrored", "`rotate=-90` `flip_h` `vectors_only`"),
    "antitranspose": (
        lambda a: np.rot90(a, 2).swapaxes(0, 1),
        "counter-clockwise and mirrored",
        "`rotate=90` `flip_h`",
    ),
}


@pytest.mark.parametrize("turn", TURNS)
def test_a_layer_turned_without_its_normals_is_detected(turn):
    picture, metadata, remedy = TURNS[turn]
    pixels = np.ascontiguousarray(picture(packed().layers[0].pixels))
    workspace = packed(pixels=pixels)
    assert codes_found(workspace) == {("turned", "bumpy")}
    finding = message(workspace, "turned")
    assert metadata in finding.message
    assert remedy in finding.remedy


@pytest.mark.parametrize(("turn", "x", "y"), [("flip-h", -1, 1), ("flip-v", 1, -1), ("180", -1, -1)])
def test_a_layer_turned_with_its_normals_is_accepted(turn, x, y):
    pixels = TURNS[turn][0](packed().layers[0].pixels).astype(np.int64)
    for channel, sign in enumerate((x, y)):
        if sign < 0:
            pixels[..., channel] = 65535 - pixels[..., channel]
    assert codes_found(packed(pixels=pixels.astype(np.uint16))) == set()


@pytest.mark.parametrize("degrees", [20, -35, 70])
def test_a_layer_turned_by_any_angle_without_its_normals_is_detected(degrees):
    workspace = packed(pixels=turned_freely(packed().layers[0].pixels, degrees))
    assert codes_found(workspace) == {("turned-freely", "bumpy")}
    finding = message(workspace, "turned-freely")
    told = float(finding.remedy.partition("`rotate=")[2].partition("`")[0])
    assert told == pytest.approx(degrees, abs=0.7)
    assert ("counter-clockwise" in finding.message) == (degrees > 0)


def test_a_turn_by_any_angle_is_detected_without_metadata():
    workspace = replace(packed(pixels=turned_freely(packed().layers[0].pixels, 20)), metadata=None)
    assert codes_found(workspace) == {("turned-freely", "bumpy")}
    assert not nm.unpack(workspace).has_metadata


def test_a_moved_layer_is_reported_and_kept():
    workspace = packed(left=13, top=-7)
    assert codes_found(workspace) == {("moved", "bumpy")}
    assert "+13 px across and -7 px down; its vectors are still correct" in message(workspace, "moved").message
    assert (nm.unpack(workspace).layers[0].left, nm.unpack(workspace).layers[0].top) == (13, -7)


def test_a_layer_trimmed_to_its_content_is_not_reported_as_moved():
    pixels = packed().layers[0].pixels
    seen = np.argwhere(pixels[..., 3] > 0)
    (top, left), (bottom, right) = seen.min(axis=0), seen.max(axis=0) + 1
    workspace = packed(pixels=pixels[top:bottom, left:right].copy(), left=int(left), top=int(top))
    assert codes_found(workspace) == set()


def test_only_uneven_scaling_is_reported():
    pixels = packed().layers[0].pixels
    uneven = packed(pixels=cv2.resize(pixels, (180, 100), interpolation=cv2.INTER_AREA))
    assert codes_found(uneven) == {("stretched", "bumpy")}
    assert "was scaled by 1.00 across and 0.63 down" in message(uneven, "stretched").message
    even = packed(pixels=cv2.resize(pixels, (90, 80), interpolation=cv2.INTER_AREA))
    assert codes_found(even) == set()  # even scaling keeps slopes


def test_eight_bit_codes_are_detected():
    _, pixels = codes_of(packed())
    eight = np.rint(pixels / 257)
    assert codes_found(packed(pixels=eight.astype(np.uint8))) == {("eight-bit", "bumpy")}
    assert codes_found(packed(pixels=(eight * 257).astype(np.uint16))) == {("eight-bit", "bumpy")}
    photoshop = np.rint(np.rint(pixels / 65535 * 32768) / 32768 * 65535).astype(np.uint16)
    assert codes_found(packed(pixels=photoshop)) == set()
    meant = nm.pack([bumpy()], nm.PackOptions(bits=8))
    assert nm.unpack(meant).findings == ()


def encode_srgb(x):
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        (encode_srgb, "linear to sRGB"),
        (lambda x: x**2.2, "sRGB to linear|gamma 2.2"),
        (lambda x: 0.5 + 0.8 * (x - 0.5), "an unknown curve"),
        (lambda x: (x * x * (3 - 2 * x) + x) / 2, "an unknown curve"),
    ],
)
def test_a_tone_curve_is_detected(curve, expected):
    workspace = packed(pixels=recolored(packed(), curve))
    assert codes_found(workspace) == {("tone-curve", "bumpy")}
    found = message(workspace, "tone-curve").message
    assert any(word in found for word in expected.split("|"))


def test_a_tone_curve_does_not_hide_a_flip():
    flipped = packed(pixels=packed().layers[0].pixels[:, ::-1].copy())
    workspace = packed(pixels=recolored(flipped, encode_srgb))
    assert codes_found(workspace) == {("tone-curve", "bumpy"), ("turned", "bumpy")}


def test_premultiplied_edges_are_divided_by_alpha():
    color, pixels = codes_of(packed())
    alpha = pixels[..., 3:] / 65535
    workspace = packed(pixels=np.dstack([np.rint(color * alpha * 65535), pixels[..., 3]]).astype(np.uint16))
    assert codes_found(workspace) == {("premultiplied", "bumpy")}
    normals = nm.unpack(workspace).layers[0].normal_map.normals
    edge = (alpha[..., 0] > 0.1) & (alpha[..., 0] < 0.9)
    assert np.abs(normals - bumpy().normals)[edge].max() < 1e-3


def test_short_normals_are_reported_and_normalised():
    pixels = packed().layers[0].pixels.copy()
    pixels[60:100, 60:100, :3] = (40000, 32768, 50000)
    workspace = packed(pixels=pixels)
    assert codes_found(workspace) == {("off-length", "bumpy")}
    lengths = np.linalg.norm(nm.unpack(workspace).layers[0].normal_map.normals, axis=-1)
    assert np.abs(lengths - 1).max() < 1e-6


def test_dithered_flat_areas_become_flat():
    rows, cols = 128, 128
    normals = np.zeros((rows, cols, 3), np.float32)
    normals[..., 2] = 1
    normals[40:60, 40:60] = (0.6, 0, 0.8)
    plate = nm.NormalMap(normals, np.ones((rows, cols), np.float32), nm.Frame(rows, cols), name="plate.png")
    workspace = nm.pack([plate])
    pixels = workspace.layers[0].pixels.astype(np.int64)
    pixels[..., :2] += np.random.default_rng(0).integers(-300, 301, (rows, cols, 2))
    layer = replace(workspace.layers[0], pixels=pixels.clip(0, 65535).astype(np.uint16))
    found = nm.unpack(replace(workspace, layers=(layer,))).layers[0]
    assert found.repairs[0].endswith("nearly flat pixels made flat again")
    flat = (found.normal_map.normals == (0, 0, 1)).all(axis=-1)
    assert flat[:32].all()
    assert not flat[42:58, 42:58].any()
    # a slope that was shallow when packed is kept
    shallow = np.broadcast_to(np.float32([0.01, 0, np.sqrt(1 - 1e-4)]), normals.shape).copy()
    sheet = nm.NormalMap(shallow, plate.coverage, plate.frame)
    assert np.abs(nm.unpack(nm.pack([sheet])).layers[0].normal_map.normals - shallow).max() < 2 / 65535


def test_editor_settings_without_a_meaning_for_normals_are_reported():
    group = nm.WorkspaceGroup("g", opacity=0.5, blend_mode="soft light")
    workspace = packed(blend_mode="multiply", opacity=0.5, visible=False, groups=(group,))
    unpacked = nm.unpack(workspace)
    told = [(finding.code, finding.message) for finding in unpacked.findings]
    assert [code for code, _ in told] == ["blend-mode", "blend-mode", "opacity", "hidden"]
    assert "multiply" in told[0][1]
    assert "soft light" in told[1][1]
    assert "25%" in told[2][1]
    layer = unpacked.layers[0]
    assert (layer.mode, layer.strength, layer.visible) == ("rnm", 0.5, False)


def test_added_missing_and_renamed_layers_are_reported():
    workspace = packed()
    lower, upper = workspace.layers
    other = replace(upper, name="new", pixels=lower.pixels[:40, :40].copy())
    assert codes_found(replace(workspace, layers=(lower, other))) == {("missing", "small"), ("added", "new")}
    renamed = replace(workspace, layers=(replace(lower, name="sky"), upper))
    assert codes_found(renamed) == {("renamed", "sky")}


def test_findings_that_concern_all_layers_are_reported_once():
    workspace = packed()
    eight = [replace(layer, pixels=np.rint(layer.pixels / 257).astype(np.uint8)) for layer in workspace.layers]
    workspace = replace(workspace, layers=tuple(eight), color_profile="sRGB", skipped=(("levels", "adjustment layer"),))
    assert codes_found(workspace) == {("color-profile", None), ("skipped", "levels"), ("eight-bit", None)}


def test_nonfinite_values_are_reported_and_uncovered():
    workspace = nm.pack([bumpy()], nm.PackOptions(bits=32))
    pixels = workspace.layers[0].pixels.copy()
    pixels[80, 90, 0] = np.nan
    pixels[81, 90, 3] = np.inf
    found = nm.unpack(replace(workspace, layers=(replace(workspace.layers[0], pixels=pixels),)))
    assert [finding.code for finding in found.findings] == ["not-a-number"]
    assert found.layers[0].normal_map.coverage[80, 90] == 0


@pytest.mark.parametrize("degrees", [0, 25, -60])
def test_texture_does_not_hide_a_turn_by_any_angle(degrees):
    smooth = bumpy()
    grain = np.random.default_rng(5).normal(0, 0.03, smooth.normals.shape).astype(np.float32)
    rough = replace(smooth, normals=unit(np.where(smooth.coverage[..., None] > 0, smooth.normals + grain, (0, 0, 1))))
    workspace = nm.pack([rough])
    layer = workspace.layers[0]
    turned = replace(layer, pixels=turned_freely(layer.pixels, degrees) if degrees else layer.pixels)
    found = [f.message for f in nm.unpack(replace(workspace, layers=(turned,))).findings if f.code == "turned-freely"]
    assert len(found) == (degrees != 0)
    assert all(f"looks rotated by {abs(degrees)} degrees" in message for message in found)
