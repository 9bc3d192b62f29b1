/* The next coarser level of the multigrid solver: interpolation, couplings P^T A P and ties.

The order of the stages and the names are those of nmaptool.kernels.coarsening, where the method is explained. */

#ifndef NMAPTOOL_COARSENING_H
#define NMAPTOOL_COARSENING_H

#include "block.h"

#define HELD_SHARE 0.4f
#define DIRECT_SHARE 0.1f
#define FELT_TIE 0.02f
#define TINY 1e-37f

/* A field at the current vertex, and at one some coarse rows down and columns across. */
#define AT(field, down, across) f[(field) * PLACES + i + (down) * WIDE + (across)]
#define HERE(field) AT(field, 0, 0)
/* All vertices of a block and `margin` rows above and below it. */
#define OVER_ROWS(margin)                                                                                                      \
    for (int i = 1 + (HALO - (margin)) * WIDE; i < 1 + (HALO + BLOCK_ROWS + (margin)) * WIDE; i++)

KERNEL void sum_couplings(float *restrict f) {
    OVER_ROWS(1) {
        HERE(SUM_B) = HERE(E_O) + HERE(E_B) + HERE(S_B) + AT(S_D, -1, 0) + HERE(SE_B) + HERE(SW_B) + AT(SE_U, -1, 0) +
                      AT(SW_U, -1, 1) + HERE(OUT_B);
        HERE(SUM_U) = HERE(S_O) + HERE(S_U) + HERE(E_U) + AT(E_D, 0, -1) + HERE(SE_U) + HERE(SW_U) + AT(SE_B, 0, -1) +
                      HERE(SW_B) + HERE(OUT_U);
        HERE(SUM_D) = HERE(S_B) + HERE(S_D) + HERE(E_U) + HERE(E_D) + HERE(SE_O) + AT(SW_O, 0, 1) + HERE(SW_D) + HERE(SE_D) +
                      HERE(OUT_D);
    }
}

/* The coupling to one side, collapsed to its middle vertex; 0 if the coupling to that vertex is too weak. */
INLINE float side_of(float near, float other, float another) {
    float side = near + other + another;
    return near > DIRECT_SHARE * side ? side : 0.0f;
}

INLINE float felt_of(float tie, float sum) { return tie > FELT_TIE * (sum + tie) ? tie : 0.0f; }

/* What turns couplings into weights: 0 for a vertex that becomes off-grid. */
INLINE float scale_of(float held, float felt, float tie, float sum, float *stray) {
    float most = held + felt > TINY ? held + felt : TINY;
    *stray = held + tie < HELD_SHARE * (sum + tie) ? 1.0f : 0.0f;
    return held + tie < HELD_SHARE * (sum + tie) ? 0.0f : 1.0f / most;
}

KERNEL void interpolate_between(float *restrict f) {
    OVER_ROWS(1) {
        float one = side_of(HERE(E_O), AT(SE_U, -1, 0), HERE(SW_B)), two = side_of(HERE(E_B), HERE(SE_B), AT(SW_U, -1, 1));
        float felt = felt_of(HERE(TIE_B), HERE(SUM_B)), stray;
        float scale = scale_of(one + two + HERE(OUT_B), felt, HERE(TIE_B), HERE(SUM_B), &stray);
        HERE(STRAY_B) = stray;
        HERE(SCALE_B) = scale;
        HERE(TO_B_W) = one * scale;
        HERE(TO_B_E) = two * scale;
        HERE(LACK_B) = felt * scale;
    }
    OVER_ROWS(1) {
        float one = side_of(HERE(S_O), AT(SE_B, 0, -1), HERE(SW_B)), two = side_of(HERE(S_U), HERE(SE_U), HERE(SW_U));
        float felt = felt_of(HERE(TIE_U), HERE(SUM_U)), stray;
        float scale = scale_of(one + two + HERE(OUT_U), felt, HERE(TIE_U), HERE(SUM_U), &stray);
        HERE(STRAY_U) = stray;
        HERE(SCALE_U) = scale;
        HERE(TO_U_N) = one * scale;
        HERE(TO_U_S) = two * scale;
        HERE(LACK_U) = felt * scale;
    }
}

/* Interpolates the diagonal vertices from all eight around: the four coarse ones, and the four between by their weights. */
KERNEL void interpolate_diagonal(float *restrict f) {
    OVER_ROWS(1) {
        float north = HERE(S_B), south = HERE(S_D), west = HERE(E_U), east = HERE(E_D), stray;
        float nw = HERE(SE_O) + north * HERE(TO_B_W) + west * HERE(TO_U_N);
        float ne = AT(SW_O, 0, 1) + north * HERE(TO_B_E) + east * AT(TO_U_N, 0, 1);
        float sw = HERE(SW_D) + south * AT(TO_B_W, 1, 0) + west * HERE(TO_U_S);
        float se = HERE(SE_D) + south * AT(TO_B_E, 1, 0) + east * AT(TO_U_S, 0, 1);
        float held = HERE(OUT_D) + north * HERE(STRAY_B) + south * AT(STRAY_B, 1, 0) + west * HERE(STRAY_U) +
                     east * AT(STRAY_U, 0, 1) + nw + ne + sw + se;
        float felt = felt_of(HERE(TIE_D), HERE(SUM_D)) + north * HERE(LACK_B) + south * AT(LACK_B, 1, 0) +
                     west * HERE(LACK_U) + east * AT(LACK_U, 0, 1);
        float scale = scale_of(held, felt, HERE(TIE_D), HERE(SUM_D), &stray);
        HERE(STRAY_D) = stray;
        HERE(SCALE_D) = scale;
        HERE(TO_D_NW) = nw * scale;
        HERE(TO_D_NE) = ne * scale;
        HERE(TO_D_SW) = sw * scale;
        HERE(TO_D_SE) = se * scale;
        HERE(LACK_D) = felt * scale;
    }
}

/* Couplings to (0, 1): via the vertex beside it, and the diagonal ones south and north of that. */
KERNEL void couple_east(float *restrict f) {
    OVER_ROWS(0) {
        float b_w = HERE(TO_B_W), b_e = HERE(TO_B_E), to_south = HERE(TO_D_NW), from_south = HERE(TO_D_NE);
        float to_north = AT(TO_D_SW, -1, 0), from_north = AT(TO_D_SE, -1, 0);
        /* from the column of (0, 0) to the column between, and from there to the column of (0, 1) */
        float out = b_e * (HERE(E_O) + HERE(SW_B) * HERE(TO_U_N) + AT(SE_U, -1, 0) * AT(TO_U_S, -1, 0));
        out += from_south * (HERE(SE_O) + HERE(E_U) * HERE(TO_U_N));
        out += from_north * (AT(SW_D, -1, 0) + AT(E_U, -1, 0) * AT(TO_U_S, -1, 0));
        out += b_w * (HERE(E_B) + HERE(SE_B) * AT(TO_U_N, 0, 1) + AT(SW_U, -1, 1) * AT(TO_U_S, -1, 1));
        out += to_south * (AT(SW_O, 0, 1) + HERE(E_D) * AT(TO_U_N, 0, 1));
        out += to_north * (AT(SE_D, -1, 0) + AT(E_D, -1, 0) * AT(TO_U_S, -1, 1));
        /* within the column between */
        out += HERE(S_B) * (b_w * from_south + to_south * b_e);
        out += AT(S_D, -1, 0) * (b_w * from_north + to_north * b_e);
        out -= HERE(SUM_B) * b_w * b_e;
        out -= HERE(SUM_D) * to_south * from_south;
        out -= AT(SUM_D, -1, 0) * to_north * from_north;
        HERE(COARSE_E) = out > 0 ? out : 0.0f;
    }
}

/* Couplings to (1, 0): via the vertex below it, and the diagonal ones east and west of that. */
KERNEL void couple_south(float *restrict f) {
    OVER_ROWS(0) {
        float u_n = HERE(TO_U_N), u_s = HERE(TO_U_S), to_east = HERE(TO_D_NW), from_east = HERE(TO_D_SW);
        float to_west = AT(TO_D_NE, 0, -1), from_west = AT(TO_D_SE, 0, -1);
        float out = u_s * (HERE(S_O) + HERE(SW_B) * HERE(TO_B_W) + AT(SE_B, 0, -1) * AT(TO_B_E, 0, -1));
        out += from_east * (HERE(SE_O) + HERE(S_B) * HERE(TO_B_W));
        out += from_west * (HERE(SW_O) + AT(S_B, 0, -1) * AT(TO_B_E, 0, -1));
        out += u_n * (HERE(S_U) + HERE(SE_U) * AT(TO_B_W, 1, 0) + HERE(SW_U) * AT(TO_B_E, 1, -1));
        out += to_east * (HERE(SW_D) + HERE(S_D) * AT(TO_B_W, 1, 0));
        out += to_west * (AT(SE_D, 0, -1) + AT(S_D, 0, -1) * AT(TO_B_E, 1, -1));
        out += HERE(E_U) * (u_n * from_east + to_east * u_s);
        out += AT(E_D, 0, -1) * (u_n * from_west + to_west * u_s);
        out -= HERE(SUM_U) * u_n * u_s;
        out -= HERE(SUM_D) * to_east * from_east;
        out -= AT(SUM_D, 0, -1) * to_west * from_west;
        HERE(COARSE_S) = out > 0 ? out : 0.0f;
    }
}

/* Couplings to (1, 1) and (1, -1): via the diagonal vertex between, which belongs to (0, -1) in the second case. */
KERNEL void couple_diagonally(float *restrict f) {
    OVER_ROWS(0) {
        float into = HERE(TO_D_NW), out_of = HERE(TO_D_SE);
        float out = out_of * (HERE(SE_O) + HERE(S_B) * HERE(TO_B_W) + HERE(E_U) * HERE(TO_U_N));
        out += into * (HERE(SE_D) + HERE(S_D) * AT(TO_B_E, 1, 0) + HERE(E_D) * AT(TO_U_S, 0, 1));
        out -= HERE(SUM_D) * into * out_of;
        out += HERE(SE_B) * HERE(TO_B_W) * AT(TO_U_S, 0, 1);
        out += HERE(SE_U) * HERE(TO_U_N) * AT(TO_B_E, 1, 0);
        HERE(COARSE_SE) = out > 0 ? out : 0.0f;
    }
    OVER_ROWS(0) {
        float into = AT(TO_D_NE, 0, -1), out_of = AT(TO_D_SW, 0, -1);
        float out = out_of * (HERE(SW_O) + AT(S_B, 0, -1) * AT(TO_B_E, 0, -1) + AT(E_D, 0, -1) * HERE(TO_U_N));
        out += into * (AT(SW_D, 0, -1) + AT(S_D, 0, -1) * AT(TO_B_W, 1, -1) + AT(E_U, 0, -1) * AT(TO_U_S, 0, -1));
        out -= AT(SUM_D, 0, -1) * into * out_of;
        out += AT(SW_B, 0, -1) * AT(TO_B_E, 0, -1) * AT(TO_U_S, 0, -1);
        out += HERE(SW_U) * HERE(TO_U_N) * AT(TO_B_W, 1, -1);
        HERE(COARSE_SW) = out > 0 ? out : 0.0f;
    }
}

/* Ties to fixed heights that remain after interpolation: A (P 1). */
KERNEL void rest_of_ties(float *restrict f) {
    OVER_ROWS(1) {
        HERE(REST_O) = HERE(TIE_O) + HERE(E_O) * HERE(LACK_B) + AT(E_B, 0, -1) * AT(LACK_B, 0, -1) + HERE(S_O) * HERE(LACK_U) +
                       AT(S_U, -1, 0) * AT(LACK_U, -1, 0) + HERE(SE_O) * HERE(LACK_D) + HERE(SW_O) * AT(LACK_D, 0, -1) +
                       AT(SE_D, -1, -1) * AT(LACK_D, -1, -1) + AT(SW_D, -1, 0) * AT(LACK_D, -1, 0);
        HERE(REST_B) = HERE(TIE_B) - (HERE(TIE_B) + HERE(SUM_B)) * HERE(LACK_B) + HERE(S_B) * HERE(LACK_D) +
                       AT(S_D, -1, 0) * AT(LACK_D, -1, 0) + HERE(SE_B) * AT(LACK_U, 0, 1) + HERE(SW_B) * HERE(LACK_U) +
                       AT(SE_U, -1, 0) * AT(LACK_U, -1, 0) + AT(SW_U, -1, 1) * AT(LACK_U, -1, 1);
        HERE(REST_U) = HERE(TIE_U) - (HERE(TIE_U) + HERE(SUM_U)) * HERE(LACK_U) + HERE(E_U) * HERE(LACK_D) +
                       AT(E_D, 0, -1) * AT(LACK_D, 0, -1) + HERE(SE_U) * AT(LACK_B, 1, 0) + HERE(SW_U) * AT(LACK_B, 1, -1) +
                       AT(SE_B, 0, -1) * AT(LACK_B, 0, -1) + HERE(SW_B) * HERE(LACK_B);
        HERE(REST_D) = HERE(TIE_D) - (HERE(TIE_D) + HERE(SUM_D)) * HERE(LACK_D) + HERE(S_B) * HERE(LACK_B) +
                       HERE(S_D) * AT(LACK_B, 1, 0) + HERE(E_U) * HERE(LACK_U) + HERE(E_D) * AT(LACK_U, 0, 1);
    }
}

/* Ties of the coarse vertices: the rest, restricted. */
KERNEL void coarse_ties(float *restrict f) {
    OVER_ROWS(0) {
        float out = HERE(REST_O) + HERE(TO_B_W) * HERE(REST_B) + AT(TO_B_E, 0, -1) * AT(REST_B, 0, -1) +
                    HERE(TO_U_N) * HERE(REST_U) + AT(TO_U_S, -1, 0) * AT(REST_U, -1, 0) + HERE(TO_D_NW) * HERE(REST_D) +
                    AT(TO_D_NE, 0, -1) * AT(REST_D, 0, -1) + AT(TO_D_SW, -1, 0) * AT(REST_D, -1, 0) +
                    AT(TO_D_SE, -1, -1) * AT(REST_D, -1, -1);
        HERE(COARSE_TIE) = out > 0 ? out : 0.0f;
    }
}

/* Weights, couplings and ties with margins; then, if wanted, four fields in the order of the level. */
enum { RESULTS = 13, BACK = 4 };

/* Whether off-grid vertices are in a block or coupled to it: only then are the fields in the order of the level read. */
KERNEL int has_off_grid(const float *restrict room) {
    int any = 0;
    OVER_ROWS(1)
        any |= room[OUT_O * PLACES + i] != 0 || room[OUT_B * PLACES + i] != 0 || room[OUT_U * PLACES + i] != 0 ||
               room[OUT_D * PLACES + i] != 0 || room[STRAY_B * PLACES + i] != 0 || room[STRAY_U * PLACES + i] != 0 ||
               room[STRAY_D * PLACES + i] != 0;
    return any;
}

static void coarsen_block(float *room, const Place *at, Py_ssize_t last, Array *results, int back) {
    sum_couplings(room);
    interpolate_between(room);
    interpolate_diagonal(room);
    couple_east(room);
    couple_south(room);
    couple_diagonally(room);
    rest_of_ties(room);
    coarse_ties(room);
    for (int k = 0; k < 8; k++) give(room, TO_B_W + k, at, last, FLOATS(results[k]));
    for (int k = 0; k < 5; k++) give(room, COARSE_E + k, at, last, FLOATS(results[8 + k]));
    if (!back || !has_off_grid(room)) return;
    for (int k = 0; k < 3; k++) {
        int down = k > 0, across = k != 1;
        give_back(room, STRAY_B + k, down, across, at, last, FLOATS(results[RESULTS]));
        give_back(room, SCALE_B + k, down, across, at, last, FLOATS(results[RESULTS + 1]));
        give_back(room, LACK_B + k, down, across, at, last, FLOATS(results[RESULTS + 2]));
    }
    for (int k = 0; k < 4; k++) give_back(room, REST_O + k, k / 2, k % 2, at, last, FLOATS(results[RESULTS + 3]));
}

static int results_fit(const Array *results, int back, Py_ssize_t rows, Py_ssize_t cols, Py_ssize_t first, Py_ssize_t last) {
    Py_ssize_t coarse_rows = (rows + 1) / 2, coarse_cols = (cols + 1) / 2;
    int fits = rows > 0 && cols > 0 && 0 <= first && first <= last && last <= coarse_rows;
    for (int k = 0; k < RESULTS; k++) fits &= LENGTH(results[k]) >= coarse_rows * coarse_cols + 2 * (coarse_cols + 1);
    for (int k = RESULTS; k < RESULTS + (back ? BACK : 0); k++) fits &= LENGTH(results[k]) >= rows * cols;
    return fits;
}

/* coarsen_finest((quarter, beta, unknown), results, rows, cols, first, last, holds) -> 0.0 */
static PyObject *coarsen_finest(PyObject *self, PyObject *args) {
    PyObject *tuples[2];
    Array arrays[3 + RESULTS];
    Py_ssize_t rows, cols, first, last;
    int holds;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!nnnnp", &PyTuple_Type, &tuples[0], &PyTuple_Type, &tuples[1], &rows, &cols, &first, &last,
                          &holds) ||
        !take_tuples(tuples, (int[]){3, RESULTS}, 2, arrays, "ff?fffffffffffff"))
        return NULL;
    int fits = results_fit(arrays + 3, 0, rows, cols, first, last) && LENGTH(arrays[0]) >= rows * cols + 2 * (cols + 1) &&
               LENGTH(arrays[1]) >= rows * cols && LENGTH(arrays[2]) >= rows * cols;
    float *room = fits ? calloc(FIELDS * PLACES, sizeof(float)) : NULL;
    if (room) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t i = first; i < last; i += BLOCK_ROWS) {
            for (Py_ssize_t j = 0; j < (cols + 1) / 2; j += BLOCK_COLS) {
                Place at = {i, j, rows, cols};
                if (take_finest(room, FLOATS(arrays[0]), FLOATS(arrays[1]), (uint8_t *)arrays[2].buf, holds, &at))
                    coarsen_block(room, &at, last, arrays + 3, 0);
            }
        }
        Py_END_ALLOW_THREADS
        free(room);
    }
    return finished_with(arrays, 3 + RESULTS, fits, room != NULL, 0);
}

/* coarsen_coarse((e, s, se, sw, tie, out), results, rows, cols, first, last) -> 0.0 */
static PyObject *coarsen_coarse(PyObject *self, PyObject *args) {
    PyObject *tuples[2];
    Array arrays[6 + RESULTS + BACK];
    Py_ssize_t rows, cols, first, last;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!nnnn", &PyTuple_Type, &tuples[0], &PyTuple_Type, &tuples[1], &rows, &cols, &first, &last) ||
        !take_tuples(tuples, (int[]){6, RESULTS + BACK}, 2, arrays, "fffffffffffffffffffffff"))
        return NULL;
    int fits = results_fit(arrays + 6, 1, rows, cols, first, last) &&
               (LENGTH(arrays[5]) == 0 || LENGTH(arrays[5]) >= rows * cols);
    for (int k = 0; k < 5; k++) fits &= LENGTH(arrays[k]) >= rows * cols + 2 * (cols + 1);
    float *room = fits ? calloc(FIELDS * PLACES, sizeof(float)) : NULL;
    if (room) {
        const float *fields[6];
        for (int k = 0; k < 6; k++) fields[k] = LENGTH(arrays[k]) ? FLOATS(arrays[k]) : NULL;
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t i = first; i < last; i += BLOCK_ROWS) {
            for (Py_ssize_t j = 0; j < (cols + 1) / 2; j += BLOCK_COLS) {
                Place at = {i, j, rows, cols};
                if (take_coarse(room, fields, &at)) coarsen_block(room, &at, last, arrays + 6, 1);
            }
        }
        Py_END_ALLOW_THREADS
        free(room);
    }
    return finished_with(arrays, 6 + RESULTS + BACK, fits, room != NULL, 0);
}

#endif
