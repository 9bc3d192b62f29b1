"""Workspaces, and the changes that editors make to their layers."""

from dataclasses import replace

import cv2
import numpy as np

import nmaptool as nm
from nmaptool.core.vectors import unit


def bumpy(rows=160, cols=180, seed=0, name="bumpy.png"):
    """The map of a smooth random height field on a disc with a soft edge; flat outside."""
    noise = np.random.default_rng(seed).standard_normal((rows, cols)).astype(np.float32)
    z = cv2.GaussianBlur(noise, (0, 0), 9) * 120
    p, q = np.gradient(z, axis=1), -np.gradient(z, axis=0)
    y, x = np.mgrid[0:rows, 0:cols]
    radius = np.hypot(x - cols / 2, y - rows / 2) / (min(rows, cols) / 2)
    cover = ((0.85 - radius) * 20).clip(0, 1).astype(np.float32)
    normals = unit(np.dstack([-p, -q, np.ones_like(p)]))
    normals[cover <= 0] = (0, 0, 1)
    return nm.NormalMap(normals, cover, nm.Frame(rows, cols, 0.1), name=name)


def random_workspace(kind=np.uint16):
    """Random codes in nested groups, with a mask, hidden layers, opacity and layers partly off the canvas."""
    rng = np.random.default_rng(3)
    top = 1 if kind == np.float32 else np.iinfo(kind).max

    def codes(*shape):
        return rng.random(shape).astype(np.float32) if top == 1 else rng.integers(0, top + 1, shape).astype(kind)

    outer = nm.WorkspaceGroup("outer group")
    inner = nm.WorkspaceGroup("inner ä", visible=False, opacity=0.6)
    layers = (
        nm.WorkspaceLayer("base", codes(90, 100, 4)),
        nm.WorkspaceLayer(
            "détail",
            codes(30, 40, 4),
            left=-5,
            top=70,
            opacity=0.4,
            groups=(outer,),
            mask=nm.WorkspaceMask(codes(20, 22), left=3, top=71),
        ),
        nm.WorkspaceLayer("中文", codes(10, 12, 4), left=20, top=20, visible=False, groups=(outer, inner)),
        nm.WorkspaceLayer("top", codes(5, 6, 4), left=98, top=-2),
    )
    if kind == np.float32:
        layers = tuple(replace(layer, signed=True) for layer in layers)
    return nm.Workspace(nm.Frame(90, 100), layers, bits=8 * np.dtype(kind).itemsize)


def packed(**changes):
    """Two packed layers; the lower one is changed as an editor might change it."""
    workspace = nm.pack([bumpy(), nm.PackedMap(bumpy(60, 50, 1, "small.png"), left=30, top=20, mode="rnm")])
    lower = replace(workspace.layers[0], facts={}, **changes)
    return replace(workspace, layers=(lower, replace(workspace.layers[1], facts={})))


def codes_of(workspace):
    """The lower layer's colours as fractions, and its pixels."""
    pixels = workspace.layers[0].pixels
    return pixels[..., :3] / 65535, pixels


def recolored(workspace, curve):
    color, pixels = codes_of(workspace)
    return np.dstack([np.rint(curve(color) * 65535), pixels[..., 3]]).astype(np.uint16)


def turned_freely(pixels, degrees):
    """The image turned counter-clockwise as by an editor, which does not rotate its normals."""
    rows, cols = pixels.shape[:2]
    turn = cv2.getRotationMatrix2D((cols / 2 - 0.5, rows / 2 - 0.5), degrees, 1)
    alpha = pixels[..., 3:].astype(np.float32)
    mixed = np.dstack([pixels[..., :3] * alpha / 65535, alpha])
    out = cv2.warpAffine(mixed.astype(np.float32), turn, (cols, rows), flags=cv2.INTER_LINEAR)
    cover = out[..., 3:]
    color = np.where(cover > 1, out[..., :3] / np.maximum(cover, 1) * 65535, 32768)
    return np.rint(np.dstack([color, cover])).clip(0, 65535).astype(np.uint16)


def codes_found(workspace):
    """The codes of the findings, each with its layer."""
    return {(finding.code, finding.layer) for finding in nm.unpack(workspace).findings}
