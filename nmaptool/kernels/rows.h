/* Sparse matrices by rows: entries of row i are at start[i] to start[i + 1]; `column` and `value` hold them. */

#ifndef NMAPTOOL_ROWS_H
#define NMAPTOOL_ROWS_H

#include "arrays.h"
#include <stdlib.h>

/* Whether `start` ascends from 0 to at most the number of entries. */
KERNEL int starts_fit(const Array *start, const Array *column, const Array *value) {
    Py_ssize_t rows = LENGTH(*start) - 1;
    const int64_t *first = WHOLE(*start);
    int fits = rows >= 0 && first[0] == 0 && LENGTH(*column) == LENGTH(*value);
    for (Py_ssize_t i = 0; fits && i < rows; i++) fits &= first[i] <= first[i + 1];
    return fits && first[rows] <= LENGTH(*column);
}

/* sort_rows(row, column, value, start, columns, values) -> 0.0: entries in any order, sorted by row; their order is kept */
static PyObject *sort_rows(PyObject *self, PyObject *args) {
    PyObject *o[6];
    Array arrays[6];
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOO", &o[0], &o[1], &o[2], &o[3], &o[4], &o[5]) || !take_arrays(o, arrays, "qqfqqf", 6, 3))
        return NULL;
    Py_ssize_t count = LENGTH(arrays[0]), rows = LENGTH(arrays[3]) - 1;
    int fits = rows >= 0 && LENGTH(arrays[1]) == count && LENGTH(arrays[2]) == count && LENGTH(arrays[4]) == count &&
               LENGTH(arrays[5]) == count && all_below(WHOLE(arrays[0]), count, rows);
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        const int64_t *row = WHOLE(arrays[0]), *column = WHOLE(arrays[1]);
        int64_t *start = WHOLE(arrays[3]), *columns = WHOLE(arrays[4]);
        memset(start, 0, (rows + 1) * sizeof(int64_t));
        for (Py_ssize_t k = 0; k < count; k++) start[row[k] + 1]++;
        for (Py_ssize_t i = 0; i < rows; i++) start[i + 1] += start[i];
        for (Py_ssize_t k = 0; k < count; k++) {
            int64_t at = start[row[k]]++;
            columns[at] = column[k];
            FLOATS(arrays[5])[at] = FLOATS(arrays[2])[k];
        }
        /* every start has moved to its end */
        for (Py_ssize_t i = rows; i > 0; i--) start[i] = start[i - 1];
        start[0] = 0;
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 6, fits, 1, 0);
}

/* rows_times(start, column, value, x, out) -> 0.0: the product with a vector */
static PyObject *rows_times(PyObject *self, PyObject *args) {
    PyObject *o[5];
    Array arrays[5];
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOO", &o[0], &o[1], &o[2], &o[3], &o[4]) || !take_arrays(o, arrays, "qqfff", 5, 1))
        return NULL;
    int fits = starts_fit(&arrays[0], &arrays[1], &arrays[2]) && LENGTH(arrays[4]) == LENGTH(arrays[0]) - 1 &&
               all_below(WHOLE(arrays[1]), LENGTH(arrays[1]), LENGTH(arrays[3]));
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        const int64_t *start = WHOLE(arrays[0]), *column = WHOLE(arrays[1]);
        const float *value = FLOATS(arrays[2]), *x = FLOATS(arrays[3]);
        for (Py_ssize_t i = 0; i < LENGTH(arrays[4]); i++) {
            float sum = 0;
            for (int64_t k = start[i]; k < start[i + 1]; k++) sum += value[k] * x[column[k]];
            FLOATS(arrays[4])[i] = sum;
        }
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 5, fits, 1, 0);
}

/* Adds a row of the second matrix, times `factor`, to the row whose sums are in `sum`; `seen` holds the columns met in `row`. */
static int64_t add_row(const int64_t *column, const float *value, int64_t count, float factor, int64_t row, float *sum,
                       int64_t *seen, int64_t *columns, int64_t found) {
    for (int64_t k = 0; k < count; k++) {
        int64_t j = column[k];
        if (seen[j] != row) {
            seen[j] = row;
            sum[j] = 0;
            columns[found++] = j;
        }
        sum[j] += factor * value[k];
    }
    return found;
}

/* Entries of a product, before equal columns are added up; -1 if a column is too large. */
static int64_t most_entries(const Array *first, Py_ssize_t rows, const int64_t *second) {
    const int64_t *start = WHOLE(first[0]), *column = WHOLE(first[1]);
    int64_t most = 0;
    for (int64_t k = 0; k < start[LENGTH(first[0]) - 1]; k++) {
        if (column[k] < 0 || column[k] >= rows) return -1;
        most += second[column[k] + 1] - second[column[k]];
    }
    return most;
}

/* rows_product(start, column, value, start, column, value, count, start, columns, values) -> number of entries */
static PyObject *rows_product(PyObject *self, PyObject *args) {
    PyObject *o[9];
    Array arrays[9];
    Py_ssize_t count;
    int64_t found = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOOnOOO", &o[0], &o[1], &o[2], &o[3], &o[4], &o[5], &count, &o[6], &o[7], &o[8]) ||
        !take_arrays(o, arrays, "qqfqqfqqf", 9, 3))
        return NULL;
    Py_ssize_t rows = LENGTH(arrays[0]) - 1;
    int fits = count >= 0 && starts_fit(&arrays[0], &arrays[1], &arrays[2]) && starts_fit(&arrays[3], &arrays[4], &arrays[5]) &&
               all_below(WHOLE(arrays[4]), LENGTH(arrays[4]), count) && LENGTH(arrays[6]) == rows + 1;
    int64_t most = fits ? most_entries(arrays, LENGTH(arrays[3]) - 1, WHOLE(arrays[3])) : -1;
    fits &= most >= 0 && LENGTH(arrays[7]) >= most && LENGTH(arrays[8]) >= most;
    float *sum = fits ? malloc((count + 1) * sizeof(float)) : NULL;
    int64_t *seen = sum ? malloc((count + 1) * sizeof(int64_t)) : NULL;
    if (seen) {
        Py_BEGIN_ALLOW_THREADS
        const int64_t *start = WHOLE(arrays[0]), *second = WHOLE(arrays[3]);
        int64_t *columns = WHOLE(arrays[7]);
        for (Py_ssize_t j = 0; j < count; j++) seen[j] = -1;
        WHOLE(arrays[6])[0] = 0;
        for (Py_ssize_t i = 0; i < rows; i++) {
            int64_t begin = found;
            for (int64_t k = start[i]; k < start[i + 1]; k++) {
                int64_t at = second[WHOLE(arrays[1])[k]], to = second[WHOLE(arrays[1])[k] + 1];
                found = add_row(WHOLE(arrays[4]) + at, FLOATS(arrays[5]) + at, to - at, FLOATS(arrays[2])[k], i, sum, seen,
                                columns, found);
            }
            for (int64_t k = begin; k < found; k++) FLOATS(arrays[8])[k] = sum[columns[k]];
            WHOLE(arrays[6])[i + 1] = found;
        }
        Py_END_ALLOW_THREADS
    }
    int has_memory = seen != NULL;
    free(seen);
    free(sum);
    return finished_with(arrays, 9, fits, has_memory, (double)found);
}

#endif
