// SPDX-License-Identifier: Apache-2.0
// Where quadrature_lobe.h cuts the elevation of the light, in p = tan(e / 2) of ray.h: at the
// horizon, the mirror direction and the zenith, where a masking is not smooth, and where total
// reflection begins. Each interval between two cuts is two pieces, graded towards its ends.

// What is integrated. `total`: the Fresnel term is a dielectric's with an ior below 1.
typedef struct {
    int distribution, masking, fresnel, total;
} Lobe;

// p, p − po and 1 − p of a cut, none of which can be had from another one without loss; `width`:
// how near to it the integrand changes.
typedef struct {
    real p, gap, below, width;
} Cut;

#define KILN_CUTS_MAX 6

typedef struct {
    Cut cut[KILN_CUTS_MAX];
    int count;
} Cuts;

// By rising p, lane by lane: the lesser of two neighbours goes first, until none is left to go.
KILN_FUNCTION void sort_cuts(Cuts* cuts) {
    for (int last = cuts->count - 1; last > 0; --last)
        for (int i = 0; i < last; ++i) {
            const Cut a = cuts->cut[i], b = cuts->cut[i + 1];
            Cut lower, upper;
            lower.p = lane_select(b.p < a.p, b.p, a.p);
            upper.p = lane_select(b.p < a.p, a.p, b.p);
            lower.gap = lane_select(b.p < a.p, b.gap, a.gap);
            upper.gap = lane_select(b.p < a.p, a.gap, b.gap);
            lower.below = lane_select(b.p < a.p, b.below, a.below);
            upper.below = lane_select(b.p < a.p, a.below, b.below);
            lower.width = lane_select(b.p < a.p, b.width, a.width);
            upper.width = lane_select(b.p < a.p, a.width, b.width);
            cuts->cut[i] = lower;
            cuts->cut[i + 1] = upper;
        }
}

// Of Charlie's distribution, sin^(1/α): about the mirror direction it is a cone to the power 1 / α,
// of which a rule that starts at a width w misses w^(2 + 1/α), here 2^-30.
KILN_FUNCTION real charlie_tip(real alpha) {
    return lane_exp2(K(-30.0) * alpha / lane_fma(lanes(K(2.0)), alpha, lanes(K(1.0))));
}

// A distribution's own width about the mirror direction.
KILN_FUNCTION real peak_width(const int distribution, Eye eye) {
    if (distribution == KILN_DISTRIBUTION_CHARLIE)
        return lane_min(charlie_tip(eye.alpha), K(0.5) * lane_sqrt(eye.alpha));
    return K(0.7) * eye.alpha * eye.one_plus_po2;
}

KILN_FUNCTION void add_cut(Cuts* cuts, real p, real gap, real below, real width, real peak) {
    // However smooth it is at the cut itself, the peak may stand just behind it.
    const real near = lane_abs(gap) + peak;
    const Cut cut = {p, gap, below, lane_min(width, near)};
    cuts->cut[cuts->count] = cut;
    cuts->count = cuts->count + 1;
}

// The cone of directions at 2 θ_c from the view, sin θ_c = η, within which a dielectric's inside
// lets light through: its ends in the plane of the view. One stands at e_o / 2 ± θ_c = e / 2 where
// it is between the horizon and the zenith; the upper end may pass the zenith, and comes down on
// the mirror's side at the reciprocal of the tangent.
KILN_FUNCTION void add_cone(Cuts* cuts, KILN_GLOBAL const scalar* p, Eye eye, real peak) {
    const real zero = lanes(K(0.0)), one = lanes(K(1.0)), po = eye.po;
    const real T = lane_sqrt(lanes(p[1] / -p[0]));  // tan θ_c
    const real width = K(1e-4) * peak;
    const real above = po + T, divisor = lane_fma(-po, T, one);
    const real upper = lane_select(above < divisor, divisor, one);
    const real p_before = above / upper, p_past = lane_max(divisor, zero) / above;
    const real gap_past = lane_fma(-po, above, divisor) / above;
    const real gap_before = T * eye.one_plus_po2 / upper;
    const real below_past = lane_min((above - divisor) / above, one);
    const real below_before = (divisor - above) / upper;
    add_cut(cuts, lane_select(above < divisor, p_before, p_past),
            lane_select(above < divisor, gap_before, lane_max(gap_past, -po)),
            lane_select(above < divisor, below_before, below_past), width, peak);
    const real sum = lane_fma(po, T, one);
    add_cut(cuts, lane_max(po - T, zero) / sum, lane_max(-T * eye.one_plus_po2 / sum, -po),
            lane_min(lane_fma(T, one + po, eye.rest) / sum, one), width, peak);
}

KILN_FUNCTION void make_cuts(const Lobe what, KILN_GLOBAL const scalar* p, Eye eye, Cuts* cuts) {
    const real zero = lanes(K(0.0)), one = lanes(K(1.0)), peak = peak_width(what.distribution, eye);
    const int cloth = is_charlie_masking(what.masking);
    // Maskings have a pole at −NoL ~ NoV where NoV is far below the width, see quadrature.h.
    const real near = lane_fma(lanes(K(4.0)), eye.po, K(1e-5) * eye.alpha);
    const real pole = lane_select(eye.po > zero, lane_min(near, peak), peak);
    real horizon = K(0.5) * eye.alpha;
    if (what.distribution == KILN_DISTRIBUTION_CHARLIE) horizon = K(0.5) * lane_sqrt(eye.alpha);
    // Charlie's own masking goes like a power of 0.17 to 0.2 at both ends of the elevation.
    if (cloth) horizon = lanes(K(1e-10));
    cuts->count = 0;
    add_cut(cuts, zero, -eye.po, one, horizon, peak);
    add_cut(cuts, eye.po, zero, eye.rest, pole, peak);
    add_cut(cuts, one, eye.rest, zero, cloth ? lanes(K(1e-5)) : one, peak);
    if (cloth) {  // NoL = 1/2, e = 30°, where its two fits meet: p = 2 − √3
        const real middle = lanes(K(0.26794919243112270647)),
                   rest = lanes(K(0.73205080756887729353));
        add_cut(cuts, middle, middle - eye.po, rest, one, peak);
    }
    if (what.total) add_cone(cuts, p, eye, peak);
    sort_cuts(cuts);
}

// A piece from a cut half the way to its neighbour, `side` 1 up or −1 down: x = scale (v⁻⁸ − 1),
// v = 1 − slope u, as in ray.h. Slope and x are had from 1 − w⁸ = (1 − w)(1 + w)(1 + w²)(1 + w⁴),
// not by subtraction: an error of the slope is one of all weights.
typedef struct {
    Cut from;
    scalar side;
    real scale, slope;
} Piece;

KILN_FUNCTION Piece piece_at(Cut from, Cut to, const scalar side) {
    const real one = lanes(K(1.0)), zero = lanes(K(0.0));
    const real length = lane_max(K(0.5) * side * (to.gap - from.gap), zero);
    const real scale = lane_min(from.width, K(0.5) * length);
    const real divisor = lane_select(scale > zero, scale, one);
    const real ratio = length / divisor, w4 = one / lane_sqrt(one + ratio);
    const real w2 = lane_sqrt(w4), w = lane_sqrt(w2);
    const real slope = ratio / ((one + ratio) * ((one + w) * ((one + w2) * (one + w4))));
    // Eight times what the slope rounds by: the scale takes it back, so that u = 1 is the length.
    const real v = one - slope, lost = (one - v) - slope, v2 = v * v, v4 = v2 * v2;
    const real v8 = (v4 * v4) * (one + K(8.0) * lost / v);
    const real span = slope * ((one + v) * ((one + v2) * (one + v4)));
    const Piece piece = {from, side, length * v8 / lane_select(span > zero, span, one), slope};
    return piece;
}

// The light at a node of it; `gap` is its p − po, `step` is dNoL / du.
KILN_FUNCTION Ray piece_ray(Eye eye, Piece piece, const scalar node, real* gap, real* step) {
    const real zero = lanes(K(0.0)), one = lanes(K(1.0));
    const real t = piece.slope * node, v = one - t, v2 = v * v, v4 = v2 * v2;
    const real r = one / v, r2 = r * r, r4 = r2 * r2, r8 = r4 * r4;
    const real x = piece.side * piece.scale * (t * ((one + v) * ((one + v2) * (one + v4)))) * r8;
    *gap = piece.from.gap + x;
    const Ray ray = quadrature_ray(eye, lane_max(piece.from.p + x, zero), *gap,
                                   lane_max(piece.from.below - x, zero));
    // dx = 8 scale slope v⁻⁹ du
    *step = K(8.0) * (piece.scale * piece.slope) * (r8 * r) * ray.jacobian;
    return ray;
}
