// SPDX-License-Identifier: Apache-2.0
// Deterministic quadrature of the isotropic GGX lobe: E, the deficit 1 − E, and B, which is E under
// a Fresnel term, over the lights of ray.h.
//
// Rules: Gauss–Legendre under x = β (v⁻ᵐ − 1), v linear in the node (m = 8 outside, 4 inside).
// It is as dense as the peak is narrow near x = 0, and thins out over the decades beyond, as the
// lobe's tails do. β is the peak's own width: α (1 + p_o²) about the mirror direction, α / 2 at the
// horizon, κ / 2 in the azimuth. Four pieces: above the mirror direction, below it, from the
// horizon up to the same point, and below the horizon (no peak: plain Gauss–Legendre).
//
// At order n these take n, n, n/2, n/2 nodes; the azimuth has an order of its own. Largest errors,
// in double, over NoV and α in [1e-4, 1]: see server/compute/quadrature.h.

typedef struct {
    real E, B, deficit;
} Albedo;

// Of a node or a piece; E is the rule's in the azimuth too, and 0 where B is not asked for.
typedef Albedo Part;

// One node of the pieces above the horizon.
KILN_FUNCTION Part quadrature_node(const int masking, const int model, KILN_GLOBAL const scalar* p,
                                   Eye eye, Ray ray, real weight, KILN_GLOBAL const scalar* nodes,
                                   const unsigned int count) {
    const real across = eye.alpha * ray.sine, excess = across * across;
    const real S = lane_sqrt(lane_fma(ray.cosine, ray.cosine, excess));
    // At NoV = 0 the pieces below the mirror direction are points at the horizon, of weight 0.
    const real NoL = lane_select(ray.cosine > K(0.0), ray.cosine, S);
    const real measure = weight * ray.jacobian;
    const real circle = measure * quadrature_circle(eye, ray);
    const real shadowing = smith_G2_over_G1(masking, eye.c, NoL, S);
    Part part;
    part.deficit = circle * smith_deficit(masking, eye.c, NoL, S, excess);
    part.B = part.E = lanes(K(0.0));
    if (model != KILN_FRESNEL_NONE) {
        const Circle by_rule = quadrature_circle_fresnel(model, p, ray, nodes, count);
        const real lit = measure * shadowing;
        part.B = lit * by_rule.fresnel;
        part.E = lit * by_rule.one;
    }
    return part;
}

#define KILN_PIECE_ABOVE 0    // from the mirror direction up
#define KILN_PIECE_BELOW 1    // from there halfway to the horizon
#define KILN_PIECE_HORIZON 2  // from the horizon up to meet it

// `inner`, `inner_count`: the azimuth's rule.
KILN_FUNCTION Part quadrature_piece(const int masking, const int model, KILN_GLOBAL const scalar* p,
                                    const int piece, Eye eye, KILN_GLOBAL const scalar* nodes,
                                    const unsigned int count, KILN_GLOBAL const scalar* inner,
                                    const unsigned int inner_count) {
    const real peak = K(0.7) * eye.alpha * eye.one_plus_po2;
    // G2/G1 has a pole at −NoL ~ NoV where NoV << α, ever weaker: none is left at NoV = 0.
    const real near = lane_fma(lanes(K(4.0)), eye.po, K(1e-5) * eye.alpha);
    const real pole = lane_select(eye.po > K(0.0), near, peak);
    Grading g;
    if (piece == KILN_PIECE_ABOVE)
        g = graded_eighth(eye.rest, lane_select(pole < peak, pole, peak));
    else
        g = graded_eighth(K(0.5) * eye.po, piece == KILN_PIECE_BELOW ? peak : K(0.5) * eye.alpha);
    Part sum = {lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0))};
    for (unsigned int i = 0; i < count; ++i) {
        const real v = lane_fma(g.slope, lanes(nodes[2 * i]), lanes(K(1.0)));
        const real r = K(1.0) / v, r2 = r * r, r4 = r2 * r2, r8 = r4 * r4;
        const real x = lane_fma(g.scale, r8, -g.scale);
        const real weight = nodes[2 * i + 1] * (r8 * r);
        Ray ray;
        if (piece == KILN_PIECE_ABOVE) {
            const real rest = eye.rest - x;
            ray =
                quadrature_ray(eye, eye.po + x, x, lane_select(rest > K(0.0), rest, lanes(K(0.0))));
        } else if (piece == KILN_PIECE_BELOW) {
            ray = quadrature_ray(eye, eye.po - x, -x, eye.rest + x);
        } else {
            ray = quadrature_ray(eye, x, x - eye.po, K(1.0) - x);
        }
        const Part part = quadrature_node(masking, model, p, eye, ray, weight, inner, inner_count);
        sum.B += part.B;
        sum.E += part.E;
        sum.deficit += part.deficit;
    }
    // dx = −8 scale slope v⁻⁹ du
    const real step = K(-8.0) * (g.scale * g.slope);
    sum.B *= step;
    sum.E *= step;
    sum.deficit *= step;
    return sum;
}

// What the view's facets send below the horizon.
KILN_FUNCTION real quadrature_lost(Eye eye, KILN_GLOBAL const scalar* nodes,
                                   const unsigned int count) {
    real sum = lanes(K(0.0));
    for (unsigned int i = 0; i < count; ++i) {
        const real x = eye.po * nodes[2 * i];
        Ray ray = quadrature_ray(eye, -x, -(eye.po + x), K(1.0) + x);
        ray.sum = eye.po * nodes[2 * (count - 1 - i)];  // 1 − u, without cancellation
        sum += nodes[2 * i + 1] * (ray.jacobian * quadrature_circle(eye, ray));
    }
    return sum * eye.po;
}

// A cosine is squared beside others, and 1 over that must be a number: in float from 5e-20 on.
#undef KILN_ALPHA_MIN
#undef KILN_NOV_MIN
#if KILN_DOUBLE
#define KILN_ALPHA_MIN K(1e-12)
#define KILN_NOV_MIN K(1e-25)
#else
#define KILN_ALPHA_MIN K(1e-8)
#define KILN_NOV_MIN K(1e-18)
#endif

// `nodes`: (node, weight) of the Gauss–Legendre rule of `order` nodes on [0, 1] by rising node,
// then those of order / 2, then those of the azimuth. `model`: the Fresnel term in B, with its
// scalars p (fresnel.h); KILN_FRESNEL_NONE leaves B out (0), KILN_FRESNEL_SCHLICK makes it that of
// F90's weight. α = 0 is the mirror, the limit; widths between 0 and KILN_ALPHA_MIN, beyond what
// the squares can hold, count as that, and cosines below KILN_NOV_MIN, far below any width, as 0.
KILN_FUNCTION Albedo quadrature(const int masking, const int model, KILN_GLOBAL const scalar* p,
                                real NoV, real alpha, KILN_GLOBAL const scalar* nodes,
                                const unsigned int order, const unsigned int azimuths) {
    NoV = lane_select(NoV > KILN_NOV_MIN, NoV, lanes(K(0.0)));
    const real width = lane_select(alpha > KILN_ALPHA_MIN, alpha, lanes(KILN_ALPHA_MIN));
    const Eye eye = quadrature_eye(NoV, width);
    KILN_GLOBAL const scalar* coarse = nodes + 2 * order;
    KILN_GLOBAL const scalar* inner = coarse + 2 * (order / 2);
    const Part above =
        quadrature_piece(masking, model, p, KILN_PIECE_ABOVE, eye, nodes, order, inner, azimuths);
    const Part below =
        quadrature_piece(masking, model, p, KILN_PIECE_BELOW, eye, nodes, order, inner, azimuths);
    const Part horizon = quadrature_piece(masking, model, p, KILN_PIECE_HORIZON, eye, coarse,
                                          order / 2, inner, azimuths);
    const real lost = quadrature_lost(eye, coarse, order / 2);
    // α² / (NoV + S) before the integrals over NoL
    const real sine = lane_sqrt((K(1.0) - NoV) * (K(1.0) + NoV)) * width;
    const real factor = eye.alpha2 / (NoV + lane_sqrt(lane_fma(NoV, NoV, sine * sine)));
    const real direct = above.E + below.E + horizon.E;
    const real divisor = lane_select(direct > K(0.0), direct, lanes(K(1.0)));
    const real missing = factor * (above.deficit + below.deficit + horizon.deficit + lost);
    // The deficit is the smaller and the smoother of the two, so its complement is the better E,
    // and what E is off by as a sum of the rule's, B is off by too.
    Albedo result;
    result.deficit = lane_select(alpha > K(0.0), missing, lanes(K(0.0)));
    result.E = K(1.0) - result.deficit;
    result.B = lanes(K(0.0));
    if (model != KILN_FRESNEL_NONE)
        result.B =
            lane_select(alpha > K(0.0), result.E * ((above.B + below.B + horizon.B) / divisor),
                        quadrature_fresnel(model, p, NoV));
    return result;
}
