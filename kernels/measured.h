// SPDX-License-Identifier: Apache-2.0
// A measured isotropic material as a function of light and view, from the regular form that
// server/measured/lobe_tables.h makes of a point cloud, and its directional albedo.
//
// Each measured incidence, a lobe, is a table over the sphere about its mirror direction: ring k at
// sin(theta_d / 2) = (k / (rings - 1))², where peaks are, spoke j at the azimuth j / (spokes - 1)
// of a turn, both ends included. A node is R, G, B of f_r and its origin; beyond the measured part
// and below the horizon it repeats the edge under the same azimuth of the surface.
// Angles are radians. The light stands at azimuth 0.

#define KILN_ORIGIN_INTERPOLATED K(1.0)
#define KILN_ORIGIN_EXTRAPOLATED K(2.0)

// Curves of a material: p and l; KILN_CURVE levels beyond the last lobe and as many scales of the
// energy projection, one a degree; theta, cosine and sine of each lobe; KILN_EDGES theta_o a lobe,
// where its measured part ends, one a degree of azimuth.
#define KILN_CURVE 92
#define KILN_EDGES 361
#define KILN_CURVE_LEVELS 2
#define KILN_CURVE_SCALES (KILN_CURVE_LEVELS + KILN_CURVE)
#define KILN_CURVE_LOBES (KILN_CURVE_SCALES + KILN_CURVE)
#define KILN_DEGREE K(0.017453292519943296)

typedef struct {
    KILN_GLOBAL const scalar* nodes;
    KILN_GLOBAL const scalar* curves;
    unsigned int lobes, rings, spokes;
    unsigned int reciprocal_beyond;  // beyond the last lobe f(o, i) where that is known
    unsigned int symmetric;          // the mean of f(i, o) and f(o, i), and the scales
} Measured;

typedef struct {
    real f[3];
    real origin;
} MeasuredValue;

typedef struct {
    real theta, cosine, sine;  // of the light
    real x, y, z;              // the view
} MeasuredPair;

// What is left of f beyond the measured angles, equations 12 and 13 of Cezner 2024 with the curve's
// equation solved without its pole at l = 1/2; `place` runs from 0 at the edge to 1 at the horizon.
KILN_FUNCTION real measured_tail(scalar p, scalar l, real place) {
    const real inside = lane_fma(lanes(K(1.0) - K(2.0) * l), place, lanes(l * l));
    const real sum = l + lane_sqrt(lane_max(inside, lanes(K(0.0))));
    const real t = lane_select(sum > K(0.0), place / lane_select(sum > K(0.0), sum, lanes(K(1.0))),
                               lanes(K(0.0)));
    const real a = t * lane_fma(lanes(K(2.0) * (K(1.0) - l)), K(1.0) - t, t);
    return K(1.0) - a * (K(1.0) - p);
}

// One lobe at the direction d about its mirror direction.
KILN_CALLED MeasuredValue measured_lobe(Measured m, real lobe, real dx, real dy, real dz) {
    const real sine2 = lane_fma(dx, dx, dy * dy);
    const real front = sine2 / lane_select(dz > K(0.0), K(2.0) + K(2.0) * dz, lanes(K(1.0)));
    const real square = lane_select(dz > K(0.0), front, K(0.5) - K(0.5) * dz);
    const real root = lane_sqrt(lane_sqrt(lane_saturate(square)));
    const scalar last_ring = (scalar)(m.rings - 1), last_spoke = (scalar)(m.spokes - 1);
    const real ring_place = root * last_ring, spoke_place = lane_turn(dx, dy) * last_spoke;
    const real ring = lane_min(lane_floor(ring_place), lanes(last_ring - K(1.0)));
    const real spoke = lane_min(lane_floor(spoke_place), lanes(last_spoke - K(1.0)));
    const real u = ring_place - ring, v = spoke_place - spoke;
    const real row = lanes(K(4.0) * (scalar)m.spokes);
    const real node = K(4.0) * (((scalar)m.rings * lobe + ring) * (scalar)m.spokes + spoke);
    // The part beyond the edge.
    KILN_GLOBAL const scalar* angles = m.curves + KILN_CURVE_LOBES;
    const real c = lane_gather(angles + m.lobes, lobe), s = lane_gather(angles + 2 * m.lobes, lobe);
    const real ox = -(c * dx) - s * dz, oz = c * dz - s * dx;
    const real edge = lane_between(angles + 3 * m.lobes, lobe * (scalar)KILN_EDGES,
                                   lane_turn(ox, -dy) * K(360.0), K(360.0));
    const real tilt = KILN_TURN * lane_turn(oz, lane_sqrt(lane_fma(ox, ox, dy * dy)));
    const real theta = lane_min(tilt, lanes(K(0.25) * KILN_TURN));
    const real width = K(0.25) * KILN_TURN - edge;
    const real place = (theta - edge) / lane_select(width > K(0.0), width, lanes(K(1.0)));
    const real tail = measured_tail(m.curves[0], m.curves[1], lane_saturate(place));
    const real beyond = theta - edge - K(1e-5);
    const real factor = lane_select(beyond > K(0.0), tail, lanes(K(1.0)));
    MeasuredValue value;
    for (int k = 0; k < 3; ++k) {
        const real a = lane_gather(m.nodes + k, node), b = lane_gather(m.nodes + k, node + K(4.0));
        const real e = lane_gather(m.nodes + k, node + row);
        const real g = lane_gather(m.nodes + k, node + row + K(4.0));
        const real low = lane_fma(v, b - a, a), high = lane_fma(v, g - e, e);
        value.f[k] = factor * lane_fma(u, high - low, low);
    }
    const real nearest = node + lane_select(u > K(0.5), row, lanes(K(0.0))) +
                         lane_select(v > K(0.5), lanes(K(4.0)), lanes(K(0.0)));
    value.origin = lane_select(beyond > K(0.0), lanes(KILN_ORIGIN_EXTRAPOLATED),
                               lane_gather(m.nodes + 3, nearest));
    return value;
}

// Linear between lobes about the mirror direction of each, clamped to the first and the last.
KILN_CALLED MeasuredValue measured_aligned(Measured m, MeasuredPair at) {
    const real dx = -(at.cosine * at.x) - at.sine * at.z, dy = -at.y;
    const real dz = at.cosine * at.z - at.sine * at.x;
    KILN_GLOBAL const scalar* angles = m.curves + KILN_CURVE_LOBES;
    real low = lanes(K(0.0));
    for (unsigned int k = 1; k < m.lobes; ++k)
        low = lane_select(at.theta + K(1e-6) >= angles[k], lanes((scalar)k), low);
    const real high = lane_min(low + K(1.0), lanes((scalar)(m.lobes - 1)));
    const real from = lane_gather(angles, low), width = lane_gather(angles, high) - from;
    const real past = at.theta - from;
    const real share = lane_select(
        width > K(0.0), lane_saturate(past / lane_select(width > K(0.0), width, lanes(K(1.0)))),
        lanes(K(0.0)));
    const MeasuredValue a = measured_lobe(m, low, dx, dy, dz);
    MeasuredValue value = measured_lobe(m, high, dx, dy, dz);
    for (int k = 0; k < 3; ++k) value.f[k] = lane_fma(share, value.f[k] - a.f[k], a.f[k]);
    const real both = lane_max(lane_max(a.origin, value.origin), lanes(KILN_ORIGIN_INTERPOLATED));
    const real between = lane_select(width > K(0.0), both, lanes(KILN_ORIGIN_EXTRAPOLATED));
    value.origin = lane_select(past > K(1e-5), between, a.origin);
    return value;
}

// Light and view changed places, then both turned until the light is back at azimuth 0.
KILN_FUNCTION MeasuredPair measured_swapped(MeasuredPair at) {
    const real size = lane_sqrt(lane_fma(at.x, at.x, at.y * at.y));
    const real divisor = lane_select(size > K(0.0), size, lanes(K(1.0)));
    MeasuredPair back;
    back.theta = KILN_TURN * lane_turn(at.z, size);
    back.cosine = at.z;
    back.sine = size;
    back.x = at.sine * lane_select(size > K(0.0), at.x / divisor, lanes(K(1.0)));
    back.y = -(at.sine * (at.y / divisor));
    back.z = at.cosine;
    return back;
}

// The view above the horizon: beyond the last lobe f(o, i) where theta_o is within the lobes, else
// the last lobe at the level that was found on the ring between the two.
KILN_CALLED MeasuredValue measured_above(Measured m, MeasuredPair at) {
    if (!m.reciprocal_beyond) return measured_aligned(m, at);
    const real zero = lanes(K(0.0)), one = lanes(K(1.0));
    const scalar last = m.curves[KILN_CURVE_LOBES + m.lobes - 1];
    const real past = at.theta - (last + K(1e-6));
    const MeasuredPair back = measured_swapped(at);
    const real known = lane_select(back.theta > last, zero, one);
    const real swap = lane_select(past > K(0.0), known, zero);
    MeasuredPair used;
    used.theta = lane_select(swap > K(0.0), back.theta, at.theta);
    used.cosine = lane_select(swap > K(0.0), back.cosine, at.cosine);
    used.sine = lane_select(swap > K(0.0), back.sine, at.sine);
    used.x = lane_select(swap > K(0.0), back.x, at.x);
    used.y = lane_select(swap > K(0.0), back.y, at.y);
    used.z = lane_select(swap > K(0.0), back.z, at.z);
    MeasuredValue value = measured_aligned(m, used);
    const real place = lane_max(past, zero) / KILN_DEGREE;
    const real end = lanes((scalar)(KILN_CURVE - 1));
    const real level = lane_between(m.curves + KILN_CURVE_LEVELS, zero, lane_min(place, end),
                                    (scalar)(KILN_CURVE - 1));
    const real guessed = lane_select(past > K(0.0), one - swap, zero);
    const real scale = lane_select(guessed > K(0.0), level, one);
    for (int k = 0; k < 3; ++k) value.f[k] *= scale;
    const real there = lane_max(value.origin, lanes(KILN_ORIGIN_INTERPOLATED));
    value.origin = lane_select(swap > K(0.0), there, value.origin);
    return value;
}

// f_r; views below the horizon get the value at the horizon under the same azimuth.
KILN_FUNCTION MeasuredValue measured_value(Measured m, MeasuredPair at) {
    const real size = lane_sqrt(lane_fma(at.x, at.x, at.y * at.y));
    const real divisor = lane_select(size > K(0.0), size, lanes(K(1.0)));
    const real along = lane_select(size > K(0.0), at.x / divisor, lanes(K(1.0)));
    const real below = at.z;
    at.x = lane_select(below < K(0.0), along, at.x);
    at.y = lane_select(below < K(0.0), at.y / divisor, at.y);
    at.z = lane_select(below < K(0.0), lanes(K(0.0)), at.z);
    MeasuredValue value = measured_above(m, at);
    if (m.symmetric) {
        const MeasuredPair back = measured_swapped(at);
        const MeasuredValue other = measured_above(m, back);
        const scalar end = (scalar)(KILN_CURVE - 1);
        KILN_GLOBAL const scalar* scales = m.curves + KILN_CURVE_SCALES;
        const real zero = lanes(K(0.0)), bound = lanes(end);
        const real scale =
            K(0.5) * (lane_between(scales, zero, lane_min(at.theta / KILN_DEGREE, bound), end) *
                      lane_between(scales, zero, lane_min(back.theta / KILN_DEGREE, bound), end));
        for (int k = 0; k < 3; ++k) value.f[k] = scale * (value.f[k] + other.f[k]);
    }
    value.origin = lane_select(below < K(0.0), lanes(KILN_ORIGIN_EXTRAPOLATED), value.origin);
    return value;
}
