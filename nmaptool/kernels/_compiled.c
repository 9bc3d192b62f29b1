/* Inner loops of nmaptool; every function has a twin in NumPy beside this file, with the same signature. */

#include "arrays.h"
#include "coarsening.h"
#include "directions.h"
#include "grid.h"
#include "pairs.h"
#include "pixels.h"
#include "profile.h"
#include "rows.h"
#include "sweeps.h"
#include "system.h"
#include "transfer.h"

static PyMethodDef methods[] = {
    {"pair_sums", pair_sums, METH_VARARGS, "See nmaptool.kernels.pair_twins."},
    {"finest_descend", finest_descend, METH_VARARGS, "See nmaptool.kernels.sweep_twins."},
    {"finest_ascend", finest_ascend, METH_VARARGS, "See nmaptool.kernels.sweep_twins."},
    {"finest_advance", finest_advance, METH_VARARGS, "See nmaptool.kernels.sweep_twins."},
    {"coarse_step", coarse_step, METH_VARARGS, "See nmaptool.kernels.grid_twins."},
    {"coarse_left", coarse_left, METH_VARARGS, "See nmaptool.kernels.grid_twins."},
    {"coarsen_finest", coarsen_finest, METH_VARARGS, "See nmaptool.kernels.coarsening."},
    {"coarsen_coarse", coarsen_coarse, METH_VARARGS, "See nmaptool.kernels.coarsening."},
    {"sort_rows", sort_rows, METH_VARARGS, "See nmaptool.kernels.row_twins."},
    {"rows_times", rows_times, METH_VARARGS, "See nmaptool.kernels.row_twins."},
    {"rows_product", rows_product, METH_VARARGS, "See nmaptool.kernels.row_twins."},
    {"order_graph", order_graph, METH_VARARGS, "See nmaptool.kernels.profile_twins."},
    {"profile_factor", profile_factor, METH_VARARGS, "See nmaptool.kernels.profile_twins."},
    {"profile_solve", profile_solve, METH_VARARGS, "See nmaptool.kernels.profile_twins."},
    {"restrict_rows", restrict_rows, METH_VARARGS, "See nmaptool.kernels.transfer_twins."},
    {"prolong_rows", prolong_rows, METH_VARARGS, "See nmaptool.kernels.transfer_twins."},
    {"move", move, METH_VARARGS, "See nmaptool.kernels.transfer_twins."},
    {"pixel_sums", pixel_sums, METH_VARARGS, "See nmaptool.kernels.pixel_twins."},
    {"system_product", system_product, METH_VARARGS, "See nmaptool.kernels.system_twins."},
    {"at_faces", at_faces, METH_VARARGS, "See nmaptool.kernels.pair_twins."},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef module = {
    .m_base = PyModuleDef_HEAD_INIT,
    .m_name = "_compiled",
    .m_doc = "Inner loops of nmaptool.",
    .m_size = -1,
    .m_methods = methods,
};

PyMODINIT_FUNC PyInit__compiled(void) { return PyModule_Create(&module); }
