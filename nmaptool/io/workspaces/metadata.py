"""The metadata of workspace files: nmaptool's own, blend modes, colour profiles."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any
from xml.sax.saxutils import escape

from nmaptool.core.errors import InputError
from nmaptool.io.workspaces.plain_xml import parse_xml
from nmaptool.types.workspace import NORMAL_BLEND, PASS_THROUGH

_XMP = (
    '<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>\n'
    '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
    '<rdf:Description rdf:about="" xmlns:dc="http://purl.org/dc/elements/1.1/"><dc:source>{0}</dc:source>'
    '</rdf:Description></rdf:RDF></x:xmpmeta>\n<?xpacket end="w"?>'
)
_LARGEST_METADATA = 16_000_000
# four-letter keys of Photoshop's blend modes
_PSD_MODES = {
    "pass": PASS_THROUGH,
    "norm": NORMAL_BLEND,
    "diss": "dissolve",
    "dark": "darken",
    "mul ": "multiply",
    "idiv": "color burn",
    "lbrn": "linear burn",
    "dkCl": "darker color",
    "lite": "lighten",
    "scrn": "screen",
    "div ": "color dodge",
    "lddg": "linear dodge",
    "lgCl": "lighter color",
    "over": "overlay",
    "sLit": "soft light",
    "hLit": "hard light",
    "vLit": "vivid light",
    "lLit": "linear light",
    "pLit": "pin light",
    "hMix": "hard mix",
    "diff": "difference",
    "smud": "exclusion",
    "fsub": "subtract",
    "fdiv": "divide",
    "hue ": "hue",
    "sat ": "saturation",
    "colr": "color",
    "lum ": "luminosity",
}
_ORA_NORMAL = ("svg:src-over", "svg:normal", "")


def psd_mode(mode: str) -> bytes:
    """Return Photoshop's key for a blend mode, or that of ``normal`` if Photoshop does not have the mode."""
    keys = {word: key for key, word in _PSD_MODES.items()}
    return keys.get(mode, "norm").encode("ascii")


def from_psd_mode(key: bytes) -> str:
    """Return the name of a blend mode from Photoshop's key."""
    return _PSD_MODES.get(key.decode("latin-1"), key.decode("latin-1").strip())


def ora_mode(mode: str) -> str:
    """Return OpenRaster's name for a blend mode."""
    return "svg:src-over" if mode == NORMAL_BLEND else f"svg:{mode.replace(' ', '-')}"


def from_ora_mode(word: str) -> str:
    """Return the name of a blend mode: ``svg:soft-light`` and ``krita:soft_light`` are ``soft light``."""
    if word in _ORA_NORMAL:
        return NORMAL_BLEND
    return word.rpartition(":")[2].replace("-", " ").replace("_", " ")[:40]


def to_json(metadata: Mapping[str, Any]) -> str:
    """Compact JSON."""
    return json.dumps(metadata, separators=(",", ":"), allow_nan=False)


def from_json(text: str | bytes) -> dict[str, Any] | None:
    """Return the metadata, or None if the text is not a JSON object: an editor may have truncated it."""
    if len(text) > _LARGEST_METADATA:
        return None
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def to_xmp(metadata: Mapping[str, Any]) -> bytes:
    """Return the metadata as ``dc:source`` of an XMP packet, because editors drop properties that they do not know."""
    return _XMP.format(escape(to_json(metadata))).encode("utf-8")


def from_xmp(packet: bytes) -> dict[str, Any] | None:
    """Return the metadata in an element or an attribute of an XMP packet, or None if there are none."""
    if b"source" not in packet or len(packet) > _LARGEST_METADATA:
        return None
    try:
        root = parse_xml(packet.strip(b"\0 \r\n\t"), "XMP")
    except InputError:
        return None
    for element in root.walk():
        said = [element.text] if element.tag.endswith(":source") else []
        said += [value for key, value in element.attributes.items() if key.endswith(":source")]
        for text in said:
            found = from_json(text)
            if found is not None and "layers" in found:
                return found
    return None


def pitch_in(metadata: Mapping[str, Any] | None) -> float | None:
    """Return the mm per px in the metadata, or None."""
    pitch = (metadata or {}).get("pitch_mm")
    if isinstance(pitch, bool) or not isinstance(pitch, int | float) or not 0 < pitch < 1e6:
        return None
    return float(pitch)


def profile_name(profile: bytes) -> str:
    """Return the name in an ICC profile."""
    plain = "ICC profile"
    try:
        (count,) = struct.unpack_from(">I", profile, 128)
        for i in range(min(count, 100)):
            tag, offset, size = struct.unpack_from(">4sII", profile, 132 + 12 * i)
            if tag != b"desc":
                continue
            body = profile[offset : offset + min(size, 4096)]
            if body[:4] == b"desc":
                text = body[12 : 12 + struct.unpack_from(">I", body, 8)[0]].decode("latin-1")
            else:  # multi-localised
                length, start = struct.unpack_from(">II", body, 20)
                text = body[start : start + min(length, 200)].decode("utf-16-be", "replace")
            return "".join(c for c in text if c.isprintable()).strip()[:80] or plain
    except struct.error:
        return plain
    return plain
