// SPDX-License-Identifier: Apache-2.0
// Deterministic quadrature of any lobe of microfacet.h under any Fresnel term, over the lights of
// ray.h: what quadrature.h does for GGX under Smith's masking alone, at a higher price. D is
// integrated over the azimuth in closed form where it is GGX's, else by the azimuth's rule;
// maskings depend on the elevation alone. Gauss–Legendre in pieces between the cuts of elevation.h.
//
// Inside a dielectric F is 1 outside a cone about the view and falls like a root inside, so 1 − F
// is integrated, from the cone's azimuth on: with s = sin²χ and s_c there, s = s_c + (1 − s_c)
// sin²ω makes the root, √(VoH² − cos²θ_c), a multiple of sin ω.

// sin²χ where VoH = cos θ_c: below it all is reflected.
KILN_FUNCTION real cone_start(KILN_GLOBAL const scalar* p, Ray ray) {
    const real past = lane_fma(-(ray.sum * ray.sum), ray.unit, lanes(-p[0]));
    const real across = ray.sines * ray.unit;
    const real start = past / lane_select(across > K(0.0), across, lanes(K(1.0)));
    const real none = lane_select(past > K(0.0), lanes(K(1.0)), lanes(K(0.0)));
    return lane_saturate(lane_select(across > K(0.0), start, none));
}

// How near to the start of the azimuth D changes, squared, in sin²χ; `inner` adds what F does.
KILN_FUNCTION real azimuth_width2(const Lobe what, KILN_GLOBAL const scalar* p, Eye eye, Ray ray,
                                  real hz2, real apart2, real start, const int inner) {
    const real divisor = lane_select(ray.sines > K(0.0), ray.sines, lanes(K(1.0)));
    real width2 = eye.alpha2 * hz2;
    if (what.distribution == KILN_DISTRIBUTION_CHARLIE) {
        const real tip = charlie_tip(eye.alpha);
        width2 = tip * tip / (K(4.0) * eye.alpha) * hz2;
    }
    if (what.distribution != KILN_DISTRIBUTION_BECKMANN) width2 += apart2;
    width2 = lane_select(ray.sines > K(0.0), width2 / divisor, lanes(K(1.0))) + start;
    if (!inner) return width2;
    const real past = lane_fma(ray.sum * ray.sum, ray.unit, lanes(p[0]));
    const real root = lane_select(start > K(0.0), lanes(-p[0]), past);
    const real of_root = lane_max(root, lanes(K(0.0))) / (divisor * ray.unit);
    real least = lane_min(width2, of_root);
    least = lane_min(least, lane_select(start > K(0.0), start, least));
    return lane_max(least, K(1e-6) * width2);
}

// The means over the azimuth of D, and of D F, or D (1 − F) from the cone on where `inner`.
KILN_CALLED Circle lobe_circle(const Lobe what, KILN_GLOBAL const scalar* p, Eye eye, Ray ray,
                               real gap, const int inner, KILN_GLOBAL const scalar* nodes,
                               const unsigned int count) {
    const real zero = lanes(K(0.0)), one = lanes(K(1.0));
    const real start = inner ? cone_start(p, ray) : zero;
    const real sum2 = ray.sum * ray.sum;
    const real hz2 = sum2 * (ray.one_plus_product * ray.one_plus_product) * ray.unit;
    const real apart2 = sum2 * (gap * gap) * ray.unit;
    const real width =
        K(0.5) * lane_sqrt(azimuth_width2(what, p, eye, ray, hz2, apart2, start, inner));
    const real scale = lane_select(width > zero, lane_min(width, lanes(K(0.5))), lanes(K(0.5)));
    // v = 1 − slope u, as elevation.h has it, to the fourth power.
    const real w2 = lane_sqrt(scale / (one + scale)), w = lane_sqrt(w2);
    const real slope = one / ((one + scale) * ((one + w) * (one + w2)));
    const real rest = one - start, root_rest = lane_sqrt(rest);
    Circle sum = {zero, zero};
    for (unsigned int i = 0; i < count; ++i) {
        const real t = slope * nodes[2 * i], v = one - t;
        const real v2 = v * v, v4 = v2 * v2;
        const real n = scale * (t * ((one + v) * (one + v2)));
        const real H = one / lane_fma(v4, v4, n * n);
        const real sine = K(2.0) * n * v4 * H;
        const real s = lane_fma(rest, sine * sine, start);
        const real bend = root_rest * sine / lane_sqrt(lane_select(s > zero, s, one));
        const real hxy2 = lane_fma(ray.sines, s, apart2), y = lane_fma(ray.sines, s, sum2);
        const real inverse = one / lane_select(y > zero, y, one);
        const real D = microfacet_D(what.distribution, eye.alpha, eye.c, lane_sqrt(hz2 * inverse),
                                    hxy2 * inverse);
        const real part =
            nodes[2 * i + 1] * (v2 * v * H) * D * lane_select(start > zero, bend, one);
        sum.one += part;
        if (what.fresnel == KILN_FRESNEL_NONE || (what.total && !inner)) continue;
        const real F = quadrature_fresnel(what.fresnel, p, lane_sqrt(y * ray.unit));
        sum.fresnel = lane_fma(part, inner ? one - F : F, sum.fresnel);
    }
    const real step = K(16.0) / KILN_PI * (scale * slope);
    sum.one *= step;
    sum.fresnel *= step;
    return sum;
}

// What a node adds: `smooth` is E by the closed azimuth, E by its rule, B (or what total reflection
// lacks of E) and 1 − E, the last for Smith's maskings alone.
typedef struct {
    real smooth, E, B, deficit;
} LobePart;

// 4 NoV V (1 − G2 / G1) / G1 … without the subtraction: (1 − G2 / G1) / (4 NoX (1 + Λ)).
KILN_FUNCTION real smith_missing(const Lobe what, Eye eye, Scattering s) {
    const real view = smith_reach(what.distribution, eye.alpha, s.NoV, s.sinV);
    const real masked = smith_excess(what.distribution, eye.alpha, s.NoL, s.sinL);
    const real reach = s.NoL + masked;
    real share = masked / reach;
    if (what.masking != KILN_MASKING_SMITH_SEPARABLE)
        share = s.NoV * masked / lane_fma(s.NoL, view - s.NoV, s.NoV * reach);
    return K(0.25) * share / view;
}

KILN_FUNCTION LobePart lobe_node(const Lobe what, KILN_GLOBAL const scalar* p, Eye eye,
                                 Scattering s, Ray ray, real gap, KILN_GLOBAL const scalar* nodes,
                                 const unsigned int count) {
    const int closed = what.distribution == KILN_DISTRIBUTION_GGX;
    Circle ring = {lanes(K(0.0)), lanes(K(0.0))};
    if (!closed || what.fresnel != KILN_FRESNEL_NONE)
        ring = lobe_circle(what, p, eye, ray, gap, 0, nodes, count);
    if (what.total) ring.fresnel = lobe_circle(what, p, eye, ray, gap, 1, nodes, count).fresnel;
    real mean = ring.one;
    if (closed) mean = eye.alpha2 / KILN_PI * quadrature_circle(eye, ray);
    // Where pieces have no length, at the horizon, no masking has a value, nor is one needed.
    s.NoL = lane_select(ray.cosine > K(0.0), ray.cosine, lanes(K(1.0)));
    s.sinL = ray.sine;
    const real lit = s.NoL * microfacet_visibility(what.distribution, what.masking, eye.alpha, s);
    LobePart part = {mean * lit, ring.one * lit, ring.fresnel * lit, lanes(K(0.0))};
    if (what.masking <= KILN_MASKING_SMITH_SEPARABLE)
        part.deficit = mean * smith_missing(what, eye, s);
    return part;
}

// Of 1 − E: what the view's facets send below the horizon.
KILN_FUNCTION real lobe_lost(const Lobe what, KILN_GLOBAL const scalar* p, Eye eye, Scattering s,
                             KILN_GLOBAL const scalar* nodes, const unsigned int order,
                             const unsigned int azimuths) {
    real sum = lanes(K(0.0));
    for (unsigned int i = 0; i < order; ++i) {
        const real x = eye.po * nodes[2 * i], gap = -(eye.po + x);
        Ray ray = quadrature_ray(eye, -x, gap, K(1.0) + x);
        ray.sum = eye.po * nodes[2 * (order - 1 - i)];  // 1 − u, without cancellation
        real mean;
        if (what.distribution == KILN_DISTRIBUTION_GGX)
            mean = eye.alpha2 / KILN_PI * quadrature_circle(eye, ray);
        else
            mean = lobe_circle(what, p, eye, ray, gap, 0, nodes + 2 * order, azimuths).one;
        sum += nodes[2 * i + 1] * (ray.jacobian * mean);
    }
    const real view = smith_reach(what.distribution, eye.alpha, s.NoV, s.sinV);
    return K(0.25) * (sum * eye.po) / view;
}

// The mirror, α = 0: G2 at the mirror direction. Charlie sends nothing up, as microfacet_D() says.
KILN_FUNCTION real mirror_albedo(const Lobe what, real alpha, Scattering s) {
    if (what.distribution == KILN_DISTRIBUTION_CHARLIE)
        return lane_select(s.NoV > K(0.0), lanes(K(0.0)), K(1.0) / alpha);
    if (what.masking <= KILN_MASKING_SMITH_SEPARABLE) return lanes(K(1.0));
    s.NoV = lane_max(s.NoV, lanes(K(1e-9)));
    s.NoL = s.NoV;
    return K(4.0) * (s.NoV * s.NoV) *
           microfacet_visibility(what.distribution, what.masking, lanes(K(0.0)), s);
}

// As quadrature() of quadrature.h, of any lobe; `nodes`: the rule of `order` nodes on [0, 1], then
// that of the azimuth. Where the masking is none of Smith's the deficit is 1 − E, rounded as E is.
KILN_FUNCTION Albedo quadrature_lobe(const Lobe what, KILN_GLOBAL const scalar* p, real NoV,
                                     real alpha, KILN_GLOBAL const scalar* nodes,
                                     const unsigned int order, const unsigned int azimuths) {
    NoV = lane_select(NoV > KILN_NOV_MIN, NoV, lanes(K(0.0)));
    const Eye eye =
        quadrature_eye(NoV, lane_select(alpha > KILN_ALPHA_MIN, alpha, lanes(KILN_ALPHA_MIN)));
    Scattering s;
    s.NoV = NoV;
    s.sinV = lane_sqrt((K(1.0) - NoV) * (K(1.0) + NoV));
    Cuts cuts;
    make_cuts(what, p, eye, &cuts);
    LobePart all = {lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0))};
    for (int nth = 0; nth < 2 * (cuts.count - 1); ++nth) {
        const int low = nth / 2, up = nth & 1;
        const Piece piece = up ? piece_at(cuts.cut[low + 1], cuts.cut[low], K(-1.0))
                               : piece_at(cuts.cut[low], cuts.cut[low + 1], K(1.0));
        // A sum of its own: rounding grows with the terms of a sum.
        LobePart sum = {lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0)), lanes(K(0.0))};
        for (unsigned int i = 0; i < order; ++i) {
            real gap, step;
            const Ray ray = piece_ray(eye, piece, nodes[2 * i], &gap, &step);
            const LobePart part = lobe_node(what, p, eye, s, ray, gap, nodes + 2 * order, azimuths);
            const real weight = nodes[2 * i + 1] * step;
            sum.smooth = lane_fma(weight, part.smooth, sum.smooth);
            sum.E = lane_fma(weight, part.E, sum.E);
            sum.B = lane_fma(weight, part.B, sum.B);
            sum.deficit = lane_fma(weight, part.deficit, sum.deficit);
        }
        all.smooth += sum.smooth;
        all.E += sum.E;
        all.B += sum.B;
        all.deficit += sum.deficit;
    }
    const scalar turn = K(2.0) * KILN_PI;
    const real mirror = mirror_albedo(what, alpha, s);
    Albedo result;
    if (what.masking <= KILN_MASKING_SMITH_SEPARABLE) {
        all.deficit += lobe_lost(what, p, eye, s, nodes, order, azimuths);
        result.deficit = lane_select(alpha > K(0.0), turn * all.deficit, lanes(K(0.0)));
        result.E = K(1.0) - result.deficit;
    } else {
        result.E = lane_select(alpha > K(0.0), turn * all.smooth, mirror);
        result.deficit = K(1.0) - result.E;
    }
    result.B = lanes(K(0.0));
    if (what.fresnel == KILN_FRESNEL_NONE) return result;
    // What E is off by as a sum of the azimuth's rule, B is off by too.
    const real divisor = lane_select(all.E > K(0.0), all.E, lanes(K(1.0)));
    const real share = all.B / divisor;
    const real B = result.E * (what.total ? K(1.0) - share : share);
    result.B = lane_select(alpha > K(0.0), B, mirror * quadrature_fresnel(what.fresnel, p, NoV));
    return result;
}
