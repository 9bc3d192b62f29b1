"""What a learned filter sees of a face: the normals that rolling guidance gives it, at several widths and ranges."""

from __future__ import annotations

import itertools

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.parallel import map_parallel
from nmaptool.core.progress import Progress
from nmaptool.filters.rolling import Gather, mean_normals
from nmaptool.filters.surface import Neighborhood, Roughness
from nmaptool.options import DescriptorOptions
from nmaptool.types.mesh import Mesh

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
        self._surroundings = map_parallel(sizes, lambda size: Neighborhood(mesh, size))

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
        (M, K, 4) float32
            Unit normals, and how much the normals around the face agree, 0 to 1: all ranges of the first width, all of
            the second, and so on.
        """
        options = self.options
        widths, ranges = range(len(options.sigma_s)), range(len(options.sigma_r))
        out = np.empty((len(self._normals), options.size, 4), np.float32)
        # the first pass without a guide is the same for all ranges
        blurred = None if guide is not None else map_parallel(widths, lambda width: self._gather(width, 0)(None))
        passes = options.passes if guide is None else 1
        done = itertools.count(1)  # threads count together

        def describe(task: tuple[int, int]) -> None:
            width, place = task
            gather = self._gather(width, place)
            sums = gather(guide) if blurred is None else blurred[width]
            for step in range(passes):
                found, agreement = mean_normals(self._normals, sums)
                if step < passes - 1:
                    sums = gather(found)
            here = out[:, width * len(ranges) + place]
            here[:, :3], here[:, 3] = found, agreement
            if progress is not None:
                progress("describing", next(done) / options.size)

        # the narrow ones are the most work: first, so that no thread is left with one at the end
        map_parallel([(width, place) for width in widths for place in ranges], describe)
        return out

    def _gather(self, width: int, place: int) -> Gather:
        return self._surroundings[width].gather(self._normals, self.options.sigma_r[place], _ROUGH)
