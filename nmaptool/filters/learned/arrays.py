"""Convert learned filters and training states to and from named arrays, the content of their files."""

from __future__ import annotations

import contextlib
import dataclasses
import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.filters.learned.model import FilterModel, Stage, TrainingState
from nmaptool.filters.learned.network import Network
from nmaptool.options import DescriptorOptions

Arrays = Mapping[str, NDArray[Any]]

_FILTER = "nmaptool filter 1"
_TRAINING = "nmaptool training 1"
_MOST_STAGES = 10
_MOST_KINDS = 64
_WEIGHTS = ("w1", "b1", "w2", "b2")


def filter_to_arrays(model: FilterModel) -> dict[str, NDArray[Any]]:
    """Return a model as named arrays; ``header`` is JSON text as bytes."""
    header = {
        "kind": _FILTER,
        "descriptor": dataclasses.asdict(model.descriptor),
        "networks": [len(stage.networks) for stage in model.stages],
        "account": dict(model.metadata),
    }
    parts = [(stage.centers, stage.networks) for stage in model.stages]
    return {"header": _text(header), **_parts_to_arrays(parts)}


def filter_from_arrays(arrays: Arrays) -> FilterModel:
    """Return the model from the arrays of `filter_to_arrays`; InputError if an array is missing or inconsistent."""
    with _header(arrays, _FILTER, "a filter") as header:
        given = header["descriptor"]
        descriptor = DescriptorOptions(tuple(given["sigma_s"]), tuple(given["sigma_r"]), given["passes"])
        metadata = dict(header["account"])
        parts = _parts_from_arrays(arrays, header["networks"])
    return FilterModel(descriptor, tuple(Stage(*part) for part in parts), metadata)


def training_to_arrays(state: TrainingState) -> dict[str, NDArray[Any]]:
    """Return a training state as named arrays; ``header`` is JSON text as bytes."""
    parts = [(stage.centers, stage.networks) for stage in state.stages]
    if state.centers is not None:
        parts.append((state.centers, state.networks))
    header = {
        "kind": _TRAINING,
        "fingerprint": state.fingerprint,
        "losses": list(state.losses),
        "networks": [len(networks) for _, networks in parts],
        "stages": len(state.stages),
    }
    return {"header": _text(header), **_parts_to_arrays(parts)}


def training_from_arrays(arrays: Arrays) -> TrainingState:
    """Return the state from the arrays of `training_to_arrays`; InputError if an array is missing or inconsistent."""
    with _header(arrays, _TRAINING, "a training") as header:
        fingerprint, losses = str(header["fingerprint"]), tuple(float(loss) for loss in header["losses"])
        parts = _parts_from_arrays(arrays, header["networks"])
        finished = int(header["stages"])
    stages = tuple(Stage(*part) for part in parts[:finished])
    centers, networks = parts[finished] if len(parts) > finished else (None, ())
    return TrainingState(fingerprint, stages, centers, networks, losses)


def _text(header: Mapping[str, Any]) -> NDArray[np.uint8]:
    return np.frombuffer(json.dumps(header).encode(), np.uint8)


@contextlib.contextmanager
def _header(arrays: Arrays, kind: str, what: str) -> Iterator[dict[str, Any]]:
    """Yield the header to read; missing keys and invalid values become an InputError."""
    try:
        header: dict[str, Any] = json.loads(arrays["header"].astype(np.uint8).tobytes())
        found = str(header["kind"])
    except (KeyError, TypeError, ValueError):
        raise InputError(f"it is not {what} of nmaptool (its header is missing or damaged)") from None
    if found != kind:
        raise InputError(f"its header says {found[:40]!r}, expected {kind!r}")
    try:
        yield header
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, UsageError):
        raise InputError("its header lacks a value or has an invalid one") from None


def _parts_to_arrays(parts: list[tuple[Float32, tuple[Network, ...]]]) -> dict[str, NDArray[Any]]:
    out: dict[str, NDArray[Any]] = {}
    for s, (centers, networks) in enumerate(parts):
        out[f"stage{s}_centers"] = centers
        for k, network in enumerate(networks):
            out |= {f"stage{s}_network{k}_{name}": getattr(network, name) for name in _WEIGHTS}
    return out


def _parts_from_arrays(arrays: Arrays, counts: list[int]) -> list[tuple[Float32, tuple[Network, ...]]]:
    """Return the centres and networks of each stage; ``counts`` holds the number of networks per stage."""
    if not (len(counts) <= _MOST_STAGES and all(1 <= int(count) <= _MOST_KINDS for count in counts)):
        raise ValueError
    try:
        return [
            (
                arrays[f"stage{s}_centers"],
                tuple(Network(*(arrays[f"stage{s}_network{k}_{name}"] for name in _WEIGHTS)) for k in range(count)),
            )
            for s, count in enumerate(counts)
        ]
    except KeyError as error:
        raise InputError(f"it lacks the array {error}") from None
