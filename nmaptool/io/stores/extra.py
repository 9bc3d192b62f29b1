"""The packages of the extra `cluster`, loaded on first use."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from nmaptool.core.errors import InputError


def zarr_module(name: str) -> Any:
    """Return the module ``zarr``.

    Parameters
    ----------
    name : str
        What needs it, for the message.

    Raises
    ------
    InputError
        If it is not installed.
    """
    return _loaded("zarr", name, "Zarr stores")


def fsspec_module(name: str) -> Any:
    """Return the module ``fsspec``; parameters and errors as `zarr_module`."""
    return _loaded("fsspec", name, "URLs")


def _loaded(module: str, name: str, what: str) -> Any:
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
    raise InputError(
        f'{name}: {what} need the package {module}; install it with: pip install "nmaptool-relief[cluster]"'
    )
