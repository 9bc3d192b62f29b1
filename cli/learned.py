"""What commands that split a mesh's normals share: a learned filter of one's own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import nmaptool as nm


@dataclass(frozen=True)
class LearnedFilter:
    """A filter of one's own.

    Parameters
    ----------
    model:
        Filter made by nmap train, .npz, for --filter learned. Default: the one that comes with nmaptool.
    """

    model: Path | None = None

    @property
    def files(self) -> dict[str, str]:
        """What was read, for the report."""
        return {} if self.model is None else {"model": str(self.model)}

    def read(self) -> nm.FilterModel | None:
        """The filter; None where none is given."""
        import nmaptool as nm

        return None if self.model is None else nm.read_filter_model(self.model)
