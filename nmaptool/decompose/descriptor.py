"""What a learned filter sees of a face: the normals that rolling guidance gives it, at several widths and ranges."""

from __future__ import annotations

import numpy as np

from nmaptool.arrays import Float32, Float64
from nmaptool.bands import each_of
from nmaptool.decompose.rolling import Gather, roll
from nmaptool.decompose.surface import Surroundings
from nmaptool.mesh import Mesh
from nmaptool.options import DescriptorOptions
from nmaptool.progress import Progress


class Describer:
    """Filtered normals of one mesh, for any field of normals on it (the descriptor of paper, Sec. 3.2).

    Parameters
    ----------
    mesh : Mesh
        Clean and welded.
    options : DescriptorOptions
    """

    def __init__(self, mesh: Mesh, options: DescriptorOptions) -> None:
        self.options = options
        # the narrow ones are the most work: first, so that no thread is left with one at the end
        sizes = [size * mesh.mean_edge for size in options.sigma_s]
        self._surroundings = each_of(sizes, lambda size: Surroundings(mesh, mesh.geometry, size))

    def __call__(self, normals: Float64, progress: Progress | None = None) -> Float32:
        """Descriptors.

        Parameters
        ----------
        normals : (M, 3) float64
            Unit normals, one a face.
        progress : callable, optional

        Returns
        -------
        (M, K, 3) float32
            Unit normals: all ranges of the first width, all of the second, and so on.
        """
        options = self.options
        out = np.empty((len(normals), options.size, 3), np.float32)
        tasks = [(width, place) for width in range(len(options.sigma_s)) for place in range(len(options.sigma_r))]
        done = 0

        def first_pass(width: int) -> Float64:
            return self._surroundings[width].gather(normals, 1.0)(None)

        blurred = each_of(range(len(options.sigma_s)), first_pass)

        def describe(task: tuple[int, int]) -> None:
            nonlocal done
            width, place = task
            gather = self._surroundings[width].gather(normals, options.sigma_r[place])
            out[:, width * len(options.sigma_r) + place] = roll(normals, _known(gather, blurred[width]), options.passes)
            done += 1
            if progress is not None:
                progress("describing", done / len(tasks))

        each_of(tasks, describe)
        return out


def _known(gather: Gather, blurred: Float64) -> Gather:
    """The same sums, the ones without a guide known already."""
    return lambda guide: blurred if guide is None else gather(guide)
