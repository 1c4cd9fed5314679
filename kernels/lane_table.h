// SPDX-License-Identifier: Apache-2.0
// What look-ups in tables need: the cell of a place, the azimuth of a direction, linear
// interpolation.

#define KILN_TURN K(6.2831853071795865)

// x in [0, 2^22).
KILN_FUNCTION real lane_floor(real x) {
#if KILN_DOUBLE
    const real rounder = lanes(K(4503599627370496.0));
#else
    const real rounder = lanes(K(8388608.0));
#endif
    const real nearest = (x + rounder) - rounder;
    return lane_select(nearest > x, nearest - K(1.0), nearest);
}

// The azimuth of (x, y) as a part of a turn; 0 of no direction.
KILN_CALLED real lane_turn(real x, real y) {
    const real wide = lane_abs(x), high = lane_abs(y);
    const real size = lane_sqrt(lane_fma(x, x, y * y));
    const real divisor = lane_select(size > K(0.0), size, lanes(K(1.0)));
    const real eighth = lane_asin(lane_min(wide, high) / divisor) / KILN_TURN;
    const real quarter = lane_select(high > wide, K(0.25) - eighth, eighth);
    const real side = lane_select(x < K(0.0), K(0.5) - quarter, quarter);
    return lane_select(y < K(0.0), K(1.0) - side, side);
}

// Linear between entries of a table whose first is `table`; place in [0, last].
KILN_FUNCTION real lane_between(KILN_GLOBAL const scalar* table, real first, real place,
                                scalar last) {
    const real low = lane_min(lane_floor(place), lanes(last - K(1.0)));
    const real a = lane_gather(table, first + low);
    const real b = lane_gather(table, first + low + K(1.0));
    return lane_fma(place - low, b - a, a);
}
