// SPDX-License-Identifier: Apache-2.0
// The directional albedo of a measured material: a rule about the mirror direction whose rings end
// at the horizon, so that the integrand is as smooth as the table.

// Of a point: v in (0, 1) along a spoke, cosine and sine of the spoke's azimuth, the weight.
#define KILN_ALBEDO_SCALARS 4

typedef struct {
    real albedo[3];     // of max(0, f)
    real extrapolated;  // the part of G that lies beyond the measurement
} MeasuredAlbedo;

// The point's direction about the mirror direction: sin(theta_d / 2) = u², u = v times its value at
// the horizon; d omega = 8 u³ du dphi.
KILN_FUNCTION real measured_albedo_point(MeasuredPair* at, KILN_GLOBAL const scalar* point) {
    const scalar v = point[0], cosine = point[1], sine = point[2];
    const real up = at->sine * cosine;
    const real size = lane_sqrt(lane_fma(at->cosine, at->cosine, up * up));
    const real horizon = up / lane_select(size > K(0.0), size, lanes(K(1.0)));
    const real end = lane_sqrt(lane_sqrt(lane_saturate(K(0.5) - K(0.5) * horizon)));
    const real u = end * v, rho = u * u;
    const real s = K(2.0) * rho * lane_sqrt((K(1.0) - rho) * (K(1.0) + rho));
    const real dx = s * cosine, dz = K(1.0) - K(2.0) * (rho * rho);
    at->x = -(at->cosine * dx) - at->sine * dz;
    at->y = -(s * sine);
    at->z = lane_max(at->cosine * dz - at->sine * dx, lanes(K(0.0)));
    return (K(8.0) * point[3]) * (rho * u) * end * at->z;
}

KILN_FUNCTION MeasuredAlbedo measured_albedo(Measured m, real theta, real cosine, real sine,
                                             KILN_GLOBAL const scalar* points, unsigned int count) {
    const real zero = lanes(K(0.0));
    MeasuredAlbedo sum = {{zero, zero, zero}, zero};
    MeasuredPair at = {theta, cosine, sine, zero, zero, zero};
    for (unsigned int i = 0; i < count; ++i) {
        const real weight = measured_albedo_point(&at, points + KILN_ALBEDO_SCALARS * i);
        const MeasuredValue value = measured_value(m, at);
        for (int k = 0; k < 3; ++k)
            sum.albedo[k] = lane_fma(weight, lane_max(value.f[k], zero), sum.albedo[k]);
        const real guessed =
            lane_select(value.origin > K(1.5), weight * lane_max(value.f[1], zero), zero);
        sum.extrapolated += guessed;
    }
    return sum;
}
