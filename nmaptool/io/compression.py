"""How the files are compressed: what is quickest for the size (docs/decisions/0034-compression.md); never with loss."""

from __future__ import annotations

from collections.abc import Mapping

# attributes of OpenImageIO by file ending; filter 32 predicts each row of a PNG from the one above, zip:1 is level 1
PICTURES: Mapping[str, Mapping[str, str | int]] = {
    ".png": {"png:compressionLevel": 1, "png:filter": 32},
    ".exr": {"compression": "zip:1"},
    ".tif": {"compression": "zip"},
    ".tiff": {"compression": "zip"},
}
# level of deflate for the text of a 3MF, 0 to 9
LEVEL_OF_3MF = 1
