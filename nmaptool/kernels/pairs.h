/* Sums of the surface filter over pairs of nodes, and at faces. */

#ifndef NMAPTOOL_PAIRS_H
#define NMAPTOOL_PAIRS_H

#include "arrays.h"
#include <stdlib.h>

enum { SPACE = 6, SUMS = 4, MOMENTS = SUMS + SUMS * SPACE, LANES = 8, TARGETS = 4 };

/* exp(x) for x <= 0, to 3e-7 of its value; 0 below -87 */
INLINE float exp_below(float x) {
    float clipped = x < -87.0f ? -87.0f : x;
    int32_t power_of_2 = (int32_t)(clipped * 1.44269504f - 0.5f); /* rounded: cut towards 0 */
    float whole = (float)power_of_2;
    float r = clipped - whole * 0.693359375f + whole * 2.12194440e-4f;
    float p = 1.0f + r * (1.0f + r * (0.5f + r * (0.16666667f + r * (0.041666668f + r * (0.0083333338f + r * 0.0013888889f)))));
    union {
        int32_t bits;
        float value;
    } power;
    power.bits = (power_of_2 + 127) << 23;
    return x < -87.0f ? 0.0f : p * power.value;
}

/* Weights of `count` sources (SPACE rows of floats) for one target: both Gaussians, 0 beyond the radius in the first three. */
SUMMING void pair_weights(const float *restrict rows, Py_ssize_t count, const float *restrict target, float radius2,
                          float *restrict weights) {
    ANY_ORDER
    const float *restrict x = rows, *restrict y = rows + count, *restrict z = rows + 2 * count;
    const float *restrict g = rows + 3 * count, *restrict h = rows + 4 * count, *restrict k = rows + 5 * count;
    float tx = target[0], ty = target[1], tz = target[2], tg = target[3], th = target[4], tk = target[5];
    for (Py_ssize_t j = 0; j < count; j++) {
        float a = x[j] - tx, b = y[j] - ty, c = z[j] - tz;
        float d = g[j] - tg, e = h[j] - th, f = k[j] - tk;
        float place = a * a + b * b + c * c;
        float weight = exp_below(-0.5f * (place + (d * d + e * e + f * f)));
        weights[j] = place <= radius2 ? weight : 0.0f;
    }
}

/* Products of TARGETS rows of weights with two rows of values, into two rows of `out`. */
SUMMING void dot_rows(const float *restrict weights, const float *restrict values, Py_ssize_t count, float *restrict out) {
    ANY_ORDER
    const float *restrict w0 = weights, *restrict w1 = weights + count;
    const float *restrict w2 = weights + 2 * count, *restrict w3 = weights + 3 * count;
    const float *restrict other = values + count;
    float s0 = 0, s1 = 0, s2 = 0, s3 = 0, t0 = 0, t1 = 0, t2 = 0, t3 = 0;
    for (Py_ssize_t j = 0; j < count; j++) {
        float a = values[j], b = other[j];
        s0 += w0[j] * a, s1 += w1[j] * a, s2 += w2[j] * a, s3 += w3[j] * a;
        t0 += w0[j] * b, t1 += w1[j] * b, t2 += w2[j] * b, t3 += w3[j] * b;
    }
    out[0] = s0, out[1] = s1, out[2] = s2, out[3] = s3;
    out[4] = t0, out[5] = t1, out[6] = t2, out[7] = t3;
}

/* Copies a source into column `j`: its place relative to `origin`, and its moments. */
static inline void lay_source(float *restrict rows, Py_ssize_t count, Py_ssize_t j, const float *restrict place,
                              const float *restrict sums, const float *restrict origin) {
    float step[SPACE];
    for (int d = 0; d < SPACE; d++) rows[d * count + j] = step[d] = place[d] - origin[d];
    for (int m = 0; m < SUMS; m++) {
        rows[(SPACE + m) * count + j] = sums[m];
        for (int d = 0; d < SPACE; d++) rows[(SPACE + SUMS + m * SPACE + d) * count + j] = sums[m] * step[d];
    }
}

/* The sums at the nodes of one large patch; `work` holds (SPACE + MOMENTS + TARGETS) * count floats. */
static void patch_sums(const float *places, const float *sums, const int64_t *start, const int64_t *near, Py_ssize_t nears,
                       int64_t first, int64_t last, float radius2, Py_ssize_t count, float *work, float *out) {
    const float *origin = places + first * SPACE;
    float *weights = work + (SPACE + MOMENTS) * count;
    Py_ssize_t j = 0;
    for (Py_ssize_t n = 0; n < nears; n++)
        for (int64_t s = start[near[n]]; s < start[near[n] + 1]; s++)
            lay_source(work, count, j++, places + s * SPACE, sums + s * SUMS, origin);
    for (; j < count; j++) {
        for (int d = 0; d < SPACE; d++) work[d * count + j] = 1e6f;
        for (int m = SPACE; m < SPACE + MOMENTS; m++) work[m * count + j] = 0;
    }
    for (int64_t t = first; t < last; t += TARGETS) {
        int targets = last - t < TARGETS ? (int)(last - t) : TARGETS;
        for (int a = 0; a < TARGETS; a++) {
            float step[SPACE];
            const float *place = places + (a < targets ? t + a : t) * SPACE;
            for (int d = 0; d < SPACE; d++) step[d] = place[d] - origin[d];
            pair_weights(work, count, step, radius2, weights + a * count);
        }
        for (int m = 0; m < MOMENTS; m += 2) {
            float found[2 * TARGETS];
            dot_rows(weights, work + (SPACE + m) * count, count, found);
            for (int a = 0; a < targets; a++) {
                out[(t + a) * MOMENTS + m] = found[a];
                out[(t + a) * MOMENTS + m + 1] = found[TARGETS + a];
            }
        }
        /* moments about the origin of the mesh */
        for (int a = 0; a < targets; a++) {
            float *own = out + (t + a) * MOMENTS;
            for (int m = 0; m < SUMS; m++)
                for (int d = 0; d < SPACE; d++) own[SUMS + m * SPACE + d] += own[m] * origin[d];
        }
    }
}

/* pair_sums(places, sums, start, indptr, near, first, last, radius2, out) for the large patches from first to last */
static PyObject *pair_sums(PyObject *self, PyObject *args) {
    PyObject *objects[6];
    Py_ssize_t first, last;
    double radius2;
    Array arrays[6];
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOnndO", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &first, &last,
                          &radius2, &objects[5]))
        return NULL;
    if (!take_arrays(objects, arrays, "ffqqqf", 6, 1)) return NULL;
    const int64_t *start = WHOLE(arrays[2]), *indptr = WHOLE(arrays[3]), *near = WHOLE(arrays[4]);
    Py_ssize_t patches = LENGTH(arrays[2]) - 1, nodes = LENGTH(arrays[1]) / SUMS;
    int fits = 0 <= first && first <= last && last <= patches && LENGTH(arrays[3]) == patches + 1 &&
               LENGTH(arrays[0]) >= nodes * SPACE && LENGTH(arrays[5]) >= nodes * MOMENTS && start[patches] == nodes &&
               indptr[patches] == LENGTH(arrays[4]) && all_below(near, LENGTH(arrays[4]), patches);
    int has_memory = 1;
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        float *work = NULL;
        Py_ssize_t room = 0;
        for (Py_ssize_t p = first; p < last && has_memory; p++) {
            Py_ssize_t count = 0;
            for (int64_t n = indptr[p]; n < indptr[p + 1]; n++) count += start[near[n] + 1] - start[near[n]];
            count = (count + LANES - 1) / LANES * LANES;
            if (count > room) {
                free(work);
                room = 2 * count;
                work = malloc((size_t)(SPACE + MOMENTS + TARGETS) * room * sizeof(float));
                has_memory = work != NULL;
            }
            if (has_memory)
                patch_sums(FLOATS(arrays[0]), FLOATS(arrays[1]), start, near + indptr[p], indptr[p + 1] - indptr[p],
                           start[p], start[p + 1], (float)radius2, count, work, FLOATS(arrays[5]));
        }
        free(work);
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 6, fits, has_memory, 0);
}

/* at_faces(sums, places, node, where, lead, out): the sums at faces, extrapolated from their nodes. */
static PyObject *at_faces(PyObject *self, PyObject *args) {
    PyObject *objects[6];
    Array arrays[6];
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOO", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &objects[5]))
        return NULL;
    if (!take_arrays(objects, arrays, "ffqddd", 6, 1)) return NULL;
    const float *sums = FLOATS(arrays[0]), *places = FLOATS(arrays[1]);
    const int64_t *node = WHOLE(arrays[2]);
    const double *where = DOUBLES(arrays[3]), *lead = DOUBLES(arrays[4]);
    double *out = DOUBLES(arrays[5]);
    Py_ssize_t faces = LENGTH(arrays[2]), nodes = LENGTH(arrays[0]) / MOMENTS;
    int fits = LENGTH(arrays[1]) >= nodes * SPACE && LENGTH(arrays[3]) >= 3 * faces && LENGTH(arrays[4]) >= 3 * faces &&
               LENGTH(arrays[5]) >= SUMS * faces && all_below(node, faces, nodes);
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t i = 0; i < faces; i++) {
            const float *own = sums + node[i] * MOMENTS, *place = places + node[i] * SPACE;
            double step[SPACE];
            for (int d = 0; d < 3; d++) {
                step[d] = where[3 * i + d] - place[d];
                step[3 + d] = lead[3 * i + d] - place[3 + d];
            }
            for (int m = 0; m < SUMS; m++) {
                double total = own[m];
                for (int d = 0; d < SPACE; d++)
                    total += ((double)own[SUMS + m * SPACE + d] - (double)own[m] * place[d]) * step[d];
                out[SUMS * i + m] = total;
            }
        }
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 6, fits, 1, 0);
}

#endif
