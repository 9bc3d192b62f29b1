"""Make the pictures of plates in the docs from the samples: ``python docs/plate_pictures.py``."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import nmaptool as nm

ROOT = Path(__file__).parents[1]
SAMPLES = ROOT / "samples"
PICTURES = ROOT / "docs" / "pictures"
HIGH_PX = 560
GAP_PX = 10
Picture = NDArray[np.uint8]


def baked(name: str, folder: Path) -> nm.LayerSet:
    layers = nm.bake(
        nm.read_mesh(SAMPLES / f"{name}.ply"), nm.BakeOptions(shading="smooth"), nm.FilterOptions(sigma_s=2)
    )
    nm.write_layers(layers, folder / name)
    return layers


def on_plate(
    name: str,
    original: nm.NormalMap,
    detail: nm.NormalMap | None,
    width: str,
    texts: Sequence[nm.TextOptions] = (),
    **changes: Any,
) -> nm.Relief:
    """A relief as ``nmap relief --preset NAME`` makes it."""
    preset = nm.RELIEF_PRESETS[name]
    options = nm.ReliefOptions(**{**preset.options, **changes, "width": nm.length(width)})
    design = nm.read_design(nm.PlateOptions(**preset.plate), nm.FrameOptions(**preset.frame), texts)
    return nm.plate(original, detail, options, design=design)


def coin(folder: Path) -> nm.Relief:
    """The coin of samples/coin.toml."""
    shutil.copy(SAMPLES / "coin.toml", folder)
    scene = nm.read_scene(folder / "coin.toml")
    assert scene.design is not None
    return nm.plate(**scene.inputs, design=scene.design)


def row(pictures: Sequence[Picture]) -> Picture:
    """Pictures of one height beside each other."""
    parts = []
    for picture in pictures:
        size = (round(picture.shape[1] * HIGH_PX / picture.shape[0]), HIGH_PX)
        parts += [cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.full((HIGH_PX, GAP_PX, 3), 255, np.uint8)]
    return np.hstack(parts[:-1]).astype(np.uint8)


def save(name: str, picture: Picture) -> None:
    cv2.imwrite(str(PICTURES / name), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 86])


def main() -> None:
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        portrait, vase = baked("portrait", folder), baked("vase", folder)
        shell = nm.read_normal_map(SAMPLES / "shell.png")
        struck = coin(folder)
    cameo = on_plate("cameo", portrait.original, portrait.detail, "40mm")
    pendant = on_plate("pendant", shell, None, "28mm")
    name = nm.TextOptions(text="Vasa antiqua", text_size=nm.length("4mm"))
    plaque = on_plate("plaque", vase.original, vase.detail, "70mm", [name])
    pieces = ((struck, "gold"), (cameo, "marble"), (pendant, "bronze"), (plaque, "walnut"))
    save("plates.jpg", row([nm.preview(each, nm.PreviewOptions(material=material)) for each, material in pieces]))
    save("coin-materials.jpg", row([nm.preview(struck, nm.PreviewOptions(material=each)) for each in nm.MATERIALS]))
    standing = nm.PreviewOptions(material="silver", view="iso", size=900)
    save("coin-iso.jpg", nm.preview(struck, standing))


if __name__ == "__main__":
    main()
