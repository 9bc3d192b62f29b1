/* Sums of the surface filter over pairs of nodes, and at faces. */

#ifndef NMAPTOOL_PAIRS_H
#define NMAPTOOL_PAIRS_H

#include "arrays.h"
#include "exponential.h"
#include <stdlib.h>

/* A source is a column of ROWS floats: its place (SPACE) and its sums (SUMS). LANES columns in a row form a block. */
enum { SPACE = 6, SUMS = 4, ROWS = SPACE + SUMS, MOMENTS = SUMS + SUMS * SPACE, LANES = 8, TARGETS = 4, BOX = 6 };

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
        weights[j] = weight * (float)(place <= radius2);
    }
}

/* Sums of weights times `sum`, and their products with the places of `count` sources, for two targets: out[2][1 + SPACE]. */
SUMMING void pair_moments(const float *restrict rows, Py_ssize_t count, const float *restrict sum,
                          const float *restrict weights, float *restrict out) {
    ANY_ORDER
    const float *restrict x = rows, *restrict y = rows + count, *restrict z = rows + 2 * count;
    const float *restrict g = rows + 3 * count, *restrict h = rows + 4 * count, *restrict k = rows + 5 * count;
    const float *restrict other = weights + count;
    float s = 0, sx = 0, sy = 0, sz = 0, sg = 0, sh = 0, sk = 0;
    float t = 0, tx = 0, ty = 0, tz = 0, tg = 0, th = 0, tk = 0;
    for (Py_ssize_t j = 0; j < count; j++) {
        float v = weights[j] * sum[j], w = other[j] * sum[j];
        s += v, sx += v * x[j], sy += v * y[j], sz += v * z[j], sg += v * g[j], sh += v * h[j], sk += v * k[j];
        t += w, tx += w * x[j], ty += w * y[j], tz += w * z[j], tg += w * g[j], th += w * h[j], tk += w * k[j];
    }
    out[0] = s, out[1] = sx, out[2] = sy, out[3] = sz, out[4] = sg, out[5] = sh, out[6] = sk;
    out[7] = t, out[8] = tx, out[9] = ty, out[10] = tz, out[11] = tg, out[12] = th, out[13] = tk;
}

/* A box: lowest and highest x, y, z. */
static inline void start_box(float *box, const float *place) {
    for (int d = 0; d < 3; d++) box[d] = box[3 + d] = place[d];
}

static inline void widen_box(float *box, const float *place) {
    for (int d = 0; d < 3; d++) {
        box[d] = place[d] < box[d] ? place[d] : box[d];
        box[3 + d] = place[d] > box[3 + d] ? place[d] : box[3 + d];
    }
}

/* Squared distance of two boxes. */
static inline float box_gap2(const float *one, const float *other) {
    float total = 0;
    for (int d = 0; d < 3; d++) {
        float right = one[d] - other[3 + d], left = other[d] - one[3 + d];
        float gap = right > left ? right : left;
        total += gap > 0 ? gap * gap : 0;
    }
    return total;
}

/* Memory for the sources of one large patch: all of them, those near a group of targets, and weights. */
typedef struct {
    Py_ssize_t room;
    float *all, *close, *weights, *boxes;
} Work;

enum { FLOATS_PER_SOURCE = 2 * ROWS + TARGETS + 1 }; /* a box has BOX floats for LANES sources */

static int make_room(Work *work, Py_ssize_t count) {
    if (count <= work->room) return 1;
    free(work->all);
    work->room = 2 * count;
    work->all = malloc((size_t)FLOATS_PER_SOURCE * work->room * sizeof(float));
    if (work->all == NULL) return 0;
    work->close = work->all + ROWS * work->room;
    work->weights = work->close + ROWS * work->room;
    work->boxes = work->weights + TARGETS * work->room;
    return 1;
}

/* Copies the sources of a large patch, relative to `origin`, to rows of `count` floats; draws a box around each block. */
static void lay_sources(const float *places, const float *sums, const int64_t *start, const int64_t *near, Py_ssize_t nears,
                        const float *origin, Py_ssize_t count, const Work *work) {
    float *rows = work->all;
    Py_ssize_t j = 0;
    for (Py_ssize_t n = 0; n < nears; n++)
        for (int64_t s = start[near[n]]; s < start[near[n] + 1]; s++, j++) {
            float step[SPACE], *box = work->boxes + j / LANES * BOX;
            for (int d = 0; d < SPACE; d++) rows[d * count + j] = step[d] = places[s * SPACE + d] - origin[d];
            for (int m = 0; m < SUMS; m++) rows[(SPACE + m) * count + j] = sums[s * SUMS + m];
            if (j % LANES == 0) start_box(box, step);
            widen_box(box, step);
        }
    for (; j < count; j++) {
        for (int d = 0; d < SPACE; d++) rows[d * count + j] = 1e6f;
        for (int m = SPACE; m < ROWS; m++) rows[m * count + j] = 0;
    }
}

/* Copies the blocks within the radius of a box to rows of their own; returns the number of sources. */
static Py_ssize_t take_close(const Work *work, Py_ssize_t count, const float *box, float radius2) {
    Py_ssize_t taken = 0;
    for (Py_ssize_t b = 0; b < count / LANES; b++) taken += box_gap2(work->boxes + b * BOX, box) <= radius2;
    taken *= LANES;
    Py_ssize_t j = 0;
    for (Py_ssize_t b = 0; b < count / LANES; b++) {
        if (!(box_gap2(work->boxes + b * BOX, box) <= radius2)) continue;
        for (int m = 0; m < ROWS; m++)
            memcpy(work->close + m * taken + j, work->all + m * count + b * LANES, LANES * sizeof(float));
        j += LANES;
    }
    return taken;
}

/* The sums at up to TARGETS nodes of one large patch, the first of them at `places` and `out`. */
static void group_sums(const float *places, int targets, const float *origin, float radius2, Py_ssize_t count,
                       const Work *work, float *out) {
    float steps[TARGETS][SPACE], box[BOX];
    for (int a = 0; a < TARGETS; a++) {
        const float *place = places + (a < targets ? a : 0) * SPACE;
        for (int d = 0; d < SPACE; d++) steps[a][d] = place[d] - origin[d];
        if (a == 0) start_box(box, steps[a]);
        widen_box(box, steps[a]);
    }
    Py_ssize_t taken = take_close(work, count, box, radius2);
    for (int a = 0; a < targets + targets % 2; a++)
        pair_weights(work->close, taken, steps[a], radius2, work->weights + a * taken);
    for (int a = 0; a < targets; a += 2)
        for (int m = 0; m < SUMS; m++) {
            float found[2][1 + SPACE];
            pair_moments(work->close, taken, work->close + (SPACE + m) * taken, work->weights + a * taken, found[0]);
            for (int b = 0; b < 2 && a + b < targets; b++) {
                float *own = out + (a + b) * MOMENTS;
                own[m] = found[b][0];
                /* moments about the origin of the mesh */
                for (int d = 0; d < SPACE; d++) own[SUMS + m * SPACE + d] = found[b][1 + d] + found[b][0] * origin[d];
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
        Work work = {0, NULL, NULL, NULL, NULL};
        const float *places = FLOATS(arrays[0]), *sums = FLOATS(arrays[1]);
        for (Py_ssize_t p = first; p < last && has_memory; p++) {
            const float *origin = places + start[p] * SPACE;
            Py_ssize_t count = 0;
            for (int64_t n = indptr[p]; n < indptr[p + 1]; n++) count += start[near[n] + 1] - start[near[n]];
            count = (count + LANES - 1) / LANES * LANES;
            has_memory = make_room(&work, count);
            if (!has_memory) break;
            lay_sources(places, sums, start, near + indptr[p], indptr[p + 1] - indptr[p], origin, count, &work);
            for (int64_t t = start[p]; t < start[p + 1]; t += TARGETS) {
                int targets = start[p + 1] - t < TARGETS ? (int)(start[p + 1] - t) : TARGETS;
                group_sums(places + t * SPACE, targets, origin, (float)radius2, count, &work, FLOATS(arrays[5]) + t * MOMENTS);
            }
        }
        free(work.all);
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
