/* Whole sweeps over the finest level of the multigrid solver, row by row: what a row needs of its neighbours is kept in a few
row buffers, so every field is read once a sweep.

Rows of heights and of faces in the buffers have a 0 before the first and after the last element. */

#ifndef NMAPTOOL_SWEEPS_H
#define NMAPTOOL_SWEEPS_H

#include "arrays.h"
#include "grid.h"
#include "transfer.h"
#include <stdlib.h>

/* The first smoothing step, from zero. */
KERNEL void start_row(const float *restrict residual, const float *restrict step, Py_ssize_t cols, float *restrict z) {
    for (Py_ssize_t j = 0; j < cols; j++) z[j] = residual[j] * step[j];
}

/* Sums of the four corners of each face between two rows, times their quarters. */
KERNEL void faces_between(const float *restrict z, const float *restrict next, const float *restrict quarter, Py_ssize_t cols,
                          float *restrict sum) {
    for (Py_ssize_t j = 0; j < cols; j++) sum[j] = quarter[j] * ((z[j] + z[j + 1]) + (next[j] + next[j + 1]));
}

KERNEL void left_row(const float *restrict above, const float *restrict below, const float *restrict residual, Py_ssize_t cols,
                     float share, float *restrict left) {
    for (Py_ssize_t j = 0; j < cols; j++)
        left[j] = (above[j - 1] + above[j]) + (below[j - 1] + below[j]) + share * residual[j];
}

KERNEL void finish_row(const float *restrict above, const float *restrict below, const float *restrict residual,
                       const float *restrict step, const float *restrict z, Py_ssize_t cols, float share, float *restrict out) {
    for (Py_ssize_t j = 0; j < cols; j++) {
        float pull = (above[j - 1] + above[j]) + (below[j - 1] + below[j]) + residual[j];
        out[j] = share * z[j] + step[j] * pull;
    }
}

/* The finest level, and row buffers of cols + 2 elements. */
typedef struct {
    const float *quarter, *step, *residual;
    Py_ssize_t rows, cols;
    float *room;
} Sweep;

static float *buffer(const Sweep *s, Py_ssize_t number) { return s->room + number * (s->cols + 2) + 1; }
static const float *quarters(const Sweep *s, Py_ssize_t row) { return s->quarter + (s->cols + 1) + row * s->cols; }

/* Row buffers: four of heights, two of faces, three of residuals, zeros for a row outside, and what `restrict_row` carries. */
enum { HEIGHTS = 0, FACES = 4, LEFTS = 6, ZEROS = 9, CARRY, BUFFERS };

/* The residual of one row after the first step; the heights of the next row and the faces below come to their buffers. */
static void leave(const Sweep *s, Py_ssize_t row, float share) {
    Py_ssize_t next = row + 1;
    if (next < s->rows) {
        start_row(s->residual + next * s->cols, s->step + next * s->cols, s->cols, buffer(s, HEIGHTS + next % 2));
        faces_between(buffer(s, HEIGHTS + row % 2), buffer(s, HEIGHTS + next % 2), quarters(s, row), s->cols,
                      buffer(s, FACES + row % 2));
    } else memset(buffer(s, FACES + row % 2), 0, s->cols * sizeof(float));
    left_row(buffer(s, FACES + next % 2), buffer(s, FACES + row % 2), s->residual + row * s->cols, s->cols, share,
             buffer(s, LEFTS + row % 3));
}

static void descend(const Sweep *s, const Array *weights, Py_ssize_t first, Py_ssize_t last, float share, float *out) {
    Py_ssize_t coarse = (s->cols + 1) / 2, begin = 2 * first - 1 > 0 ? 2 * first - 1 : 0;
    /* the row above, for the faces between */
    Py_ssize_t before = begin > 0 ? begin - 1 : 0;
    start_row(s->residual + before * s->cols, s->step + before * s->cols, s->cols, buffer(s, HEIGHTS + before % 2));
    if (begin > 0) leave(s, before, share);
    for (Py_ssize_t row = begin; row < s->rows && row < 2 * last; row++) {
        leave(s, row, share);
        if (row < 2 * first || (row % 2 == 0 && row + 1 < s->rows)) continue;
        const float *w[WAYS];
        Py_ssize_t i = row / 2;
        at_row(weights, coarse, i, w);
        restrict_row(buffer(s, LEFTS + 2 * i % 3), buffer(s, i > 0 ? LEFTS + (2 * i - 1) % 3 : ZEROS),
                     buffer(s, row % 2 ? LEFTS + row % 3 : ZEROS), w, coarse, s->cols, buffer(s, CARRY), out + i * coarse);
    }
}

/* Heights of two rows: the first step plus the interpolated correction. */
static void raise_rows(const Sweep *s, const Array *weights, const float *x, Py_ssize_t i) {
    Py_ssize_t coarse = (s->cols + 1) / 2;
    const float *w[WAYS];
    at_row(weights, coarse, i, w);
    for (Py_ssize_t row = 2 * i; row < 2 * i + 2 && row < s->rows; row++)
        start_row(s->residual + row * s->cols, s->step + row * s->cols, s->cols, buffer(s, HEIGHTS + row % 4));
    prolong_row(x + (coarse + 1) + i * coarse, w, coarse, s->cols, buffer(s, HEIGHTS + 2 * i % 4),
                2 * i + 1 < s->rows ? buffer(s, HEIGHTS + (2 * i + 1) % 4) : NULL);
}

static double ascend(const Sweep *s, const Array *weights, const float *x, Py_ssize_t first, Py_ssize_t last, float share,
                     float *out) {
    Py_ssize_t end = 2 * last < s->rows ? 2 * last : s->rows, ready = first > 0 ? first - 1 : 0;
    double total = 0;
    for (Py_ssize_t row = 2 * first > 0 ? 2 * first - 1 : 0; row < end; row++) {
        while (ready <= (row + 1) / 2 && 2 * ready < s->rows) raise_rows(s, weights, x, ready++);
        if (row + 1 < s->rows)
            faces_between(buffer(s, HEIGHTS + row % 4), buffer(s, HEIGHTS + (row + 1) % 4), quarters(s, row), s->cols,
                          buffer(s, FACES + row % 2));
        else memset(buffer(s, FACES + row % 2), 0, s->cols * sizeof(float));
        if (row < 2 * first) continue;
        float *to = out + row * s->cols;
        finish_row(buffer(s, FACES + (row + 1) % 2), buffer(s, FACES + row % 2), s->residual + row * s->cols,
                   s->step + row * s->cols, buffer(s, HEIGHTS + row % 4), s->cols, share, to);
        total += dot(to, s->residual + row * s->cols, s->cols);
    }
    return total;
}

static int sweep_fits(const Array *finest, const Array *weights, Py_ssize_t rows, Py_ssize_t cols, Py_ssize_t first,
                      Py_ssize_t last) {
    return rows > 0 && cols > 0 && 0 <= first && first <= last && last <= (rows + 1) / 2 &&
           weights_fit(weights, (rows + 1) / 2, (cols + 1) / 2) && LENGTH(finest[0]) >= rows * cols + 2 * (cols + 1) &&
           LENGTH(finest[1]) >= rows * cols && LENGTH(finest[2]) >= rows * cols;
}

/* finest_descend((quarter, step, residual), weights, (out,), rows, cols, first, last, share) -> 0.0 */
static PyObject *finest_descend(PyObject *self, PyObject *args) {
    PyObject *tuples[3];
    Array arrays[3 + WAYS + 1];
    Py_ssize_t rows, cols, first, last;
    double share;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!O!nnnnd", &PyTuple_Type, &tuples[0], &PyTuple_Type, &tuples[1], &PyTuple_Type,
                          &tuples[2], &rows, &cols, &first, &last, &share) ||
        !take_tuples(tuples, (int[]){3, WAYS, 1}, 3, arrays, "ffffffffffff"))
        return NULL;
    int fits = sweep_fits(arrays, arrays + 3, rows, cols, first, last) &&
               LENGTH(arrays[3 + WAYS]) >= ((rows + 1) / 2) * ((cols + 1) / 2);
    Sweep s = {FLOATS(arrays[0]), FLOATS(arrays[1]), FLOATS(arrays[2]), rows, cols, NULL};
    s.room = fits ? calloc(BUFFERS * (cols + 2), sizeof(float)) : NULL;
    if (s.room) {
        Py_BEGIN_ALLOW_THREADS
        descend(&s, arrays + 3, first, last, (float)share, FLOATS(arrays[3 + WAYS]));
        Py_END_ALLOW_THREADS
        free(s.room);
    }
    return finished_with(arrays, 3 + WAYS + 1, fits, s.room != NULL, 0);
}

/* finest_ascend((quarter, step, residual, coarse), weights, (out,), rows, cols, first, last, share) -> float */
static PyObject *finest_ascend(PyObject *self, PyObject *args) {
    PyObject *tuples[3];
    Array arrays[4 + WAYS + 1];
    Py_ssize_t rows, cols, first, last;
    double share, total = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!O!nnnnd", &PyTuple_Type, &tuples[0], &PyTuple_Type, &tuples[1], &PyTuple_Type,
                          &tuples[2], &rows, &cols, &first, &last, &share) ||
        !take_tuples(tuples, (int[]){4, WAYS, 1}, 3, arrays, "fffffffffffff"))
        return NULL;
    Py_ssize_t coarse_cols = (cols + 1) / 2;
    int fits = sweep_fits(arrays, arrays + 4, rows, cols, first, last) && LENGTH(arrays[4 + WAYS]) >= rows * cols &&
               LENGTH(arrays[3]) >= ((rows + 1) / 2) * coarse_cols + 2 * (coarse_cols + 1);
    Sweep s = {FLOATS(arrays[0]), FLOATS(arrays[1]), FLOATS(arrays[2]), rows, cols, NULL};
    s.room = fits ? calloc(BUFFERS * (cols + 2), sizeof(float)) : NULL;
    if (s.room) {
        Py_BEGIN_ALLOW_THREADS
        total = ascend(&s, arrays + 4, FLOATS(arrays[3]), first, last, (float)share, FLOATS(arrays[4 + WAYS]));
        Py_END_ALLOW_THREADS
        free(s.room);
    }
    return finished_with(arrays, 4 + WAYS + 1, fits, s.room != NULL, total);
}

#endif
