"""The inner loops that are compiled if a C compiler was there when the package was built.

Every compiled function has a twin in NumPy with the same signature; without a compiler the twins are used. Callers
split the work into parts that do not depend on the number of threads, so results do not either.
"""

from __future__ import annotations

import nmaptool.kernels.coarsening as coarsening
import nmaptool.kernels.grid_twins as grid_twins
import nmaptool.kernels.pair_twins as pair_twins
import nmaptool.kernels.pixel_twins as pixel_twins
import nmaptool.kernels.profile_twins as profile_twins
import nmaptool.kernels.row_twins as row_twins
import nmaptool.kernels.sweep_twins as sweep_twins
import nmaptool.kernels.system_twins as system_twins
import nmaptool.kernels.transfer_twins as transfer_twins
from nmaptool.core.extension import load_extension

_FAST = load_extension()
IS_COMPILED = _FAST is not None

pair_sums = getattr(_FAST, "pair_sums", pair_twins.pair_sums)
at_faces = getattr(_FAST, "at_faces", pair_twins.at_faces)
pixel_sums = getattr(_FAST, "pixel_sums", pixel_twins.pixel_sums)
order_graph = getattr(_FAST, "order_graph", profile_twins.order_graph)
profile_factor = getattr(_FAST, "profile_factor", profile_twins.profile_factor)
profile_solve = getattr(_FAST, "profile_solve", profile_twins.profile_solve)
# for float32 only; for float64, `grid_twins`, `coarsening`, `row_twins`, `sweep_twins` and `transfer_twins` themselves
finest_descend = getattr(_FAST, "finest_descend", sweep_twins.finest_descend)
finest_ascend = getattr(_FAST, "finest_ascend", sweep_twins.finest_ascend)
finest_advance = getattr(_FAST, "finest_advance", sweep_twins.finest_advance)
coarse_step = getattr(_FAST, "coarse_step", grid_twins.coarse_step)
coarse_left = getattr(_FAST, "coarse_left", grid_twins.coarse_left)
coarsen_finest = getattr(_FAST, "coarsen_finest", coarsening.coarsen_finest)
coarsen_coarse = getattr(_FAST, "coarsen_coarse", coarsening.coarsen_coarse)
restrict_rows = getattr(_FAST, "restrict_rows", transfer_twins.restrict_rows)
prolong_rows = getattr(_FAST, "prolong_rows", transfer_twins.prolong_rows)
sort_rows = getattr(_FAST, "sort_rows", row_twins.sort_rows)
rows_times = getattr(_FAST, "rows_times", row_twins.rows_times)
rows_product = getattr(_FAST, "rows_product", row_twins.rows_product)
move = getattr(_FAST, "move", transfer_twins.move)
system_product = getattr(_FAST, "system_product", system_twins.system_product)
