// SPDX-License-Identifier: Apache-2.0
// A surface of GGX microfacets that each reflect as Lambert, with what the facets throw at each
// other: light walks among them (Heitz, Hanika, d'Eon, Dachsbacher 2016, section 4) until it gets
// out. Its albedo is Σ ρ^k times the share that leaves after k facets.
//
// In τ = −ln C1(height) a ray that goes down meets 1 + Λ facets a unit, one that goes up Λ. Depths
// are integrated exactly: where a ray of 1 + Λ = b lands below a level is exponential in b, and so
// it stays for the light that a ray going up leaves behind on its way, while b / (b + Λ) reaches
// the level. What is sampled are the facets and the light that they send on, in cosines alone: an
// azimuth starts afresh at each facet. Nothing is chosen, so that a walk is smooth in its points:
// light goes on both up and down, and both meet the next facet, each with its weight.

#define KILN_WALK_FACETS 15
// Facets that a row of points serves; the next ones take another row of the batch each.
#define KILN_WALK_ROW_FACETS 5
// Scalars of a facet: u of its normal; √(1 − v sin² ψ) ∓ √v cos ψ, halved, of the light about it.
#define KILN_WALK_FACET_SCALARS 3
// And NoV of averages.
#define KILN_WALK_SCALARS (KILN_WALK_ROW_FACETS * KILN_WALK_FACET_SCALARS + 1)

// What is still inside after the last facet leaves as if every further one let go of this part: so
// it is summed to 1 at albedo 1, and to 1.5e-6 at any other and every roughness
// (tests/compute/test_models_simulated.cpp, AWalksEndIsBounded).
#define KILN_WALK_LEAVING K(0.34)

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

// π times the mean over azimuths φ of along + across cos φ where that is positive.
KILN_FUNCTION real walk_facing(real along, real across) {
    const real one = lanes(K(1.0)), toward = -along;
    const real x = toward / lane_max(across, lanes(KILN_ROOT_TINY));
    const real root2 = (across - along) * (across + along);
    return lane_fma(along, lane_acos(lane_max(lane_min(x, one), -one)),
                    lane_sqrt(lane_max(root2, lanes(K(0.0)))));
}

// A facet of the one inclination that all light inside meets next.
typedef struct {
    real upright, slant;  // cosine and sine of its normal's inclination
    real of_down, of_up;  // density of it for light that comes down, that comes up, over the drawn
} Facet;

// In the space that is stretched by 1 / α, normals that a view v of the whole sphere sees have the
// cosine ζ with the density 4 (ζ vz + √(1 − ζ²) vx cos φ)⁺ / (1 + vz), averaged over φ (Heitz 2018;
// light that comes up has −vz). Drawn is 1 − p + 2 p ζ, which is close to the sum over both: its p
// is 1 where all comes straight down and −0.7 for what comes along the surface or from below.
KILN_FUNCTION Facet walk_facet(View down, View up, real part_up, scalar u) {
    const real along = lanes(K(-0.7)), one = lanes(K(1.0));
    const real of_down = K(1.0) - K(1.7) * (down.vx * down.inverse_cap);
    const real p = lane_fma(part_up, along - of_down, of_down), rest = K(1.0) - p;
    const real density = lane_sqrt(lane_fma(rest, rest, p * (K(4.0) * u)));
    const real sum = rest + density, twice = lanes(K(2.0) * u);
    const real zeta = lane_min(twice / sum, one);
    const real sine = lane_sqrt((K(1.0) - zeta) * (K(1.0) + zeta));
    const real scale = (K(4.0) / KILN_PI) / density;
    // Of a ray straight up no normal is seen, nor is one met.
    const real below = lane_select(up.one_minus_vz > KILN_TINY, up.one_minus_vz, one);
    const real stretched = up.alpha * sine;
    const real length = lane_sqrt(lane_fma(zeta, zeta, stretched * stretched));
    Facet facet;
    facet.upright = zeta / length;
    facet.slant = stretched / length;
    facet.of_down = scale * down.inverse_cap * walk_facing(zeta * down.vz, sine * down.vx);
    facet.of_up = scale * walk_facing(-(zeta * up.vz), sine * up.vx) / below;
    return facet;
}

// Cosine of light that goes up from a facet of the inclination (h, slant), never 0, which divides;
// down with −h, near and far swapped. A cosine lobe is an even disc across the normal; seen from
// there the horizon is half an ellipse, −h √(1 − y²) on the line that is y off the middle. Above it
// is (1 + h) / 2 of each line: the point's place on the whole line is its place on that.
KILN_FUNCTION real walk_light(real h, real slant, scalar near, scalar far) {
    const real out2 =
        ((K(1.0) + h) * near) * lane_fma(K(1.0) - h, lanes(near), lanes(K(2.0) * far));
    const real toward = lane_fma(-h, lanes(near), lanes(far));
    const real z = lane_fma(h, lane_sqrt(out2), slant * toward);
    return lane_max(lane_min(z, lanes(K(1.0))), lanes(KILN_ROOT_TINY));
}

// Of a channel: Σ albedo^k times the share that leaves after k facets; albedo^k; and what light
// inside comes to, about, in units of that.
typedef struct {
    real albedo[3], power[3], worth[3];
} Walked;

KILN_FUNCTION Walked walk_begun(const int channels, KILN_GLOBAL const scalar* albedo, real alpha) {
    const real leaving = K(1.0) / (K(1.0) + alpha);  // about, after each facet
    Walked walked;
    for (int channel = 0; channel < 3; ++channel) {
        walked.albedo[channel] = lanes(K(0.0));
        walked.power[channel] = lanes(K(1.0));
        if (!(channels >> channel & 1)) continue;
        const real part = leaving * albedo[channel];
        walked.worth[channel] = part / (part + (K(1.0) - albedo[channel]));
    }
    return walked;
}

// A facet's weights make `excess` of the light that was there, 0 on average: it is taken back at
// its worth, which leaves little of the weights' noise, at albedo 1 none.
KILN_FUNCTION Walked walk_on(const int channels, KILN_GLOBAL const scalar* albedo, real excess,
                             real leaving, Walked walked) {
    KILN_ROLLED
    for (int channel = 0; channel < 3; ++channel) {
        if (!(channels >> channel & 1)) continue;
        walked.albedo[channel] = lane_fma(-(walked.power[channel] * walked.worth[channel]), excess,
                                          walked.albedo[channel]);
        walked.power[channel] = walked.power[channel] * albedo[channel];
        walked.albedo[channel] = lane_fma(walked.power[channel], leaving, walked.albedo[channel]);
    }
    return walked;
}

KILN_FUNCTION Walked walk_ended(const int channels, KILN_GLOBAL const scalar* albedo, real left,
                                Walked walked) {
    KILN_ROLLED
    for (int channel = 0; channel < 3; ++channel) {
        if (!(channels >> channel & 1)) continue;
        const scalar rest = KILN_WALK_LEAVING * albedo[channel] /
                            (K(1.0) - (K(1.0) - KILN_WALK_LEAVING) * albedo[channel]);
        walked.albedo[channel] =
            lane_fma(walked.power[channel] * rest, left, walked.albedo[channel]);
    }
    return walked;
}

// One walk from `view`, of the channels in a bit mask. A level is where light that went down was
// met: `at` holds the light there, c its 1 / 2 b = vz / (1 + vz), `from` the levels above, as light
// that comes back up through it finds them, in units of 1 / inverse. Level 0 is met from outside.
KILN_CALLED Walked ggx_lambert_walk(const int channels, KILN_GLOBAL const scalar* albedo, View view,
                                    KILN_GLOBAL const scalar* batch, unsigned int i,
                                    unsigned int first_point, unsigned int point_count) {
    const real none = lanes(K(0.0)), one = lanes(K(1.0));
    real at[KILN_WALK_FACETS + 1], c[KILN_WALK_FACETS + 1], inverse[KILN_WALK_FACETS + 1];
    real from[KILN_WALK_FACETS + 1][KILN_WALK_FACETS];
    real left = one, part_up = none;
    View down = view, up = view;
    Walked walked = walk_begun(channels, albedo, view.alpha);
    KILN_GLOBAL const scalar* row = batch;
    at[0] = one;
    c[0] = view.vz / (K(1.0) + view.vz);
    KILN_ROLLED
    for (int k = 0; k < KILN_WALK_FACETS; ++k) {
        if (k % KILN_WALK_ROW_FACETS == 0)
            row = batch + KILN_WALK_SCALARS * walk_row((unsigned int)(k / KILN_WALK_ROW_FACETS), i,
                                                       first_point, point_count);
        KILN_GLOBAL const scalar* point =
            row + KILN_WALK_FACET_SCALARS * (k % KILN_WALK_ROW_FACETS);
        const Facet facet = walk_facet(down, up, part_up, point[0]);
        up = ggx_view(walk_light(facet.upright, facet.slant, point[1], point[2]), view.alpha);
        down = ggx_view(walk_light(-facet.upright, facet.slant, point[2], point[1]), view.alpha);
        const real rising = K(0.5) + K(0.5) * facet.upright;
        const real before = left;
        real arriving[KILN_WALK_FACETS], through = none, inside = none;
        left = none;
        // Down: to a new level, which remembers where it came from.
        KILN_ROLLED
        for (int level = 0; level <= k; ++level) {
            at[level] = at[level] * (level < k ? facet.of_up : facet.of_down);
            left += at[level];
            from[k + 1][level] = at[level];
            arriving[level] = rising * at[level];
        }
        c[k + 1] = down.vz / (K(1.0) + down.vz);
        real divisor = lane_select(left > KILN_TINY, left, one);
        inverse[k + 1] = K(1.0) / divisor;
        at[k + 1] = (K(1.0) - rising) * left;
        // Up: through each level from where it is, or met on the way.
        KILN_ROLLED
        for (int level = k; level >= 0; --level) {
            const real hindered = up.one_minus_vz * c[level];
            const real share = arriving[level] / (up.vz + hindered);
            at[level] = share * hindered;
            inside += at[level];
            through = share * up.vz;
            if (level == 0) break;
            const real carried = through * inverse[level];
            KILN_ROLLED
            for (int above = 0; above < level; ++above)
                arriving[above] = lane_fma(carried, from[level][above], arriving[above]);
        }
        walked = walk_on(channels, albedo, left - before, through, walked);
        left = at[k + 1] + inside;
        divisor = lane_select(left > KILN_TINY, left, one);
        part_up = inside / divisor;
    }
    return walk_ended(channels, albedo, left, walked);
}
