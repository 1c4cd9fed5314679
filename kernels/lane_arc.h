// SPDX-License-Identifier: Apache-2.0
// The rarer elementary functions: the tail of Beckmann's masking, and the arcs. As lane_math.h.

// 1 − √π a erfcx(a) for a ≥ 0, without the subtraction, which would lose all digits of it as
// a → ∞, where it is 1 / (2 a²). It is what Beckmann's masking needs (Heitz 2014, table 1):
//   Λ(a) = (erf a − 1) / 2 + exp(−a²) / (2 a √π) = exp(−a²) (1 − √π a erfcx a) / (2 √π a).
// Past a = 10 (27) the exponential is 0, and the value at 10 (27) is returned.
KILN_CALLED real lane_erfcx_deficit(real a) {
#if KILN_DOUBLE
    const real end = lanes(K(27.0));
#else
    const real end = lanes(K(10.0));
#endif
    const real x = lane_min(a, end);
    const real y = (x - K(3.0)) / (x + K(3.0));
    // (1 + √π a + 2 a²) times the function: between 1 and 1.19, to 7e-18 relative in double, 2e-9
    // in float.
#if KILN_DOUBLE
    real p = lanes(K(5.561360576703435123e-9));
    p = lane_fma(p, y, lanes(K(2.9348728147038391096e-9)));
    p = lane_fma(p, y, lanes(K(-7.6726707759705241214e-8)));
    p = lane_fma(p, y, lanes(K(-1.1020795331419509521e-7)));
    p = lane_fma(p, y, lanes(K(3.9059092480817833695e-7)));
    p = lane_fma(p, y, lanes(K(9.3824385443696805652e-7)));
    p = lane_fma(p, y, lanes(K(-1.1789212702275884436e-6)));
    p = lane_fma(p, y, lanes(K(-5.2847580745678438482e-6)));
    p = lane_fma(p, y, lanes(K(2.1206246777839603033e-6)));
    p = lane_fma(p, y, lanes(K(0.000026012535551097773977)));
    p = lane_fma(p, y, lanes(K(1.9474404765984698523e-7)));
    p = lane_fma(p, y, lanes(K(-0.00012791056826281646632)));
    p = lane_fma(p, y, lanes(K(-7.9048152210629420592e-6)));
    p = lane_fma(p, y, lanes(K(0.00066769492536220694373)));
    p = lane_fma(p, y, lanes(K(-0.00024027296980985825358)));
    p = lane_fma(p, y, lanes(K(-0.0035319189084029243973)));
    p = lane_fma(p, y, lanes(K(0.0053070335574209340172)));
    p = lane_fma(p, y, lanes(K(0.012511984170904361097)));
    p = lane_fma(p, y, lanes(K(-0.059490962432557514799)));
    p = lane_fma(p, y, lanes(K(0.10005372759742928689)));
    p = lane_fma(p, y, lanes(K(-0.058855934747546309342)));
    p = lane_fma(p, y, lanes(K(-0.091399755580453895642)));
    p = lane_fma(p, y, lanes(K(0.23926844711063765737)));
    p = lane_fma(p, y, lanes(K(-0.18995567482392881096)));
    p = lane_fma(p, y, lanes(K(-0.125981861613225601)));
    p = lane_fma(p, y, lanes(K(1.1717602944018332046)));
#else
    real p = lanes(K(0.0001452555219));
    p = lane_fma(p, y, lanes(K(-0.0007938405825)));
    p = lane_fma(p, y, lanes(K(-0.003370468077)));
    p = lane_fma(p, y, lanes(K(0.005740865746)));
    p = lane_fma(p, y, lanes(K(0.01257039669)));
    p = lane_fma(p, y, lanes(K(-0.05961688058)));
    p = lane_fma(p, y, lanes(K(0.1000221891)));
    p = lane_fma(p, y, lanes(K(-0.0588393845)));
    p = lane_fma(p, y, lanes(K(-0.09139539117)));
    p = lane_fma(p, y, lanes(K(0.239267497)));
    p = lane_fma(p, y, lanes(K(-0.1899558639)));
    p = lane_fma(p, y, lanes(K(-0.1259818446)));
    p = lane_fma(p, y, lanes(K(1.171760296)));
#endif
    const real slope = lane_fma(lanes(K(2.0)), x, lanes(K(1.7724538509055161)));
    return p / lane_fma(x, slope, lanes(K(1.0)));
}

// asin x up to 1/2, beyond that asin √((1 − |x|) / 2), half the arc from the nearer end of [−1, 1].
KILN_FUNCTION real lane_short_arc(real x) {
    const real size = lane_abs(x);
    const real end = K(0.5) * (K(1.0) - size);
    const real z = lane_select(size > K(0.5), end, x * x);
    const real s = lane_select(size > K(0.5), lane_sqrt(end), x);
    // (asin s − s) / s³, to 4e-18 of asin s in double, 1e-9 in float.
#if KILN_DOUBLE
    real p = lanes(K(0.028998874125483221258));
    p = lane_fma(p, z, lanes(K(-0.015212438127253424149)));
    p = lane_fma(p, z, lanes(K(0.01763678851638331652)));
    p = lane_fma(p, z, lanes(K(0.0053688622487906597873)));
    p = lane_fma(p, z, lanes(K(0.010343929955748741731)));
    p = lane_fma(p, z, lanes(K(0.011475856595829428644)));
    p = lane_fma(p, z, lanes(K(0.013971561192651323835)));
    p = lane_fma(p, z, lanes(K(0.017352368698808222225)));
    p = lane_fma(p, z, lanes(K(0.022372173991937085912)));
    p = lane_fma(p, z, lanes(K(0.030381944111486254985)));
    p = lane_fma(p, z, lanes(K(0.044642857146715024885)));
    p = lane_fma(p, z, lanes(K(0.074999999999982459068)));
    p = lane_fma(p, z, lanes(K(0.16666666666666667987)));
#else
    real p = lanes(K(0.03392064941));
    p = lane_fma(p, z, lanes(K(0.01700648039)));
    p = lane_fma(p, z, lanes(K(0.03113165014)));
    p = lane_fma(p, z, lanes(K(0.04459666293)));
    p = lane_fma(p, z, lanes(K(0.07500102982)));
    p = lane_fma(p, z, lanes(K(0.166666663)));
#endif
    return lane_fma(s * z, p, s);
}

// π/2 in two parts.
KILN_FUNCTION RealPair lane_half_pi(void) {
#if KILN_DOUBLE
    const RealPair half_pi = {lanes(K(1.5707963267948966)), lanes(K(6.123233995736766e-17))};
#else
    const RealPair half_pi = {lanes(K(1.57079637)), lanes(K(-4.371139e-8))};
#endif
    return half_pi;
}

// Arc cosine on [−1, 1], radians: from its value at 0, at −1 and at 1.
KILN_CALLED real lane_acos(real x) {
    const RealPair half_pi = lane_half_pi();
    const real size = lane_abs(x), zero = lanes(K(0.0));
    const real far_origin = lane_select(x < zero, K(2.0) * half_pi.hi, zero);
    const real far_rest = lane_select(x < zero, K(2.0) * half_pi.lo, zero);
    const real far_slope = lane_select(x < zero, lanes(K(-2.0)), lanes(K(2.0)));
    const real origin = lane_select(size > K(0.5), far_origin, half_pi.hi);
    const real rest = lane_select(size > K(0.5), far_rest, half_pi.lo);
    const real slope = lane_select(size > K(0.5), far_slope, lanes(K(-1.0)));
    return origin + lane_fma(slope, lane_short_arc(x), rest);
}

// Arc sine on [0, 1], radians.
KILN_CALLED real lane_asin(real x) {
    const RealPair half_pi = lane_half_pi();
    const real arc = lane_short_arc(x);
    return lane_select(x > K(0.5), half_pi.hi + lane_fma(lanes(K(-2.0)), arc, half_pi.lo), arc);
}
