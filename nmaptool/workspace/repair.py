"""Read a layer that an editor may have changed as unit normals and coverage, repair it, and list the findings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.vectors import FLAT, unit
from nmaptool.maps.codec import decode_shares, stored_shares
from nmaptool.maps.zero_code import flat_codes, has_color
from nmaptool.types.shown import counted
from nmaptool.types.workspace import NORMAL_BLEND, PASS_THROUGH, WorkspaceFinding, WorkspaceLayer
from nmaptool.workspace import colors
from nmaptool.workspace.find_pose import find_pose
from nmaptool.workspace.signature import Signature, cells, content_box, quantiles, signature_from

_EIGHT_BIT_STEP = 2 / 255
_HALF_STEP = 1.1 / 65535
_OFF_LENGTH, _OFF_SHARE = 0.1, 0.02


@dataclass(frozen=True, eq=False)
class Repaired:
    """The contents of a layer after repair.

    Parameters
    ----------
    normals : (h, w, 3) float32
        Unit length; flat where coverage is 0.
    coverage : (h, w) float32
    findings : tuple of WorkspaceFinding
    repairs : tuple of str
        What was repaired automatically.
    """

    normals: Float32
    coverage: Float32
    findings: tuple[WorkspaceFinding, ...]
    repairs: tuple[str, ...]


def repair_layer(layer: WorkspaceLayer, packed_bits: int | None = None) -> Repaired:
    """Read a layer's codes as normals, and repair what can be repaired.

    Parameters
    ----------
    layer : WorkspaceLayer
    packed_bits : int or None
        Bits that the workspace was packed with, if known.

    Returns
    -------
    Repaired
    """
    packed = signature_from(layer.facts)
    alpha = layer.alpha
    covered = alpha > 0.5
    found: list[tuple[str, str, str]] = []
    repairs: list[str] = []
    holes = _not_finite(layer)
    if holes is not None:
        alpha = np.where(holes, np.float32(0), alpha)
        found.append(_HOLES)
    eight = layer.pixels.dtype == np.uint8 or colors.holds_eight_bits(layer.pixels, covered)
    if eight and packed_bits != 8:
        found.append(_EIGHT)
    signed = layer.signed or _is_signed(layer)
    codes = stored_shares(layer.pixels, signed)
    if colors.is_premultiplied(codes, alpha, signed):
        codes = np.asarray(colors.unmultiplied(codes, alpha, signed), np.float32)
        found.append(_PREMULTIPLIED)
    curve = colors.tone_curve(codes, covered, packed)
    if curve is not None:
        found.append((*_CURVE[:1], f"a tone curve was applied to its colours ({curve[0]})", _CURVE[1]))
        straight = np.asarray(curve[1](codes.astype(np.float64)).clip(0, 1), np.float32)
    else:
        straight = codes
    vectors = _vectors(layer, codes)
    off = float((np.abs(colors.lengths(codes[covered]) - 1) > _OFF_LENGTH).mean()) if covered.any() else 0.0
    if off > _OFF_SHARE and curve is None:
        words = f"{off:.0%} of its vectors were not of unit length and were normalised"
        found.append(("off-length", words, "painting, blurring or resizing as colours causes this; check the layer"))
    normals = unit(vectors)
    normals[alpha <= 0] = FLAT
    now = _signature_now(straight, alpha, layer)
    pose = find_pose(now, packed, unit(decode_shares(straight)) if curve is not None else normals, covered)
    found.extend(pose.findings())
    in_place = pose.is_in_place
    was_flat = None
    if packed is not None and in_place and curve is None:
        was_flat = _was_flat(packed, now, layer)
    snapped = _flat_again(normals, alpha, was_flat, layer)
    bent = int((np.abs(normals[..., :2][snapped]).max(axis=-1) > 2 * _HALF_STEP).sum())
    normals[snapped] = FLAT
    if bent:
        repairs.append(f"{counted(bent, 'nearly flat pixel')} made flat again")
    found.extend(_editor_findings(layer))
    findings = tuple(WorkspaceFinding(code, layer.name, message, remedy) for code, message, remedy in found)
    return Repaired(normals, alpha, findings, tuple(repairs))


_HOLES = (
    "not-a-number",
    "has NaN or infinite values; such pixels are left out",
    "repair them in the program that wrote them",
)
_EIGHT = (
    "eight-bit",
    "was converted to 8 bits: smooth areas will show steps",
    "set the document to 16 bits before pasting or saving; the lost precision cannot be restored",
)
_PREMULTIPLIED = (
    "premultiplied",
    "its colours were multiplied by alpha along the edges; they were divided by alpha again",
    "save with straight (unassociated) alpha",
)
_CURVE = (
    "tone-curve",
    "switch colour management off (assign no profile, never convert to one) and pack and edit again, or undo the curve",
)


def _not_finite(layer: WorkspaceLayer) -> Mask | None:
    if layer.pixels.dtype != np.float32:
        return None
    bad: Mask = ~np.isfinite(layer.pixels).all(axis=-1) & (np.nan_to_num(layer.pixels[..., 3]) > 0)
    return bad if bad.any() else None


def _is_signed(layer: WorkspaceLayer) -> bool:
    """Whether floats hold n: some are negative, or they are already of unit length."""
    if layer.pixels.dtype != np.float32:
        return False
    color = layer.pixels[..., :3][layer.alpha > 0.5]
    color = color[np.isfinite(color).all(axis=-1)][:: max(1, color.shape[0] // 100_000)].astype(np.float64)
    if not len(color):
        return False
    if color.min() < -1e-3:
        return True
    return bool(np.abs(np.linalg.norm(color, axis=1) - 1).mean() <= np.abs(colors.lengths(color) - 1).mean())


def _vectors(layer: WorkspaceLayer, codes: Float32) -> Float32:
    """Vectors, not yet normalised; the exact flat code is exactly flat."""
    vectors = decode_shares(codes)
    if layer.pixels.dtype != np.float32:
        vectors[has_color(layer.pixels, flat_codes(layer.max_code)["128"])] = FLAT
    return vectors


def _signature_now(codes: Float32, alpha: Float32, layer: WorkspaceLayer) -> Signature:
    box = content_box(alpha, layer.left, layer.top)
    rows = slice(box[1] - layer.top, box[1] - layer.top + box[3])
    cols = slice(box[0] - layer.left, box[0] - layer.left + box[2])
    covered = alpha > 0.5
    spread = quantiles(codes, covered if covered.any() else np.ones_like(covered))
    return Signature(box, cells(codes[rows, cols], alpha[rows, cols]), spread, 0.0)


def signature_of(layer: WorkspaceLayer) -> Signature:
    """The present signature of a layer, without repairs and without its curl."""
    signed = layer.signed or _is_signed(layer)
    return _signature_now(stored_shares(layer.pixels, signed), layer.alpha, layer)


def _flat_again(normals: Float32, alpha: Float32, was_flat: Mask | None, layer: WorkspaceLayer) -> Mask:
    """Pixels whose nearly flat normals should be exactly flat.

    The tolerance is half a 16-bit step anywhere, and that of 8 bits and dither where the layer was flat when packed.
    """
    lean = np.maximum(np.abs(normals[..., 0]), np.abs(normals[..., 1]))
    fine = _HALF_STEP if layer.pixels.dtype != np.float32 else 1e-6
    near: Mask = lean <= fine
    if was_flat is not None:
        near |= (lean <= 2 * _EIGHT_BIT_STEP) & was_flat
    return near & (lean > 0) & (alpha > 0)


def _was_flat(packed: Signature, now: Signature, layer: WorkspaceLayer) -> Mask:
    """(h, w) bool: pixels in cells of the signature that were entirely flat and have changed."""
    # a tilt of half a degree already lowers the mean of z by this much
    flat = (packed.cells[..., 2] >= 1 - 1.6e-5) & (packed.cells[..., 3] > 0)
    touched = (np.abs(now.cells - packed.cells) > 1.6e-5).any(axis=-1)
    left, top, cols, rows = now.box
    spread = cv2.resize((flat & touched).astype(np.uint8), (cols, rows), interpolation=cv2.INTER_NEAREST)
    out = np.zeros(layer.size, bool)
    row, col = top - layer.top, left - layer.left
    out[row : row + rows, col : col + cols] = spread > 0
    return out


def _editor_findings(layer: WorkspaceLayer) -> Iterator[tuple[str, str, str]]:
    modes = [layer.blend_mode] + [group.blend_mode for group in layer.groups]
    for mode in dict.fromkeys(modes):
        if mode not in (NORMAL_BLEND, PASS_THROUGH):
            yield (
                "blend-mode",
                f"has the blend mode {mode}, which computes with codes as if they were colours",
                "set it to normal, and set how vectors blend in the recipe: mode rnm, pd, whiteout or udn",
            )
    opacity = layer.opacity * float(np.prod([group.opacity for group in layer.groups]))
    if opacity < 0.999:
        yield (
            "opacity",
            f"has an opacity of {opacity:.0%}, which mixes codes, not vectors",
            f"set it to 100 % and use strength, which fades slopes; the recipe has strength {opacity:.2g}",
        )
    if not layer.shown and layer.facts.get("visible") is not False:
        yield (
            "hidden",
            "is hidden; it is kept, marked as hidden",
            "delete it, or keep it: stack ignores hidden layers",
        )
    for what in layer.facts.get("not_kept", ()):
        yield (
            "not-kept",
            f"has {what}, which its pixels do not include",
            "apply or rasterise it in the editor and save again",
        )
