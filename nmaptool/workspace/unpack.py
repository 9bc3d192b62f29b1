"""Unpack a workspace from an editor into normal maps: repair what is possible and report the rest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from nmaptool.core.errors import UsageError
from nmaptool.options.blend_modes import layer_meanings
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import Frame
from nmaptool.types.unpacked import UnpackedLayer, UnpackResult
from nmaptool.types.workspace import NORMAL_BLEND, PASS_THROUGH, Workspace, WorkspaceFinding, WorkspaceLayer, mask_over
from nmaptool.workspace.repair import repair_layer, signature_of
from nmaptool.workspace.signature import signature_from

_PASSING = (NORMAL_BLEND, PASS_THROUGH)
_RENAMED = 0.02


def unpack(workspace: Workspace) -> UnpackResult:
    """Unpack a workspace into a normal map for each layer, and detect what an image editor changed.

    Parameters
    ----------
    workspace : Workspace
        From `nmaptool.read_workspace` or `nmaptool.pack`.

    Returns
    -------
    UnpackResult
        Maps, masks, positions, findings and repairs.

    Raises
    ------
    UsageError
        If the value is not a Workspace, such as a path.

    Examples
    --------
    >>> flat = np.zeros((32, 48, 3))
    >>> flat[..., 2] = 1
    >>> nm.unpack(nm.pack([flat]))
    <UnpackResult workspace: 48 x 32 px, pitch unknown, 16 bits, 1 layer, 0 findings>
    """
    if not isinstance(workspace, Workspace):
        found = type(workspace).__name__
        raise UsageError(f"the workspace must be a Workspace, found {found}; read one with read_workspace")
    facts = _facts(workspace)
    matched, renamed = _matched(workspace.layers, facts)
    metadata = workspace.metadata or {}
    bits = metadata.get("bits")
    packed_bits = bits if isinstance(bits, int) else None
    layers = tuple(_unpacked(layer, workspace.frame, packed_bits) for layer in matched)
    whole = _of_the_whole(workspace, facts, matched, renamed)
    inside = [finding for layer in layers for finding in layer.findings]
    findings = (*whole, *_merged_findings(inside, len(layers)))
    ground = "flat" if metadata.get("ground") == "flat" else "clear"
    return UnpackResult(workspace.name, workspace.frame, workspace.bits, layers, findings, bool(facts), ground)


def _merged_findings(findings: list[WorkspaceFinding], layers: int) -> list[WorkspaceFinding]:
    """Merge findings with the same message for every layer into one for the whole file."""
    counts = Counter((finding.code, finding.message) for finding in findings)
    out: list[WorkspaceFinding] = []
    for finding in findings:
        shared = layers > 1 and counts[finding.code, finding.message] == layers
        said = replace(finding, layer=None) if shared else finding
        if said not in out:
            out.append(said)
    return out


def _facts(workspace: Workspace) -> list[dict[str, Any]]:
    """The metadata of each layer, stored in the file when it was packed."""
    layers = (workspace.metadata or {}).get("layers")
    if not isinstance(layers, list):
        return []
    return [one for one in layers if isinstance(one, dict) and isinstance(one.get("name"), str)]


def _matched(
    layers: tuple[WorkspaceLayer, ...], facts: list[dict[str, Any]]
) -> tuple[list[WorkspaceLayer], dict[str, str]]:
    """Match layers with their metadata, by name, then by appearance; also return the old name of each renamed layer."""
    left: dict[str, dict[str, Any]] = {}
    for one in facts:
        left.setdefault(one["name"], one)
    out: list[WorkspaceLayer] = []
    renamed: dict[str, str] = {}
    for layer in layers:
        said = layer.facts.get("name")  # some formats store a layer's metadata with the layer
        name = said if isinstance(said, str) and said in left else layer.name
        if name in left and name != layer.name:
            renamed[layer.name] = name
        out.append(replace(layer, facts={**left.pop(name, {}), **layer.facts}))
    for number, layer in enumerate(out):
        if "cells" in layer.facts or not left:
            continue
        for name, one in left.items():
            if _looks_like(layer, one):
                out[number] = replace(layer, facts={**one, **layer.facts})
                renamed[layer.name] = name
                del left[name]
                break
    return out, renamed


def _looks_like(layer: WorkspaceLayer, facts: Mapping[str, Any]) -> bool:
    """Whether a layer with another name is the one that was packed: same size, same picture."""
    packed = signature_from(facts)
    if packed is None or layer.size != (facts.get("rows"), facts.get("cols")):
        return False
    return bool(np.abs(signature_of(layer).cells - packed.cells).mean() < _RENAMED)


def _unpacked(layer: WorkspaceLayer, frame: Frame, packed_bits: int | None) -> UnpackedLayer:
    repaired = repair_layer(layer, packed_bits)
    rows, cols = layer.size
    normal_map = NormalMap(
        repaired.normals,
        repaired.coverage,
        Frame(rows, cols, frame.pitch_mm),
        name=layer.name,
        decoding=Decoding(green_from="file", background="alpha", background_from="file"),
    )
    mode, strength = layer.facts.get("mode", "over"), layer.facts.get("strength", 1.0)
    mode = mode if mode in layer_meanings() else "over"
    if layer.blend_mode not in _PASSING and mode == "over":
        mode = "rnm"  # a layer with a blend mode is meant as detail on what is below
    known = isinstance(strength, int | float) and not isinstance(strength, bool) and 0 <= strength <= 1000
    return UnpackedLayer(
        name=layer.name,
        normal_map=normal_map,
        left=layer.left,
        top=layer.top,
        mask=mask_over(layer) if layer.mask is not None and layer.mask.enabled else None,
        mode=mode,
        strength=(float(strength) if known else 1.0) * layer.opacity,
        visible=layer.visible,
        groups=layer.groups,
        findings=repaired.findings,
        repairs=repaired.repairs,
    )


def _of_the_whole(
    workspace: Workspace, facts: list[dict[str, Any]], layers: list[WorkspaceLayer], renamed: dict[str, str]
) -> tuple[WorkspaceFinding, ...]:
    found: list[tuple[str, str | None, str, str]] = []
    if workspace.color_profile is not None:
        metadata = f"has a colour profile ({workspace.color_profile}), as if it were a photograph"
        remedy = "it is ignored here, but editors may use it to convert the values: save without a profile"
        found.append(("color-profile", None, metadata, remedy))
    for name, what in workspace.skipped:
        remedy = "rasterise it into a layer of pixels, or delete it"
        found.append(("skipped", name, f"is not a layer of pixels ({what}) and was left out", remedy))
    if len(layers) == 1 and layers[0].facts.get("flattened"):
        remedy = "save it with layers"
        found.append(("flattened", None, "was flattened: its layers were merged into one picture, as colours", remedy))
    elif facts:
        here = {layer.name for layer in layers} | set(renamed.values())
        for one in facts:
            if one["name"] not in here:
                metadata = "was packed but is no longer in the file"
                found.append(("missing", one["name"], metadata, "nothing to do if it was deleted on purpose"))
        known = {one["name"] for one in facts} | set(renamed)
        for layer in layers:
            if layer.name not in known:
                metadata = "is new: it was added in an editor, so changes to it cannot be detected"
                found.append(("added", layer.name, metadata, "check it with nmap inspect"))
        for new, old in renamed.items():
            found.append(("renamed", new, f"was called {old!r} when it was packed", "nothing to do"))
    return tuple(WorkspaceFinding(*one) for one in found)
