// SPDX-License-Identifier: Apache-2.0
// An anisotropic measurement as seen under one azimuth of the light, or under all.
#include "server/measured/azimuths.h"

#include <algorithm>
#include <cmath>

#include "server/base/error.h"
#include "server/measured/hemisphere.h"
#include "server/measured/reader.h"

namespace kiln::measured {
namespace {

constexpr double kSame = 1e-3;  // degrees
/// Cosine of the view below which half vectors of neighbours soon have none above the horizon.
constexpr double kGrazing = 0.1;

/// A direction of light that the file or its symmetry knows.
struct Azimuth {
    double phi = 0;          ///< degrees, in [0, 360)
    std::size_t source = 0;  ///< the hemisphere that holds it
    bool mirrored = false;
    double turn = 0;  ///< of views under light along the normal, degrees
};
struct Tap {
    std::size_t azimuth = 0;
    double weight = 0;
};

/// About the normal, degrees.
Vec turned(Vec v, double degrees) {
    if (degrees == 0) return v;
    const double c = std::cos(degrees * kDegree), s = std::sin(degrees * kDegree);
    return {c * v.x - s * v.y, s * v.x + c * v.y, v.z};
}

/// All azimuths of one theta_in.
class Ring {
  public:
    /// Light along the normal is turned to phi_in, or to azimuths all around.
    Ring(std::vector<const Incidence*> incidences, TurnSymmetry symmetry, std::size_t channels,
         PhiIn phi_in)
        : incidences_(std::move(incidences)), channels_(channels) {
        std::vector<double> coverage;
        for (const Incidence* one : incidences_) {
            hemispheres_.emplace_back(*one, channels);
            coverage.push_back(hemispheres_.back().has_area() ? hemispheres_.back().coverage() : 0);
        }
        const double most = *std::max_element(coverage.begin(), coverage.end());
        for (std::size_t n = 0; n < incidences_.size(); ++n) {
            // An in-plane scan beside whole hemispheres would leave them only what it covers.
            if (coverage[n] <= 0 || coverage[n] < 0.5 * most) continue;
            ++measured_;
            const double phi = wrapped_degrees(incidences_[n]->phi_i);
            add(phi, n, false);
            if (theta_i() >= kSame) add_images(phi, n, symmetry);
        }
        if (theta_i() < kSame && !azimuths_.empty()) turn_around(phi_in);
        std::sort(azimuths_.begin(), azimuths_.end(),
                  [](const Azimuth& a, const Azimuth& b) { return a.phi < b.phi; });
        hints_.assign(azimuths_.size(), Triangulation::kNone);
    }

    double theta_i() const { return incidences_.front()->theta_i; }
    std::size_t count() const { return azimuths_.size(); }
    std::size_t measured() const { return measured_; }
    double phi(std::size_t n) const { return azimuths_[n].phi; }
    const Incidence& source_of(std::size_t azimuth) const {
        return *incidences_[azimuths_[azimuth].source];
    }
    /// A view of the source in the frame of the azimuth.
    Vec from_source(std::size_t azimuth, Vec out) const {
        if (azimuths_[azimuth].mirrored) out.y = -out.y;
        return turned(out, -azimuths_[azimuth].turn);
    }

    /// f for light at an azimuth and a view in the frame in which it stands at 0.
    bool value(std::size_t azimuth, Vec out, double* values, Origin& origin) {
        const Azimuth& at = azimuths_[azimuth];
        out = turned(out, at.turn);
        if (at.mirrored) out.y = -out.y;
        return hemispheres_[at.source].value(out, hints_[azimuth], values, origin);
    }

    /// Of light at phi, by azimuths without those of index `without`; empty where the gap that phi
    /// lies in is too wide.
    std::vector<Tap> taps_at(double phi, std::size_t without) const;
    /// Weights of all azimuths, by the arcs that they stand for.
    std::vector<Tap> all() const;
    /// The sum of taps for a view in the frame of phi; false where one of them has no value.
    bool mixed(const std::vector<Tap>& taps, double phi, bool at_halves, Vec out, double* values,
               Origin& origin);

  private:
    void add(double phi, std::size_t source, bool mirrored) {
        for (const Azimuth& one : azimuths_)
            if (std::abs(std::remainder(one.phi - phi, 360.0)) < kSame) return;
        azimuths_.push_back({phi, source, mirrored, 0});
    }
    void turn_around(PhiIn phi_in) {
        const Azimuth known = azimuths_[0];
        azimuths_.clear();
        constexpr int kTurns = 24;
        for (int k = 0; k < (phi_in ? 1 : kTurns); ++k) {
            Azimuth one = known;
            one.turn = phi_in ? *phi_in - known.phi : 360.0 * k / kTurns;
            one.phi = wrapped_degrees(known.phi + one.turn);
            azimuths_.push_back(one);
        }
    }
    void add_images(double phi, std::size_t source, TurnSymmetry symmetry) {
        if (symmetry == TurnSymmetry::none) return;
        add(wrapped_degrees(phi + 180), source, false);
        if (symmetry != TurnSymmetry::two_planes) return;
        add(wrapped_degrees(-phi), source, true);
        add(wrapped_degrees(180 - phi), source, true);
    }

    std::vector<const Incidence*> incidences_;
    std::size_t channels_, measured_ = 0;
    std::vector<Hemisphere> hemispheres_;
    std::vector<Azimuth> azimuths_;
    std::vector<std::uint32_t> hints_;
};

std::vector<Tap> Ring::taps_at(double phi, std::size_t without) const {
    std::vector<std::size_t> order;  // by how far each lies past phi
    for (std::size_t n = 0; n < azimuths_.size(); ++n)
        if (n != without) order.push_back(n);
    if (order.empty()) return {};
    const auto past = [&](std::size_t n) {
        return wrapped_degrees(azimuths_[n].phi - phi + kSame);
    };
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return past(a) < past(b); });
    if (past(order[0]) < 2 * kSame) return {{order[0], 1}};
    const std::size_t count = order.size();
    // Places of the two before and the two after, in degrees from phi.
    const std::array<std::size_t, 4> index = {order[(2 * count - 2) % count], order[count - 1],
                                              order[0], order[1 % count]};
    std::array<double, 4> x{};
    for (std::size_t k = 0; k < 4; ++k) x[k] = past(index[k]) - kSame - (k < 2 ? 360.0 : 0.0);
    if (x[2] - x[1] > kAzimuthGapMax + kSame) return {};
    const bool cubic = count >= 4 && x[1] - x[0] <= kAzimuthGapMax + kSame &&
                       x[3] - x[2] <= kAzimuthGapMax + kSame;
    std::vector<Tap> taps;
    for (std::size_t k = cubic ? 0 : 1; k < (cubic ? 4u : 3u); ++k) {
        double weight = 1;  // Lagrange's, at 0
        for (std::size_t m = cubic ? 0 : 1; m < (cubic ? 4u : 3u); ++m)
            if (m != k) weight *= -x[m] / (x[k] - x[m]);
        taps.push_back({index[k], weight});
    }
    return taps;
}

std::vector<Tap> Ring::all() const {
    std::vector<Tap> taps;
    double sum = 0;
    for (std::size_t n = 0; n < count(); ++n) {
        const double before = wrapped_degrees(phi(n) - phi((n + count() - 1) % count()));
        const double after = wrapped_degrees(phi((n + 1) % count()) - phi(n));
        taps.push_back({n, std::min(before, kAzimuthGapMax) + std::min(after, kAzimuthGapMax)});
        sum += taps.back().weight;
    }
    if (count() == 1) return {{0, 1}};
    for (Tap& tap : taps) tap.weight /= sum;
    return taps;
}

bool Ring::mixed(const std::vector<Tap>& taps, double phi, bool at_halves, Vec out, double* values,
                 Origin& origin) {
    std::vector<double> one(channels_);
    if (at_halves && taps.size() > 1 && out.z >= kGrazing) {
        // f cos(theta_o) at one half vector of the surface: normals then count alike in all.
        const Vec in = direction(theta_i(), 0);
        const Vec sum = in + out;
        const Vec half = (1 / std::sqrt(dot(sum, sum))) * sum;
        std::fill(values, values + channels_, 0.0);
        origin = Origin::kMeasured;
        bool whole = true;
        for (const Tap& tap : taps) {
            const Vec h = turned(half, phi - azimuths_[tap.azimuth].phi);
            const Vec view = 2 * dot(in, h) * h - in;
            Origin from{};
            whole = whole && view.z >= kGrazing && value(tap.azimuth, view, one.data(), from);
            if (!whole) break;
            origin = std::max(origin, from);
            for (std::size_t k = 0; k < channels_; ++k)
                values[k] += tap.weight * view.z / out.z * one[k];
        }
        if (whole) return true;
    }
    std::fill(values, values + channels_, 0.0);
    origin = Origin::kMeasured;
    for (const Tap& tap : taps) {
        Origin from{};
        if (!value(tap.azimuth, out, one.data(), from)) return false;
        origin = std::max(origin, from);
        for (std::size_t k = 0; k < channels_; ++k) values[k] += tap.weight * one[k];
    }
    return true;
}

/// Views even in projected solid angle: the golden spiral on the disk.
std::vector<Vec> views() {
    constexpr int kViews = 600;
    std::vector<Vec> list;
    for (int v = 0; v < kViews; ++v) {
        const double r2 = (v + 0.5) / kViews, turn = 360 * 0.6180339887498949 * v;
        list.push_back(direction(std::asin(std::sqrt(r2)) / kDegree, turn));
    }
    return list;
}

constexpr std::size_t kNoOne = static_cast<std::size_t>(-1);

struct Sums {
    double off = 0, all = 0;
    /// Of one azimuth of some, so that each theta_in counts alike.
    void add(const Sums& one, std::size_t some) {
        off += one.off / static_cast<double>(some);
        all += one.all / static_cast<double>(some);
    }
    double relative() const { return all > 0 ? off / all : 0; }
};

/// How far two sums of azimuths are from each other in the frame of phi.
Sums compared(Ring& ring, const std::vector<Tap>& first, const std::vector<Tap>& second, double phi,
              bool at_halves, std::size_t channels) {
    std::vector<double> a(channels), b(channels);
    Sums sums;
    for (const Vec& out : views()) {
        Origin from{}, other{};
        if (!ring.mixed(first, phi, at_halves, out, a.data(), from) ||
            !ring.mixed(second, phi, at_halves, out, b.data(), other) ||
            std::max(from, other) != Origin::kMeasured)
            continue;
        double x = 0, y = 0;
        for (std::size_t k = 0; k < channels; ++k) x += a[k], y += b[k];
        sums.off += std::abs(x - y);
        sums.all += std::abs(x);
    }
    return sums;
}

/// What becomes of a file, in two ways: about the mirror direction, and at half vectors.
struct Made {
    std::array<std::vector<Incidence>, 2> lobes;
    std::array<Sums, 2> left_out;  ///< azimuths predicted from those beside them
    std::array<Sums, 2> spread;
    Sums halves;          ///< the mean of all azimuths and of every other one
    double openness = 0;  ///< largest share of left_out that phi_in has
};

/// Some azimuths of a ring that stand for all of them.
std::vector<std::size_t> looked_at(const Ring& ring) {
    constexpr std::size_t kMost = 8;
    std::vector<std::size_t> list;
    for (std::size_t n = 0; n < ring.count(); n += (ring.count() + kMost - 1) / kMost)
        list.push_back(n);
    return list;
}

/// Of a gap's middle 1, at its ends 0: how far an interpolation is off between two azimuths.
double openness(const Ring& ring, const std::vector<Tap>& taps, double phi) {
    if (taps.size() == 1) return 0;
    double before = 360, after = 360;
    for (const Tap& tap : taps) {
        before = std::min(before, wrapped_degrees(phi - ring.phi(tap.azimuth)));
        after = std::min(after, wrapped_degrees(ring.phi(tap.azimuth) - phi));
    }
    return 4 * before * after / ((before + after) * (before + after));
}

/// Points lie where the azimuth that counts most has them; of a mean, the one of most points.
Incidence lobe_of(Ring& ring, const std::vector<Tap>& taps, PhiIn phi_in, bool at_halves,
                  std::size_t channels) {
    const auto points = [&](const Tap& tap) { return ring.source_of(tap.azimuth).out.size(); };
    const auto less = [&](const Tap& a, const Tap& b) {
        return phi_in ? a.weight < b.weight : points(a) < points(b);
    };
    const std::size_t base = std::max_element(taps.begin(), taps.end(), less)->azimuth;
    const Incidence& source = ring.source_of(base);
    Incidence made;
    made.theta_i = source.theta_i;
    made.phi_i = phi_in.value_or(0);
    std::vector<double> values(channels);
    // A hostile file has one azimuth of millions of points and a thousand others.
    constexpr std::size_t kLookUpsMost = std::size_t{1} << 25;
    const std::size_t step = source.out.size() * taps.size() / kLookUpsMost + 1;
    for (std::size_t n = 0; n < source.out.size(); n += step) {
        const Vec out = ring.from_source(base, source.out[n]);
        Origin origin{};
        const bool found = ring.mixed(taps, made.phi_i, at_halves, out, values.data(), origin);
        made.out.push_back(out);
        made.state.push_back(found && origin == Origin::kMeasured ? PointState::kMeasured
                                                                  : PointState::kNotMeasured);
        for (const double value : values)
            made.values.push_back(static_cast<float>(found ? value : 0.0));
    }
    return made;
}

void add_mean(Ring& ring, std::size_t channels, Made& made) {
    const std::vector<Tap> taps = ring.all();
    made.lobes[0].push_back(lobe_of(ring, taps, {}, false, channels));
    const std::vector<std::size_t> some = looked_at(ring);
    for (const std::size_t n : some)
        made.spread[0].add(compared(ring, {{n, 1}}, taps, 0, false, channels), some.size());
    if (ring.count() < 4 || ring.count() % 2 != 0) return;
    std::vector<Tap> every_other;
    for (std::size_t n = 0; n < taps.size(); n += 2)
        every_other.push_back({n, 2.0 / static_cast<double>(taps.size())});
    made.halves.add(compared(ring, taps, every_other, 0, false, channels), 1);
}

/// False where phi_in is between no azimuths.
bool add_at(Ring& ring, double phi_in, std::size_t channels, Made& made) {
    const std::vector<Tap> taps = ring.taps_at(phi_in, kNoOne);
    if (taps.empty()) return false;
    made.openness = std::max(made.openness, openness(ring, taps, phi_in));
    for (const bool at_halves : {false, true}) {
        made.lobes[at_halves].push_back(lobe_of(ring, taps, phi_in, at_halves, channels));
        const std::vector<std::size_t> some = looked_at(ring);
        for (const std::size_t n : some) {
            made.spread[at_halves].add(compared(ring, {{n, 1}}, taps, phi_in, at_halves, channels),
                                       some.size());
            if (ring.measured() < 2) continue;  // one that was turned knows nothing of others
            const std::vector<Tap> others = ring.taps_at(ring.phi(n), n);
            if (!others.empty())
                made.left_out[at_halves].add(
                    compared(ring, {{n, 1}}, others, ring.phi(n), at_halves, channels),
                    some.size());
        }
    }
    return true;
}

/// A trapezoid rule over a turn that doubles its azimuths squares its error, if it had halved it at
/// all; a cubic at half the step has a quarter, as found of anisotropic GGX.
double predicted(const Made& made, PhiIn phi_in, bool at_halves) {
    const double half = made.halves.relative(), spread = made.spread[0].relative();
    if (!phi_in) return spread > 0 ? std::min(half * half / spread, half / 4) : 0;
    return made.openness * made.left_out[at_halves].relative() / 4;
}

std::string degrees_words(const std::vector<const Incidence*>& incidences) {
    constexpr std::size_t kMost = 8;
    std::string words;
    for (std::size_t n = 0; n < std::min(incidences.size(), kMost); ++n)
        words += (n > 0 ? ", " : "") + in_words(incidences[n]->phi_i);
    return words + (incidences.size() > kMost ? ", ..." : "");
}

}  // namespace

std::vector<Incidence> at_azimuth(const std::vector<Incidence>& incidences, TurnSymmetry symmetry,
                                  std::size_t channels, PhiIn phi_in, AzimuthAccount& account) {
    std::vector<std::vector<const Incidence*>> groups;
    for (const Incidence& one : incidences) {
        if (groups.empty() || groups.back().front()->theta_i != one.theta_i) groups.emplace_back();
        groups.back().push_back(&one);
        account.measured = std::max(account.measured, groups.back().size());
    }
    if (account.measured == 1 && !phi_in) return incidences;
    Made made;
    for (const std::vector<const Incidence*>& group : groups) {
        Ring ring(group, symmetry, channels, phi_in);
        if (ring.count() == 0) continue;
        if (ring.count() == 1 && !phi_in)
            made.lobes[0].push_back(ring.source_of(0));
        else if (!phi_in)
            add_mean(ring, channels, made);
        else if (!add_at(ring, *phi_in, channels, made))
            throw Error("unfit_measurement",
                        "at theta_in = " + in_words(ring.theta_i()) +
                            " no light was measured on both sides of phi_in = " +
                            in_words(*phi_in) + " degrees, at most " + in_words(kAzimuthGapMax) +
                            " apart; its azimuths are " + degrees_words(group));
    }
    account.at_halves = phi_in && (made.left_out[1].all <= 0 ||
                                   made.left_out[1].relative() <= made.left_out[0].relative());
    account.spread = made.spread[account.at_halves].relative();
    account.error = predicted(made, phi_in, account.at_halves);
    return std::move(made.lobes[account.at_halves]);
}

}  // namespace kiln::measured
