/* The exponential of the filters' weights. */

#ifndef NMAPTOOL_EXPONENTIAL_H
#define NMAPTOOL_EXPONENTIAL_H

#include "arrays.h"

/* exp(x) for x <= 0, to 3e-7 of its value; 0 below -87. Conditions are factors: with a branch or a constant limit, GCC does
   not turn the loop into vector instructions. */
INLINE float exp_below(float x) {
    float is_above = (float)(x > -87.0f), clipped = x * is_above;
    int32_t power_of_2 = (int32_t)(clipped * 1.44269504f - 0.5f); /* rounded: cut towards 0 */
    float whole = (float)power_of_2;
    float r = clipped - whole * 0.693359375f + whole * 2.12194440e-4f;
    float p = 1.0f + r * (1.0f + r * (0.5f + r * (0.16666667f + r * (0.041666668f + r * (0.0083333338f + r * 0.0013888889f)))));
    union {
        int32_t bits;
        float value;
    } power;
    power.bits = (power_of_2 + 127) << 23;
    return p * power.value * is_above;
}

#endif
