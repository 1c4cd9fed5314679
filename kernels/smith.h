// SPDX-License-Identifier: Apache-2.0
// Smith masking and shadowing for GGX, after Heitz 2014 (eq. 72: Lambda; eq. 99: height-correlated
// G2), with S(NoX) = √(NoX² + α²(1 − NoX²)) = NoX (1 + 2 Lambda) in place of Lambda: no division by
// a cosine, no cancellation.
//
// Every ratio below is homogeneous in the light's pair (NoL, S(NoL)) and in the view's. So the
// view's pair comes divided by its own S, as c = NoV / S(NoV) beside 1, and the light's in any
// common scale: the sampler's half vector is not unit, and this saves its division.

// G2 / G1(V): the weight of a sample of the visible normals. NoL > 0.
KILN_FUNCTION real smith_G2_over_G1(const int masking, real c, real NoL, real S) {
    if (masking == KILN_MASKING_SMITH_SEPARABLE) return K(2.0) * NoL / (NoL + S);
    return NoL * (K(1.0) + c) / lane_fma(c, S, NoL);
}

// 1 − G2 / G1(V), with `excess` = S² − NoL² in place of the subtraction that would lose all digits
// as α → 0.
KILN_FUNCTION real smith_deficit(const int masking, real c, real NoL, real S, real excess) {
    const real sum = S + NoL;
    if (masking == KILN_MASKING_SMITH_SEPARABLE) return excess / (sum * sum);
    return c * excess / (sum * lane_fma(c, S, NoL));
}
