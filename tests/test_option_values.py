"""Values that every options class refuses, for any of its options."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import Any

import pytest

import nmaptool as nm
from nmaptool.options.fields import Options, kind_of
from nmaptool.options.kinds import Choice, Count, Number, Positive, Weight


def required() -> list[Any]:
    """Every number and choice with a default, for which None is not a valid value."""
    classes = [value for name in nm.__all__ if isinstance(value := getattr(nm, name), type)]
    return [
        pytest.param(options, field.name, id=f"{options.__name__}.{field.name}")
        for options in classes
        if issubclass(options, Options)
        for field in dataclasses.fields(options)
        if field.default is not None and isinstance(kind_of(field), (Choice, Number, Weight, Positive, Count))
    ]


@pytest.mark.parametrize(("options", "name"), required())
def test_none_is_refused_if_an_option_has_a_default(options: type[Options], name: str) -> None:
    with pytest.raises((nm.UsageError, TypeError)):
        options(**{name: None})


@pytest.mark.parametrize("name", ["background", "energy", "fit", "solver"])
def test_none_is_not_a_valid_choice(name: str) -> None:
    with pytest.raises(nm.UsageError, match=rf"`{name}=None`: use one of "):
        nm.ReliefOptions(**{name: None})


@pytest.mark.parametrize("slope_cap", [0.0, -1.0, 2e4, math.inf, math.nan])
def test_both_bounds_of_a_positive_number_are_named(slope_cap: float) -> None:
    message = f"`slope_cap={slope_cap:g}`: must be greater than zero and at most 10000, such as 3"
    with pytest.raises(nm.UsageError, match=f"^{re.escape(message)}$"):
        nm.ReliefOptions(slope_cap=slope_cap)


@pytest.mark.parametrize(("limit", "bounds"), [(math.inf, "finite and greater than zero"), (-1.0, "greater than zero")])
def test_a_positive_number_without_an_upper_bound_must_be_finite(limit: float, bounds: str) -> None:
    with pytest.raises(nm.UsageError, match=f"^`max_megapixels={limit:g}`: must be {bounds}$"):
        nm.BakeOptions(max_megapixels=limit)


@pytest.mark.parametrize("feather", [3.0, True, [1]])
def test_a_feather_is_a_distance(feather: Any) -> None:
    with pytest.raises(nm.UsageError, match=r"`feather=.*`: expected a distance, such as 6px"):
        nm.LayerOptions(feather=feather)
