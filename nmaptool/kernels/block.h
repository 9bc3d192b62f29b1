/* A block of a level of the multigrid solver while the next coarser level is made: 52 fields in the layout of the coarse grid.

Coarse vertex (i, j) stands for four vertices of the level: itself at (2i, 2j), called o, the one beside it (2i, 2j + 1), b,
the one under it (2i + 1, 2j), u, and the diagonal one (2i + 1, 2j + 1), d. A block has a halo of two coarse vertices; what lies
outside the grid is 0. All blocks have the same size, so every neighbour is at an offset that the compiler knows. */

#ifndef NMAPTOOL_BLOCK_H
#define NMAPTOOL_BLOCK_H

#include "arrays.h"
#include <stdlib.h>

enum { HALO = 2, BLOCK_ROWS = 24, BLOCK_COLS = 64, WIDE = BLOCK_COLS + 2 * HALO, HIGH = BLOCK_ROWS + 2 * HALO };
/* one element more at both ends of a field for steps across; a multiple of 16 elements */
enum { PLACES = (HIGH * WIDE + 2 + 15) / 16 * 16 };
/* couplings to the east, south, south-east and south-west, ties to fixed heights, couplings to off-grid vertices; by kind */
enum { E_O, E_B, E_U, E_D, S_O, S_B, S_U, S_D, SE_O, SE_B, SE_U, SE_D, SW_O, SW_B, SW_U, SW_D, TIE_O, TIE_B, TIE_U, TIE_D,
       OUT_O, OUT_B, OUT_U, OUT_D, INPUTS,
       /* results: see nmaptool.kernels.coarsening */
       SUM_B = INPUTS, SUM_U, SUM_D, STRAY_B, STRAY_U, STRAY_D, SCALE_B, SCALE_U, SCALE_D, LACK_B, LACK_U, LACK_D,
       TO_B_W, TO_B_E, TO_U_N, TO_U_S, TO_D_NW, TO_D_NE, TO_D_SW, TO_D_SE, REST_O, REST_B, REST_U, REST_D,
       COARSE_E, COARSE_S, COARSE_SE, COARSE_SW, COARSE_TIE, FIELDS };

/* Where a block lies: its first coarse row and column, and the shape of the level. */
typedef struct {
    Py_ssize_t row, col, rows, cols;
} Place;

static float *field_at(float *room, int field, Py_ssize_t row) { return room + field * PLACES + 1 + row * WIDE; }

/* Separates every second number: 2 * WIDE of a row of the level become the rows of two kinds. */
KERNEL int separate(const float *restrict row, float *restrict even, float *restrict odd) {
    int any = 0;
    for (int j = 0; j < WIDE; j++) {
        even[j] = row[2 * j];
        odd[j] = row[2 * j + 1];
        any |= row[2 * j] != 0 || row[2 * j + 1] != 0;
    }
    return any;
}

/* The columns of the level that a block holds: from `first` on, `count` of them, `skip` elements after the block's edge. */
static void columns_of(const Place *at, Py_ssize_t *first, Py_ssize_t *skip, Py_ssize_t *count) {
    Py_ssize_t begin = 2 * (at->col - HALO), end = begin + 2 * WIDE;
    *first = begin < 0 ? 0 : begin;
    *skip = *first - begin;
    *count = (end < at->cols ? end : at->cols) - *first;
}

/* Takes the block of one coarse level; whether any number is not 0. `out` is NULL if there are no off-grid vertices. */
static int take_coarse(float *room, const float *const *fields, const Place *at) {
    int any = 0;
    Py_ssize_t first, skip, count, edge = at->cols + 1;
    float row[2 * WIDE];
    columns_of(at, &first, &skip, &count);
    for (int field = 0; field < 6; field++) {
        for (Py_ssize_t y = 0; y < 2 * HIGH; y++) {
            Py_ssize_t from = 2 * (at->row - HALO) + y;
            float *even = field_at(room, 4 * field + (y % 2 ? 2 : 0), y / 2);
            memset(row, 0, sizeof(row));
            if (from >= 0 && from < at->rows && fields[field])
                memcpy(row + skip, fields[field] + (field < 5 ? edge : 0) + from * at->cols + first, count * sizeof(float));
            any |= separate(row, even, even + PLACES);
        }
    }
    return any;
}

/* Couplings and ties of a row of the finest level, from quarters of the weights of faces and from whether vertices are unknown:
   a coupling to a held vertex is a tie. `quarter` and `unknown` begin one element before the first vertex. */
KERNEL void couple_row(const float *restrict quarter, const float *restrict above, const float *restrict unknown,
                       const float *restrict over, const float *restrict under, const float *restrict beta, Py_ssize_t count,
                       float *restrict rows) {
    float *restrict e = rows, *restrict s = rows + 2 * WIDE, *restrict se = rows + 4 * WIDE, *restrict sw = rows + 6 * WIDE;
    float *restrict tie = rows + 8 * WIDE;
    for (Py_ssize_t i = 1; i <= count; i++) {
        float own = unknown[i];
        float east = quarter[i] + above[i], west = quarter[i - 1] + above[i - 1];
        float south = quarter[i] + quarter[i - 1], north = above[i] + above[i - 1];
        float total = beta[i - 1];
        total += east * (1 - unknown[i + 1]) + west * (1 - unknown[i - 1]);
        total += south * (1 - under[i]) + north * (1 - over[i]);
        total += quarter[i] * (1 - under[i + 1]) + above[i - 1] * (1 - over[i - 1]);
        total += quarter[i - 1] * (1 - under[i - 1]) + above[i] * (1 - over[i + 1]);
        e[i - 1] = east * own * unknown[i + 1];
        s[i - 1] = south * own * under[i];
        se[i - 1] = quarter[i] * own * under[i + 1];
        sw[i - 1] = quarter[i - 1] * own * under[i - 1];
        tie[i - 1] = total * own;
    }
}

/* A row of `unknown` as numbers, from one column before `first` to one after; 0 outside. */
KERNEL void unknown_row(const uint8_t *restrict unknown, const Place *at, Py_ssize_t y, Py_ssize_t first, Py_ssize_t count,
                        float *restrict row) {
    row[0] = row[count + 1] = 0.0f;
    if (y < 0 || y >= at->rows) {
        memset(row, 0, (count + 2) * sizeof(float));
        return;
    }
    Py_ssize_t from = first > 0 ? 0 : 1, to = first + count < at->cols ? count + 2 : count + 1;
    const uint8_t *here = unknown + y * at->cols + first - 1;
    for (Py_ssize_t i = from; i < to; i++) row[i] = (float)(here[i] != 0);
}

/* Takes the block of the finest level; whether any number is not 0. */
static int take_finest(float *room, const float *quarter, const float *beta, const uint8_t *unknown, int holds, const Place *at) {
    int any = 0;
    Py_ssize_t first, skip, count, cols = at->cols;
    float known[3][2 * WIDE + 2], rows[5 * 2 * WIDE];
    Py_ssize_t ready = 2 * (at->row - HALO) < 0 ? -1 : 2 * (at->row - HALO) - 1; /* the next row for `known` */
    columns_of(at, &first, &skip, &count);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 2 * WIDE + 2; i++) known[k][i] = 1.0f; /* unless vertices are held */
    memset(field_at(room, OUT_O, 0) - 1, 0, 4 * PLACES * sizeof(float));
    for (Py_ssize_t y = 0; y < 2 * HIGH; y++) {
        Py_ssize_t from = 2 * (at->row - HALO) + y;
        memset(rows, 0, sizeof(rows));
        if (from >= 0 && from < at->rows) {
            const float *here = quarter + cols + 1 + from * cols + first - 1;
            float *over = known[from % 3], *own = known[(from + 1) % 3], *under = known[(from + 2) % 3];
            for (; holds && ready < from + 2; ready++)
                unknown_row(unknown, at, ready, first, count, known[(ready + 1) % 3]);
            couple_row(here, here - cols, own, over, under, beta + from * cols + first, count, rows + skip);
        }
        for (int field = 0; field < 5; field++) {
            float *even = field_at(room, 4 * field + (y % 2 ? 2 : 0), y / 2);
            any |= separate(rows + field * 2 * WIDE, even, even + PLACES);
        }
    }
    return any;
}

/* Copies the rows of a block that lie in the coarse grid to a field with margins. */
static void give(const float *room, int field, const Place *at, Py_ssize_t last, float *out) {
    Py_ssize_t cols = (at->cols + 1) / 2, count = cols - at->col < BLOCK_COLS ? cols - at->col : BLOCK_COLS;
    for (Py_ssize_t i = 0; i < BLOCK_ROWS && at->row + i < last; i++)
        memcpy(out + (at->row + i + 1) * cols + 1 + at->col, field_at((float *)room, field, i + HALO) + HALO,
               count * sizeof(float));
}

/* Copies a kind of a block back into the order of the level. */
KERNEL void give_back(const float *restrict room, int field, int down, int across, const Place *at, Py_ssize_t last,
                      float *restrict out) {
    Py_ssize_t most = (at->cols - across + 1) / 2 - at->col, count = most < BLOCK_COLS ? most : BLOCK_COLS;
    for (Py_ssize_t i = 0; i < BLOCK_ROWS && at->row + i < last; i++) {
        Py_ssize_t y = 2 * (at->row + i) + down;
        const float *from = field_at((float *)room, field, i + HALO) + HALO;
        if (y >= at->rows) break;
        for (Py_ssize_t j = 0; j < count; j++) out[y * at->cols + 2 * (at->col + j) + across] = from[j];
    }
}

#endif
