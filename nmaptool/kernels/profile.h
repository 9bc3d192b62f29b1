/* A small symmetric system: an order of its unknowns with short rows, and its Cholesky factor.

Row i of the factor is stored from column first[i] to the diagonal, at offset[i] to offset[i + 1] of the values. */

#ifndef NMAPTOOL_PROFILE_H
#define NMAPTOOL_PROFILE_H

#include "arrays.h"
#include "rows.h"
#include <math.h>
#include <stdlib.h>

/* Breadth-first from a vertex, neighbours of few links first; the vertices go to `order`. Returns how many there are. */
static Py_ssize_t breadth_first(const int64_t *start, const int64_t *column, int64_t from, int64_t round, int64_t *seen,
                                int64_t *order) {
    Py_ssize_t count = 1;
    order[0] = from;
    seen[from] = round;
    for (Py_ssize_t i = 0; i < count; i++) {
        Py_ssize_t begin = count;
        for (int64_t k = start[order[i]]; k < start[order[i] + 1]; k++) {
            int64_t other = column[k];
            if (seen[other] == round) continue;
            seen[other] = round;
            Py_ssize_t at = count++;
            for (; at > begin && start[order[at - 1] + 1] - start[order[at - 1]] > start[other + 1] - start[other]; at--)
                order[at] = order[at - 1];
            order[at] = other;
        }
    }
    return count;
}

/* order_graph(start, column, order, part) -> number of parts: vertices by part, each in reverse Cuthill-McKee order */
static PyObject *order_graph(PyObject *self, PyObject *args) {
    PyObject *o[4];
    Array arrays[4];
    int64_t parts = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOO", &o[0], &o[1], &o[2], &o[3]) || !take_arrays(o, arrays, "qqqq", 4, 2)) return NULL;
    Py_ssize_t rows = LENGTH(arrays[0]) - 1;
    int fits = starts_fit(&arrays[0], &arrays[1], &arrays[1]) && LENGTH(arrays[2]) == rows && LENGTH(arrays[3]) == rows &&
               all_below(WHOLE(arrays[1]), LENGTH(arrays[1]), rows);
    int64_t *seen = fits ? calloc(rows + 1, sizeof(int64_t)) : NULL;
    if (seen) {
        Py_BEGIN_ALLOW_THREADS
        const int64_t *start = WHOLE(arrays[0]), *column = WHOLE(arrays[1]);
        int64_t *order = WHOLE(arrays[2]), *part = WHOLE(arrays[3]);
        Py_ssize_t done = 0;
        for (Py_ssize_t i = 0; i < rows; i++) {
            if (seen[i]) continue;
            /* twice from the far end: rows are short if the first vertex is at an end of the part */
            Py_ssize_t count = breadth_first(start, column, i, 1, seen, order + done);
            count = breadth_first(start, column, order[done + count - 1], 2, seen, order + done);
            count = breadth_first(start, column, order[done + count - 1], 3, seen, order + done);
            for (Py_ssize_t k = 0; k < count; k++) part[order[done + k]] = parts;
            for (Py_ssize_t k = 0; k < count / 2; k++) {
                int64_t other = order[done + k];
                order[done + k] = order[done + count - 1 - k];
                order[done + count - 1 - k] = other;
            }
            done += count;
            parts++;
        }
        Py_END_ALLOW_THREADS
        free(seen);
    }
    return finished_with(arrays, 4, fits, seen != NULL, (double)parts);
}

SUMMING double sum_of_products(const double *restrict one, const double *restrict other, int64_t count) {
    ANY_ORDER
    double total = 0;
    for (int64_t i = 0; i < count; i++) total += one[i] * other[i];
    return total;
}

KERNEL void subtract_times(double *restrict out, const double *restrict row, double factor, int64_t count) {
    for (int64_t i = 0; i < count; i++) out[i] -= factor * row[i];
}

/* Whether every row ends at its diagonal, and all rows are in the values. */
static int profile_fits(const Array *first, const Array *offset, const Array *values) {
    Py_ssize_t rows = LENGTH(*first);
    const int64_t *from = WHOLE(*first), *at = WHOLE(*offset);
    int fits = LENGTH(*offset) == rows + 1 && at[0] == 0;
    for (Py_ssize_t i = 0; fits && i < rows; i++) fits &= from[i] >= 0 && from[i] <= i && at[i + 1] - at[i] == i - from[i] + 1;
    return fits && at[rows] <= LENGTH(*values);
}

/* The factor in place of the matrix; the least pivot, or a number that is not positive at the first bad one. */
static double factor(const int64_t *first, const int64_t *offset, double *values, Py_ssize_t rows) {
    double least = 1e300;
    for (Py_ssize_t i = 0; i < rows; i++) {
        double *row = values + offset[i] - first[i]; /* row[j] is at column j */
        for (int64_t j = first[i]; j < i; j++) {
            const double *other = values + offset[j] - first[j];
            int64_t from = first[i] > first[j] ? first[i] : first[j];
            row[j] = (row[j] - sum_of_products(row + from, other + from, j - from)) / other[j];
        }
        double pivot = row[i] - sum_of_products(row + first[i], row + first[i], i - first[i]);
        if (!(pivot > 0)) return pivot < 0 ? pivot : 0;
        if (pivot < least) least = pivot;
        row[i] = sqrt(pivot);
    }
    return least;
}

/* profile_factor(first, offset, values) -> the least pivot; the Cholesky factor in place of the matrix */
static PyObject *profile_factor(PyObject *self, PyObject *args) {
    PyObject *o[3];
    Array arrays[3];
    double least = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &o[0], &o[1], &o[2]) || !take_arrays(o, arrays, "qqd", 3, 1)) return NULL;
    int fits = profile_fits(&arrays[0], &arrays[1], &arrays[2]);
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        least = factor(WHOLE(arrays[0]), WHOLE(arrays[1]), DOUBLES(arrays[2]), LENGTH(arrays[0]));
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 3, fits, 1, least);
}

/* profile_solve(first, offset, values, x) -> 0.0: the solution in place of the right-hand side */
static PyObject *profile_solve(PyObject *self, PyObject *args) {
    PyObject *o[4];
    Array arrays[4];
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOO", &o[0], &o[1], &o[2], &o[3]) || !take_arrays(o, arrays, "qqdd", 4, 1)) return NULL;
    Py_ssize_t rows = LENGTH(arrays[0]);
    int fits = profile_fits(&arrays[0], &arrays[1], &arrays[2]) && LENGTH(arrays[3]) == rows;
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        const int64_t *first = WHOLE(arrays[0]), *offset = WHOLE(arrays[1]);
        double *x = DOUBLES(arrays[3]);
        for (Py_ssize_t i = 0; i < rows; i++) {
            const double *row = DOUBLES(arrays[2]) + offset[i] - first[i];
            x[i] = (x[i] - sum_of_products(row + first[i], x + first[i], i - first[i])) / row[i];
        }
        for (Py_ssize_t i = rows - 1; i >= 0; i--) {
            const double *row = DOUBLES(arrays[2]) + offset[i] - first[i];
            x[i] /= row[i];
            subtract_times(x + first[i], row + first[i], x[i], i - first[i]);
        }
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 4, fits, 1, 0);
}

#endif
