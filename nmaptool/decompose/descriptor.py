"""What a learned filter sees of a face: the normals that rolling guidance gives it, at several widths and ranges."""

from __future__ import annotations

import numpy as np

from nmaptool.arrays import Float32, Float64
from nmaptool.bands import each_of
from nmaptool.decompose.rolling import Gather, roll
from nmaptool.decompose.surface import Roughness, Surroundings
from nmaptool.mesh import Mesh
from nmaptool.options import DescriptorOptions
from nmaptool.progress import Progress

# the networks learn from descriptors as rough as these: 0.3 degrees off on average, at a third of the time
_ROUGH = Roughness(alike=1.0, pairs_per_face=400.0)


class Describer:
    """Filtered normals of one mesh (the descriptor of paper, Sec. 3.2), led by any guide.

    Parameters
    ----------
    mesh : Mesh
        Clean and welded; its own normals are what is filtered.
    options : DescriptorOptions
    """

    def __init__(self, mesh: Mesh, options: DescriptorOptions) -> None:
        self.options = options
        self._normals = mesh.geometry.normals
        sizes = [size * mesh.mean_edge for size in options.sigma_s]
        self._surroundings = each_of(sizes, lambda size: Surroundings(mesh, mesh.geometry, size))

    def __call__(self, guide: Float64 | None = None, progress: Progress | None = None) -> Float32:
        """Descriptors.

        Parameters
        ----------
        guide : (M, 3) float64, optional
            Unit normals, such as a stage before found: likeness counts by them, and one pass is made. Default: none,
            as rolling guidance begins, and ``options.passes`` are made.
        progress : callable, optional

        Returns
        -------
        (M, K, 3) float32
            Unit normals: all ranges of the first width, all of the second, and so on.
        """
        options = self.options
        widths, ranges = range(len(options.sigma_s)), range(len(options.sigma_r))
        out = np.empty((len(self._normals), options.size, 3), np.float32)
        # the first pass without a guide is the same for all ranges
        blurred = None if guide is not None else each_of(widths, lambda width: self._gather(width, 0)(None))
        passes = options.passes if guide is None else 1
        done = 0

        def describe(task: tuple[int, int]) -> None:
            nonlocal done
            width, place = task
            gather = self._gather(width, place)

            def sums(led_by: Float64 | None) -> Float64:
                if led_by is not None:
                    return gather(led_by)
                return gather(guide) if blurred is None else blurred[width]

            out[:, width * len(ranges) + place] = roll(self._normals, sums, passes)
            done += 1
            if progress is not None:
                progress("describing", done / options.size)

        # the narrow ones are the most work: first, so that no thread is left with one at the end
        each_of([(width, place) for width in widths for place in ranges], describe)
        return out

    def _gather(self, width: int, place: int) -> Gather:
        return self._surroundings[width].gather(self._normals, self.options.sigma_r[place], _ROUGH)
