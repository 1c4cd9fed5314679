// SPDX-License-Identifier: Apache-2.0
// A surface of GGX microfacets that each reflect as Lambert, with what the facets throw at each
// other: light walks among them (Heitz, Hanika, d'Eon, Dachsbacher 2016, section 4) until it gets
// out. Its albedo is Σ ρ^k times the share that leaves after k facets.
//
// In τ = −ln C1(height) a ray that goes down meets 1 + Λ facets a unit, one that goes up Λ. Depths
// are integrated exactly: where a ray of 1 + Λ = b lands below a level is exponential in b, and so
// it stays for the light that a ray going up leaves behind on its way, while b / (b + Λ) reaches
// the level. What is sampled are the facets and the light that they send on, in cosines alone: an
// azimuth starts afresh at each facet.

#define KILN_WALK_FACETS 15
// Facets that a row of points serves; the next ones take another row of the batch each.
#define KILN_WALK_ROW_FACETS 3
// Scalars of a facet: cos φ, 1 − u, u of the visible normal; √v cos ψ, √(1 − v) of the light about
// it.
#define KILN_WALK_FACET_SCALARS 5
// And NoV of averages.
#define KILN_WALK_SCALARS (KILN_WALK_ROW_FACETS * KILN_WALK_FACET_SCALARS + 1)

// What is still inside after the last facet leaves as if every further one let go of this part: so
// it is summed to 1 at albedo 1, and to 1.5e-6 at any other and every roughness
// (tests/compute/test_models_simulated.cpp, AWalksEndIsBounded).
#define KILN_WALK_LEAVING K(0.34)

typedef struct {
    real albedo[3];
} Walked;

// Row of the points that turn `turn` of point i takes: a permutation of the batch for every turn
// and batch (Owen 1998, Latin supercube sampling), turn 0 its own.
KILN_FUNCTION unsigned int walk_row(unsigned int turn, unsigned int i, unsigned int first_point,
                                    unsigned int point_count) {
    if (turn == 0) return i;
    unsigned int mask = point_count - 1;
    for (unsigned int shift = 1; shift < 32; shift *= 2) mask |= mask >> shift;
    unsigned int key = (first_point + 1) * 0x9E3779B1u + turn * 0x85EBCA77u;
    unsigned int keys[3];
    for (int round = 0; round < 3; ++round) {
        key = (key ^ (key >> 15)) * 0x2C1B3C6Du;
        keys[round] = key ^ (key >> 12);
    }
    unsigned int row = i;
    // Each step is one to one on [0, mask]; what falls outside the batch goes round again.
    do {
        for (int round = 0; round < 3; ++round) {
            row = (row * (keys[round] | 1u) + (keys[round] >> 16)) & mask;
            row ^= row >> 4;
        }
    } while (row >= point_count);
    return row;
}

// The cosine of light from a facet that is seen along `view`, from below its horizon where `up`
// says so (the ray came up): visible normals by spherical caps as in ggx_sample_vndf(), which hold
// for views of the whole sphere, then a cosine lobe about the normal.
KILN_FUNCTION real walk_facet(View view, real seen, KILN_GLOBAL const scalar* point) {
    const scalar cos_phi = point[0], one_minus_u = point[1], u = point[2];
    const real above = K(1.0) + view.vz;
    const real cap = lane_select(seen > K(0.0), above, view.one_minus_vz);
    const real rest = lane_select(seen > K(0.0), view.one_minus_vz, above);
    const real hz = one_minus_u * cap;
    const real sin2 = u * cap * lane_fma(lanes(one_minus_u), cap, rest);
    const real hx = lane_fma(lanes(cos_phi), lane_sqrt(sin2), view.vx);
    const real hxy2 = lane_fma(hx, hx, ((K(1.0) - cos_phi) * (K(1.0) + cos_phi)) * sin2);
    const real slope2 = view.alpha * view.alpha * hxy2;
    const real length = lane_sqrt(lane_fma(hz, hz, slope2));
    // Of a ray straight up no normal is seen, nor is one met.
    const real divisor = lane_select(length > K(0.0), length, lanes(K(1.0)));
    const real inverse = K(1.0) / divisor;
    const real upright = lane_select(length > K(0.0), hz * inverse, lanes(K(1.0)));
    return lane_fma(upright, lanes(point[4]), (lane_sqrt(slope2) * inverse) * point[3]);
}

// One walk from `view`: for each of the channels (a bit mask) Σ albedo^k times the share that
// leaves after k facets. A level is where a ray that went down was met: `at` holds the light there,
// c its 1 / 2 b = vz / (1 + vz), `from` the levels above, as light that comes back up through it
// finds them, in units of 1 / inverse. Level 0 is met from outside.
KILN_CALLED Walked ggx_lambert_walk(const int channels, KILN_GLOBAL const scalar* albedo, View view,
                                    KILN_GLOBAL const scalar* batch, unsigned int i,
                                    unsigned int first_point, unsigned int point_count) {
    const real none = lanes(K(0.0)), one = lanes(K(1.0));
    real at[KILN_WALK_FACETS + 1], c[KILN_WALK_FACETS + 1], inverse[KILN_WALK_FACETS + 1];
    real from[KILN_WALK_FACETS + 1][KILN_WALK_FACETS];
    real power[3] = {one, one, one}, left = one, seen = view.vz;
    Walked walked = {{none, none, none}};
    KILN_GLOBAL const scalar* point = batch;
    at[0] = one;
    c[0] = view.vz / (K(1.0) + view.vz);
    KILN_ROLLED
    for (int k = 0; k < KILN_WALK_FACETS; ++k) {
        if (k % KILN_WALK_ROW_FACETS == 0)
            point = batch + KILN_WALK_SCALARS * walk_row((unsigned int)(k / KILN_WALK_ROW_FACETS),
                                                         i, first_point, point_count);
        const real z =
            walk_facet(view, seen, point + KILN_WALK_FACET_SCALARS * (k % KILN_WALK_ROW_FACETS));
        view = ggx_view(lane_min(lane_abs(z), one), view.alpha);
        seen = -z;
        // Up: through each level from where it is, or met on the way.
        const real away = lane_select(z > K(0.0), view.vz, one);
        real arriving[KILN_WALK_FACETS], met[KILN_WALK_FACETS], through = none, inside = none;
        KILN_ROLLED
        for (int level = 0; level <= k; ++level) arriving[level] = at[level];
        KILN_ROLLED
        for (int level = k; level >= 0; --level) {
            const real hindered = view.one_minus_vz * c[level];
            const real share = arriving[level] / (away + hindered);
            met[level] = share * hindered;
            inside += met[level];
            through = share * away;
            if (level == 0) break;
            const real carried = through * inverse[level];
            KILN_ROLLED
            for (int above = 0; above < level; ++above)
                arriving[above] = lane_fma(carried, from[level][above], arriving[above]);
        }
        // Down: to a new level, which remembers where it came from.
        KILN_ROLLED
        for (int level = 0; level <= k; ++level) {
            from[k + 1][level] = at[level];
            at[level] = lane_select(z > K(0.0), met[level], none);
        }
        c[k + 1] = view.vz / (K(1.0) + view.vz);
        const real divisor = lane_select(left > KILN_TINY, left, one);
        inverse[k + 1] = K(1.0) / divisor;
        at[k + 1] = lane_select(z > K(0.0), none, left);
        left = lane_select(z > K(0.0), inside, left);
        const real leaving = lane_select(z > K(0.0), through, none);
        KILN_ROLLED
        for (int channel = 0; channel < 3; ++channel) {
            if (!(channels >> channel & 1)) continue;
            power[channel] = power[channel] * albedo[channel];
            walked.albedo[channel] = lane_fma(power[channel], leaving, walked.albedo[channel]);
        }
    }
    KILN_ROLLED
    for (int channel = 0; channel < 3; ++channel) {
        const scalar rest = KILN_WALK_LEAVING * albedo[channel] /
                            (K(1.0) - (K(1.0) - KILN_WALK_LEAVING) * albedo[channel]);
        walked.albedo[channel] = lane_fma(power[channel] * rest, left, walked.albedo[channel]);
    }
    return walked;
}
