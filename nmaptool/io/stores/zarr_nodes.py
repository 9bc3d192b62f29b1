"""Open Zarr arrays and the arrays of groups, with an error for every reason why that fails."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from typing import Any

from nmaptool.core.errors import InputError, reason_of
from nmaptool.io.pictures.layer_names import best_places, matching, others_note
from nmaptool.io.stores.extra import fsspec_module, zarr_module
from nmaptool.io.stores.names import is_url, local_path, split_name

# the attribute of an array that holds nmaptool's metadata
OWN = "nmaptool"
_NUMBERS = re.compile(r"(\d+)")


def open_array(name: str, layer: str | None = None) -> tuple[Any, str, tuple[str, ...]]:
    """Open a Zarr array for reading.

    Parameters
    ----------
    name : str
        An array, or a group with ``layer`` or after a colon the array in it.
    layer : str, optional

    Returns
    -------
    array : zarr.Array
    layer : str
        Name of the array in its group; empty without a group.
    notes : tuple of str
        The other arrays of the group, if none was named.

    Raises
    ------
    InputError
        If it does not exist, is damaged, has no such array or cannot be reached.
    """
    place, stated = split_name(name)
    wanted = layer or stated
    node = _open_node(place)
    zarr = zarr_module(name)
    if isinstance(node, zarr.Array):
        if wanted is not None:
            raise InputError(f"{place}: has no layer {wanted!r}; it holds one array")
        return node, "", ()
    return _of_group(place, node, wanted)


def location_of(place: str) -> str:
    """The text by which Zarr opens a place: a path for what lies on this machine."""
    path = local_path(place)
    return place if path is None else str(path)


def _open_node(place: str) -> Any:
    zarr = zarr_module(place)
    if is_url(place):
        fsspec_module(place)
    unknown = InputError(f"{place}: is not a Zarr array or group; give the folder that holds zarr.json")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about metadata that other programs add
            return zarr.open(location_of(place), mode="r")
    except FileNotFoundError:
        path = local_path(place)
        if path is not None and path.exists():
            raise unknown from None
        raise InputError(f"{place}: no such file or folder") from None
    except zarr.errors.NodeNotFoundError:
        raise unknown from None
    except ImportError as error:
        raise InputError(f"{place}: cannot be reached ({error})") from None
    except OSError as error:
        raise InputError(f"{place}: cannot be read ({reason_of(error)})") from None
    except ValueError as error:
        if "rotocol not known" in str(error):
            raise InputError(
                f"{place}: is a URL that fsspec does not know; give one such as s3://bucket/map.zarr"
            ) from None
        raise _broken(place) from None
    except (KeyError, TypeError, AttributeError, RuntimeError, RecursionError):
        raise _broken(place) from None


def _broken(place: str) -> InputError:
    return InputError(
        f"{place}: the metadata of the Zarr store is damaged or of an unknown kind; write the store again"
    )


def _of_group(place: str, group: Any, wanted: str | None) -> tuple[Any, str, tuple[str, ...]]:
    """The array of a group that is wanted, else the only one, the largest of a pyramid, the map, or the first."""
    names = sorted((key for key, _ in group.arrays()), key=_by_number)
    if wanted is not None:
        found = matching(wanted, [[name] for name in names])
        if not found:
            held = f"it holds: {', '.join(names)}" if names else "it holds no arrays"
            raise InputError(f"{place}: has no layer {wanted!r}; {held}")
        return group[names[found[0]]], names[found[0]], ()
    if not names:
        raise InputError(f"{place}: is a Zarr group without arrays; give the folder of an array")
    if is_pyramid(group.attrs, names):
        return group[names[0]], names[0], ()
    chosen = names[next(iter(best_places(names, "normals")), 0)]
    others = [name for name in names if name != chosen]
    return group[chosen], chosen, (others_note(chosen, others),) if others else ()


def is_pyramid(attributes: Mapping[str, Any], names: list[str]) -> bool:
    """Whether the arrays of a group are one picture in several sizes, by its attributes or by their names."""
    own = attributes.get(OWN)
    return (isinstance(own, Mapping) and "pyramid" in own) or (
        ("multiscales" in attributes or "ome" in attributes) and names[0] == "0"
    )


def _by_number(name: str) -> list[Any]:
    """A key that sorts 2 before 10."""
    return [int(part) if part.isdigit() else part for part in _NUMBERS.split(name)]
