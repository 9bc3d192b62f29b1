/* The triangles of a height field: two for each pixel. */

#ifndef NMAPTOOL_FACES_H
#define NMAPTOOL_FACES_H

#include <math.h>

#include "arrays.h"

/* Whether the surface bends less along the falling diagonal, for pixels whose corners and their neighbours are in four rows. */
KERNEL void falling_row(const double *restrict a, const double *restrict b, const double *restrict c, const double *restrict d,
                        Py_ssize_t count, unsigned char *restrict out) {
    for (Py_ssize_t j = 0; j < count; j++) {
        double falling = fabs(a[j] - b[j + 1] - c[j + 2] + d[j + 3]);
        double rising = fabs(d[j] - c[j + 1] - b[j + 2] + a[j + 3]);
        out[j] = falling <= rising;
    }
}

/* The same for a pixel at the left or right edge, where the nearest heights are repeated. */
static unsigned char falling_pixel(const double *const rows[4], Py_ssize_t col, Py_ssize_t width) {
    Py_ssize_t left = col > 0 ? col - 1 : 0, right = col + 2 < width ? col + 2 : width - 1;
    double falling = fabs(rows[0][left] - rows[1][col] - rows[2][col + 1] + rows[3][right]);
    double rising = fabs(rows[3][left] - rows[2][col] - rows[1][col + 1] + rows[0][right]);
    return falling <= rising;
}

/* falling_diagonals(z, before, out): for rows of pixels from `before` on, of some rows of heights */
static PyObject *falling_diagonals(PyObject *self, PyObject *args) {
    PyObject *objects[2];
    Array arrays[2];
    Py_ssize_t before, width;
    (void)self;
    if (!PyArg_ParseTuple(args, "OnnO", &objects[0], &width, &before, &objects[1])) return NULL;
    if (!take_arrays(objects, arrays, "d?", 2, 1)) return NULL;
    Py_ssize_t rows = width > 1 ? LENGTH(arrays[0]) / width : 0, count = width > 1 ? LENGTH(arrays[1]) / (width - 1) : 0;
    int fits = width > 1 && before >= 0 && before + count < rows && LENGTH(arrays[0]) == rows * width;
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t i = 0; i < count; i++) {
            const double *z[4];
            unsigned char *out = BYTES(arrays[1]) + i * (width - 1);
            for (Py_ssize_t k = 0; k < 4; k++) {
                Py_ssize_t row = before + i + k - 1;
                z[k] = DOUBLES(arrays[0]) + (row < 0 ? 0 : row < rows ? row : rows - 1) * width;
            }
            if (width > 3) falling_row(z[0], z[1], z[2], z[3], width - 3, out + 1);
            out[0] = falling_pixel(z, 0, width);
            out[width - 2] = falling_pixel(z, width - 2, width);
        }
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 2, fits, 1, 0);
}

/* Two triangles with the corners nw, sw, se, ne, split along the falling or the rising diagonal. */
INLINE void put_faces(int32_t *to, int32_t nw, int32_t width, int falls, int first, int last) {
    int32_t ne = nw + 1, sw = nw + width, se = nw + width + 1;
    to[first] = nw;
    to[1] = sw;
    to[last] = falls ? se : ne;
    to[3 + first] = falls ? nw : sw;
    to[4] = se;
    to[3 + last] = ne;
}

/* pixel_faces(inside, falls, width, is_back, out): the vertices are numbered row by row, `width` in each */
static PyObject *pixel_faces(PyObject *self, PyObject *args) {
    PyObject *objects[3];
    Array arrays[3];
    Py_ssize_t width, found = 0;
    int is_back;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOnpO", &objects[0], &objects[1], &width, &is_back, &objects[2])) return NULL;
    if (!take_arrays(objects, arrays, "??i", 3, 1)) return NULL;
    const unsigned char *inside = BYTES(arrays[0]), *falls = BYTES(arrays[1]);
    int32_t *out = INTS(arrays[2]);
    Py_ssize_t pixels = LENGTH(arrays[0]), most = LENGTH(arrays[2]) / 6;
    int fits = width > 1 && LENGTH(arrays[1]) == pixels && pixels < INT32_MAX / 2 - width;
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        int first = is_back ? 2 : 0, last = is_back ? 0 : 2;
        for (Py_ssize_t at = 0; at < pixels; at += width - 1)
            for (Py_ssize_t j = at; j < at + width - 1 && j < pixels && found < most; j++)
                if (inside[j]) put_faces(out + 6 * found++, (int32_t)(j + at / (width - 1)), (int32_t)width, falls[j], first, last);
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 3, fits, 1, (double)found);
}

#endif
