// SPDX-License-Identifier: Apache-2.0
// One light of the deterministic quadrature of the isotropic GGX lobe (quadrature.h).
//
// The light's elevation is e, the view's e_o; p = tan(e/2) makes every trigonometric factor
// rational. Over the azimuth the lobe is (y / (y − k))², with y = |V + L|² = (2 V·h)²; for F = 1
// its integral is elementary (`circle`), which leaves one dimension for E. The deficit integrates
// 1 − G2/G1 above the horizon and G1 alone below it (p < 0, down to the view's mirror image), with
// no subtraction. B adds the azimuth as an inner rule, for any smooth F(VoH): q = tan(χ/2), with 2χ
// the azimuth from the mirror direction.

// The view and what it shares with every light. po = tan(e_o / 2), rest = 1 − po.
typedef struct {
    real po, rest, one_plus_po2;
    real c;  // NoV / S(NoV), see smith.h
    real alpha, alpha2, one_minus_alpha2;
} Eye;

KILN_FUNCTION Eye quadrature_eye(real NoV, real alpha) {
    Eye eye;
    const real sine = lane_sqrt((K(1.0) - NoV) * (K(1.0) + NoV));
    eye.po = NoV / (K(1.0) + sine);
    eye.rest = (sine + (K(1.0) - NoV)) / (K(1.0) + sine);
    eye.one_plus_po2 = lane_fma(eye.po, eye.po, lanes(K(1.0)));
    eye.alpha = alpha;
    eye.alpha2 = alpha * alpha;
    eye.one_minus_alpha2 = (K(1.0) - alpha) * (K(1.0) + alpha);
    eye.c = NoV / lane_sqrt(lane_fma(NoV, NoV, eye.alpha2 * (sine * sine)));
    return eye;
}

// x = scale (v⁻ᵐ − 1) runs over [0, length] as v = 1 + slope u does for u in [0, 1].
typedef struct {
    real scale, slope;
} Grading;

// length / scale of a piece without length is 0: its nodes coincide and weigh nothing. A scale
// beyond half the length would only lose digits.
KILN_FUNCTION Grading graded_eighth(real length, real width) {
    const real half_length = K(0.5) * length;
    Grading g;
    g.scale = lane_select(width < half_length, width, half_length);
    const real divisor = lane_select(g.scale > K(0.0), g.scale, lanes(K(1.0)));
    const real fourth = lane_sqrt(lane_sqrt(K(1.0) + length / divisor));
    g.slope = K(1.0) / lane_sqrt(fourth) - K(1.0);
    return g;
}

// One light: p and the products that follow from it.
typedef struct {
    real cosine, sine;  // of the light to the normal
    real jacobian;      // dNoL / dp
    real sum, one_plus_product;
    real M, N, R;  // sin²d + α²cos²d and cos²h + α²sin²h, h, d = (e ± e_o) / 2, in units of
                   // cos⁻²(e/2) cos⁻²(e_o/2); 1/√(M N)
    real sines;  // product of both sines, in the same units
    real unit;   // cos²(e/2) cos²(e_o/2)
} Ray;

// `gap` = p − po and `below` = 1 − p come apart from p: neither can be had from it at the peak.
KILN_FUNCTION Ray quadrature_ray(Eye eye, real p, real gap, real below) {
    const real cosine2 = K(1.0) / lane_fma(p, p, lanes(K(1.0)));
    const real above = below * (K(1.0) + p);
    Ray ray;
    ray.cosine = K(2.0) * p * cosine2;
    ray.sine = above * cosine2;
    ray.jacobian = K(2.0) * ray.sine * cosine2;
    ray.sum = p + eye.po;
    ray.one_plus_product = lane_fma(p, eye.po, lanes(K(1.0)));
    const real one_minus_product = lane_fma(p, eye.rest, below);
    const real peak = eye.alpha * ray.one_plus_product, edge = eye.alpha * ray.sum;
    ray.M = lane_fma(gap, gap, peak * peak);
    ray.N = lane_fma(one_minus_product, one_minus_product, edge * edge);
    ray.R = K(1.0) / lane_sqrt(ray.M * ray.N);
    ray.sines = above * (eye.rest * (K(1.0) + eye.po));
    ray.unit = cosine2 / eye.one_plus_po2;
    return ray;
}

// Mean of (y / (y − k))² over the azimuth.
KILN_FUNCTION real quadrature_circle(Eye eye, Ray ray) {
    const real first = eye.one_minus_alpha2 * (ray.sum * ray.one_plus_product) * ray.R;
    const real lower = ray.sum * ray.sum * ray.M;
    const real upper = ray.one_plus_product * ray.one_plus_product * ray.N;
    const real second = K(0.5) * eye.one_minus_alpha2 * (ray.R * ray.R * (lower + upper));
    return lane_fma(first, K(2.0) + second, lanes(K(1.0)));
}

// Azimuths in flight, see KILN_AHEAD in batch.h.
#undef KILN_AZIMUTHS
#ifdef KILN_GPU
#define KILN_AZIMUTHS 1
#else
#define KILN_AZIMUTHS 16
#endif

// Schlick's term is that of its weight of F90: the rest is linear in it.
KILN_FUNCTION real quadrature_fresnel(const int model, KILN_GLOBAL const scalar* p, real VoH) {
    if (model == KILN_FRESNEL_SCHLICK) return fresnel_schlick_weight(VoH);
    return fresnel(model, p, VoH);
}

// The same mean by the rule, under a Fresnel term and without one: what the one is off by, the
// other is off by nearly as well.
typedef struct {
    real fresnel, one;
} Circle;

KILN_FUNCTION Circle quadrature_circle_fresnel(const int model, KILN_GLOBAL const scalar* p,
                                               Ray ray, KILN_GLOBAL const scalar* nodes,
                                               const unsigned int count) {
    const real width = K(0.5) * (ray.sum * ray.M * ray.R / ray.one_plus_product);
    const real scale = lane_select(width > K(0.0), width, lanes(K(0.5)));
    const real slope = K(1.0) / lane_sqrt(lane_sqrt(K(1.0) + K(1.0) / scale)) - K(1.0);
    const real least = ray.sum * ray.sum, peak = least * (ray.M * ray.unit);
    const real spread = K(4.0) * ray.sines;
    real half_sine[KILN_AZIMUTHS], weight[KILN_AZIMUTHS], y[KILN_AZIMUTHS], ratio[KILN_AZIMUTHS];
    Circle sum = {lanes(K(0.0)), lanes(K(0.0))};
    for (unsigned int first = 0; first < count; first += KILN_AZIMUTHS) {
        const unsigned int left = count - first;
        const unsigned int here = left < KILN_AZIMUTHS ? left : KILN_AZIMUTHS;
        KILN_GLOBAL const scalar* node = nodes + 2 * first;
        for (unsigned int i = 0; i < here; ++i) {
            const real v = lane_fma(slope, lanes(node[2 * i]), lanes(K(1.0)));
            const real v2 = v * v, v4 = v2 * v2;
            const real n = lane_fma(-scale, v4, scale);
            const real H = K(1.0) / lane_fma(v4, v4, n * n);
            half_sine[i] = n * v4 * H;
            weight[i] = node[2 * i + 1] * (v2 * v * H);
        }
        for (unsigned int i = 0; i < here; ++i) {
            const real s = spread * (half_sine[i] * half_sine[i]);
            const real below = peak + s;
            y[i] = least + s;
            ratio[i] = y[i] / lane_select(below > K(0.0), below, lanes(K(1.0)));
        }
        for (unsigned int i = 0; i < here; ++i) {
            const real part = weight[i] * (ratio[i] * ratio[i]);
            sum.one += part;
            sum.fresnel = lane_fma(part, quadrature_fresnel(model, p, lane_root(y[i] * ray.unit)),
                                   sum.fresnel);
        }
    }
    // dq = −4 scale slope v⁻⁵ du; the mean is 2/π ∫ dχ over [0, π/2].
    const real step = K(-16.0) / KILN_PI * (scale * slope);
    sum.fresnel *= step;
    sum.one *= step;
    return sum;
}
