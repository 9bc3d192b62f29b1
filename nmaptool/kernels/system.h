/* The system's operator on float64 heights, for residuals: A z from differences of heights, row by row.

Weights belong to H x W faces, heights to (H+1) x (W+1) vertices; neither has margins. */

#ifndef NMAPTOOL_SYSTEM_H
#define NMAPTOOL_SYSTEM_H

#include "arrays.h"
#include <stdlib.h>

/* Half the weight of each face between two rows of vertices, and its flow from the upper to the lower side. */
KERNEL void half_and_flow(const double *restrict upper, const double *restrict lower, const float *restrict weight,
                          Py_ssize_t faces, double *restrict half, double *restrict flow) {
    for (Py_ssize_t j = 0; j < faces; j++) {
        half[j] = 0.5 * weight[j];
        flow[j] = half[j] * ((lower[j] - upper[j]) + (lower[j + 1] - upper[j + 1]));
    }
}

/* One row of A z. Index j - 1 of halves and flows is the face to the left; both are 0 beyond the ends of a row. */
KERNEL void product_row(const double *restrict z, const float *restrict beta, const double *restrict half_above,
                        const double *restrict half_below, const double *restrict flow_above,
                        const double *restrict flow_below, Py_ssize_t first, Py_ssize_t last, double *restrict out) {
    for (Py_ssize_t j = first; j < last; j++) {
        double left = (z[j] - z[j - 1]) * (half_above[j - 1] + half_below[j - 1]);
        double right = (z[j + 1] - z[j]) * (half_above[j] + half_below[j]);
        double down = (flow_above[j - 1] + flow_above[j]) - (flow_below[j - 1] + flow_below[j]);
        out[j] = ((left - right) + 0.5 * down) + beta[j] * z[j];
    }
}

/* The same at the first or last vertex of a row, which has neighbours on one side only; `side` is -1 or 1. */
static double product_at_end(const double *z, const float *beta, const double *half_above, const double *half_below,
                             const double *flow_above, const double *flow_below, Py_ssize_t j, int side) {
    Py_ssize_t face = side < 0 ? j - 1 : j;
    double along = (z[j + side] - z[j]) * (half_above[face] + half_below[face]);
    return (0.5 * (flow_above[face] - flow_below[face]) - along) + beta[j] * z[j];
}

/* system_product(weight, beta, z, out, rows, cols, first, last) -> 0.0: rows of A z; `out` begins with row `first` */
static PyObject *system_product(PyObject *self, PyObject *args) {
    PyObject *o[4];
    Array arrays[4];
    Py_ssize_t rows, cols, first, last;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOnnnn", &o[0], &o[1], &o[2], &o[3], &rows, &cols, &first, &last) ||
        !take_arrays(o, arrays, "ffdd", 4, 1))
        return NULL;
    int fits = cols > 1 && 0 <= first && first <= last && last <= rows && LENGTH(arrays[0]) >= (rows - 1) * (cols - 1) &&
               LENGTH(arrays[1]) >= rows * cols && LENGTH(arrays[2]) >= rows * cols &&
               LENGTH(arrays[3]) >= (last - first) * cols;
    /* half and flow of the faces above and below a row, with a 0 at both ends */
    Py_ssize_t room_of = cols + 1;
    double *room = fits ? calloc(4 * room_of, sizeof(double)) : NULL;
    if (room) {
        Py_BEGIN_ALLOW_THREADS
        double *half_above = room + 1, *half_below = half_above + room_of;
        double *flow_above = half_below + room_of, *flow_below = flow_above + room_of;
        const float *weight = FLOATS(arrays[0]);
        const double *heights = DOUBLES(arrays[2]);
        if (first > 0 && first < last)
            half_and_flow(heights + (first - 1) * cols, heights + first * cols, weight + (first - 1) * (cols - 1), cols - 1,
                          half_above, flow_above);
        for (Py_ssize_t i = first; i < last; i++) {
            const double *z = heights + i * cols;
            const float *beta = FLOATS(arrays[1]) + i * cols;
            double *out = DOUBLES(arrays[3]) + (i - first) * cols, *other;
            if (i + 1 < rows) half_and_flow(z, z + cols, weight + i * (cols - 1), cols - 1, half_below, flow_below);
            else memset(half_below, 0, (cols - 1) * sizeof(double)), memset(flow_below, 0, (cols - 1) * sizeof(double));
            product_row(z, beta, half_above, half_below, flow_above, flow_below, 1, cols - 1, out);
            out[0] = product_at_end(z, beta, half_above, half_below, flow_above, flow_below, 0, 1);
            out[cols - 1] = product_at_end(z, beta, half_above, half_below, flow_above, flow_below, cols - 1, -1);
            other = half_above, half_above = half_below, half_below = other;
            other = flow_above, flow_above = flow_below, flow_below = other;
        }
        Py_END_ALLOW_THREADS
        free(room);
    }
    return finished_with(arrays, 4, fits, room != NULL, 0);
}

#endif
