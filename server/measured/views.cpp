// SPDX-License-Identifier: Apache-2.0
#include "server/measured/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/measured/physics.h"
#include "server/measured/reader.h"

namespace kiln::measured {
namespace {

constexpr Colour kPaper = {0.96, 0.96, 0.96}, kGround = {0.86, 0.87, 0.89};
constexpr Colour kGrid = {0.62, 0.64, 0.68}, kLight = {0.95, 0.55, 0.05},
                 kMirror = {0.05, 0.12, 0.55};
constexpr Colour kNormal = {0.1, 0.1, 0.1};

Vec cross(Vec a, Vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vec unit(Vec a) {
    const double length = std::sqrt(dot(a, a));
    return length > 0 ? (1 / length) * a : Vec{0, 0, 1};
}

/// Seen from afar; the light, at azimuth 0, stands on the left.
struct Camera {
    Vec towards = direction(66, 62), right = unit(cross({0, 0, 1}, towards)),
        up = cross(towards, right);
    double scale = 1, x = 0, y = 0;
    Canvas::Point see(Vec p, const Colour& colour) const {
        return {x + scale * dot(p, right), y - scale * dot(p, up), dot(p, towards), colour};
    }
};

void draw_ground(Canvas& canvas, const Camera& camera) {
    constexpr int kSteps = 120;
    constexpr double kLift = 2e-3;
    const auto around = [&](double radius, int n, const Colour& colour) {
        return camera.see(radius * direction(90, 360.0 * n / kSteps), colour);
    };
    const Canvas::Point middle = camera.see({0, 0, 0}, kGround);
    for (int n = 0; n < kSteps; ++n) {
        canvas.triangle(middle, around(1.05, n, kGround), around(1.05, n + 1, kGround));
        for (const double radius : {0.5, 1.0})
            canvas.line(around(radius, n, kGrid), around(radius, n + 1, kGrid), 1, kLift);
    }
    for (int n = 0; n < kSteps; n += kSteps / 12)
        canvas.line(camera.see({0, 0, 0}, kGrid), around(1.0, n, kGrid), 0.7, kLift);
}

void draw_ray(Canvas& canvas, const Camera& camera, Vec from, const Colour& colour, bool arrow) {
    canvas.line(camera.see(from, colour), camera.see({0, 0, 0}, colour), 2.2, 4e-3);
    if (!arrow) return;
    const Vec side = unit(cross(from, camera.towards));
    const Vec tip = 0.06 * from, back = 0.16 * from;
    canvas.triangle(camera.see(tip + 0.05 * camera.towards, colour),
                    camera.see(back + 0.03 * side + 0.05 * camera.towards, colour),
                    camera.see(back - 0.03 * side + 0.05 * camera.towards, colour));
}

/// A grid over the hemisphere about the mirror direction, dense at the peak, ending at the horizon.
struct Mesh {
    static constexpr std::size_t kRings = 160, kSpokes = 256;
    std::vector<Vec> out, place;
    std::vector<Colour> colour;
    std::size_t at(std::size_t ring, std::size_t spoke) const {
        return ring * kSpokes + spoke % kSpokes;
    }
};

std::vector<Vec> mesh_directions(double theta_in) {
    const double c = std::cos(theta_in * kDegree), s = std::sin(theta_in * kDegree);
    std::vector<Vec> out;
    for (std::size_t ring = 0; ring <= Mesh::kRings; ++ring)
        for (std::size_t spoke = 0; spoke < Mesh::kSpokes; ++spoke) {
            const double turn = 360.0 * static_cast<double>(spoke) / Mesh::kSpokes;
            const double v = static_cast<double>(ring) / Mesh::kRings;
            const double end = std::atan2(c, s * std::cos(turn * kDegree));  // of theta_d
            const double half = std::sin(end / 2) * v * v;
            Vec view = from_mirror(theta_in, direction(2 * std::asin(half) / kDegree, turn));
            view.z = std::max(0.0, view.z);
            out.push_back(unit(view));
        }
    return out;
}

/// The colour of the whole lobe, its largest channel 1, a little towards white.
Colour tint_of(const Sampled& found) {
    Colour sum{};
    for (std::size_t n = 0; n < found.r.size(); ++n) {
        sum[0] += std::max(0.0f, found.r[n]);
        sum[1] += std::max(0.0f, found.g[n]);
        sum[2] += std::max(0.0f, found.b[n]);
    }
    const double most = std::max({sum[0], sum[1], sum[2], 1e-30});
    for (double& v : sum) v = 0.12 + 0.78 * v / most;
    return sum;
}

constexpr Colour kGuessed = {0.26, 0.27, 0.34};

/// What is beyond the measurement, in the lobe's own colour but dark.
Colour guessed(const Colour& tint) {
    Colour made{};
    for (std::size_t k = 0; k < 3; ++k) made[k] = 0.8 * kGuessed[k] + 0.2 * tint[k];
    return made;
}

double font_of(double side) { return std::clamp(13 * side / 640, 9.0, 20.0); }

/// Title and legend, one under the other.
std::vector<Words> lobe_words(const Frame& frame, double side, const Colour& tint) {
    const double font = font_of(side);
    std::vector<Words> words;
    const auto add = [&](std::string text, const std::optional<Colour>& swatch) {
        const double line = 1.6 * font * static_cast<double>(words.size() + 1);
        words.push_back({font, line, std::move(text), font});
        words.back().swatch = swatch;
    };
    if (!frame.title.empty()) add(frame.title, std::nullopt);
    add("light", kLight);
    add("mirror direction", kMirror);
    add("normal", kNormal);
    add("rings: half of the longest, and all", kGrid);
    add("measured", tint);
    add("extrapolated", guessed(tint));
    return words;
}

/// How much of the surroundings of each node is extrapolated: the border between the two colours is
/// then as smooth as the mesh allows, where nodes alone would give its corners teeth.
std::vector<double> extrapolated_shares(const Sampled& found) {
    std::vector<double> share;
    for (const float origin : found.origin) share.push_back(origin < 1.5f ? 0 : 1);
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
        const std::vector<double> last = share;
        for (std::size_t ring = 1; ring <= Mesh::kRings; ++ring)
            for (std::size_t spoke = 0; spoke < Mesh::kSpokes; ++spoke) {
                double sum = 0;
                for (std::size_t dr = 0; dr < 3; ++dr)
                    for (std::size_t ds = 0; ds < 3; ++ds) {
                        const std::size_t r = std::min(ring + dr - 1, Mesh::kRings);
                        const std::size_t s = (spoke + Mesh::kSpokes + ds - 1) % Mesh::kSpokes;
                        sum += (dr == 1 ? 2 : 1) * (ds == 1 ? 2 : 1) * last[r * Mesh::kSpokes + s];
                    }
                share[ring * Mesh::kSpokes + spoke] = sum / 16;
            }
    }
    return share;
}

/// Puts every direction at its distance and shades the surface by its normal.
void shape(Mesh& mesh, const Sampled& found, const Camera& camera, double most, bool root) {
    const Colour tint = tint_of(found), dark = guessed(tint);
    for (std::size_t n = 0; n < mesh.out.size(); ++n) {
        const double f = (static_cast<double>(found.r[n]) + found.g[n] + found.b[n]) / 3;
        const double length = std::max(0.0, f) / most;
        mesh.place.push_back((root ? std::cbrt(length) : length) * mesh.out[n]);
    }
    const Vec lamp = unit(camera.towards + 0.9 * camera.up - 0.7 * camera.right);
    const std::vector<double> beyond = extrapolated_shares(found);
    mesh.colour.resize(mesh.out.size());
    for (std::size_t ring = 0; ring <= Mesh::kRings; ++ring)
        for (std::size_t spoke = 0; spoke < Mesh::kSpokes; ++spoke) {
            const std::size_t low = std::max<std::size_t>(ring, 2) - 1;
            const std::size_t high = std::min(std::max<std::size_t>(ring, 1) + 1, Mesh::kRings);
            const std::size_t before = spoke + Mesh::kSpokes - 1, n = mesh.at(ring, spoke);
            const Vec along = mesh.place[mesh.at(high, spoke)] - mesh.place[mesh.at(low, spoke)];
            const std::size_t middle = std::max<std::size_t>(ring, 1);
            const Vec across =
                mesh.place[mesh.at(middle, spoke + 1)] - mesh.place[mesh.at(middle, before)];
            Vec normal = unit(cross(along, across));
            if (dot(normal, camera.towards) < 0) normal = -1 * normal;
            const double shade = 0.28 + 0.72 * std::max(0.0, dot(normal, lamp));
            const double gloss = 0.25 * std::pow(std::max(0.0, dot(normal, lamp)), 40);
            for (std::size_t k = 0; k < 3; ++k)
                mesh.colour[n][k] = shade * (tint[k] + beyond[n] * (dark[k] - tint[k])) + gloss;
        }
}

void draw_mesh(Canvas& canvas, const Camera& camera, const Mesh& mesh) {
    for (std::size_t ring = 0; ring < Mesh::kRings; ++ring)
        for (std::size_t spoke = 0; spoke < Mesh::kSpokes; ++spoke) {
            const auto corner = [&](std::size_t r, std::size_t s) {
                const std::size_t n = mesh.at(r, s);
                return camera.see(mesh.place[n], mesh.colour[n]);
            };
            const auto a = corner(ring, spoke), b = corner(ring + 1, spoke),
                       c = corner(ring + 1, spoke + 1), d = corner(ring, spoke + 1);
            canvas.triangle(a, b, c);
            canvas.triangle(a, c, d);
        }
}

/// Light of the sky from a direction of the world: bright above, dim below, no edge at the horizon.
double sky(Vec from) {
    const double rise = std::clamp(0.5 + 1.5 * from.z, 0.0, 1.0);
    return 0.12 + 0.5 * rise * rise * (3 - 2 * rise);
}

struct Pixel {
    std::size_t index = 0;
    Vec normal;
};

std::vector<Pixel> sphere_pixels(std::size_t width, std::size_t height, double radius, Vec right,
                                 Vec up, Vec towards) {
    std::vector<Pixel> pixels;
    const double middle_x = static_cast<double>(width) / 2;
    const double middle_y = static_cast<double>(height) / 2;
    for (std::size_t n = 0; n < width * height; ++n) {
        const double x = (static_cast<double>(n % width) + 0.5 - middle_x) / radius;
        const double y = (middle_y - static_cast<double>(n / width) - 0.5) / radius;
        const double r2 = x * x + y * y;
        if (r2 >= 1) continue;
        pixels.push_back({n, x * right + y * up + std::sqrt(1 - r2) * towards});
    }
    return pixels;
}

/// Adds f cos(theta_in) times a lamp's light to each pixel that it reaches.
void add_lamp(const LobeTables& tables, Resampler& resampler, const std::vector<Pixel>& pixels,
              Vec lamp, Vec eye, double strength, std::vector<Colour>& light) {
    std::vector<std::size_t> lit;
    std::vector<double> theta_in;
    std::vector<Vec> out;
    for (std::size_t n = 0; n < pixels.size(); ++n) {
        const Vec normal = pixels[n].normal;
        const double in = dot(normal, lamp);
        if (in <= 0) continue;
        Vec tangent = lamp - in * normal;  // the light's azimuth
        tangent =
            dot(tangent, tangent) > 1e-12 ? unit(tangent) : unit(cross({0.3, 0.5, 1}, normal));
        lit.push_back(n);
        theta_in.push_back(std::acos(std::min(1.0, in)) / kDegree);
        out.push_back(
            {dot(eye, tangent), dot(eye, cross(normal, tangent)), std::max(0.0, dot(eye, normal))});
    }
    if (lit.empty()) return;
    const Sampled found = resampler.values(tables, theta_in, out);
    for (std::size_t n = 0; n < lit.size(); ++n) {
        const double e = strength * std::cos(theta_in[n] * kDegree);
        const float f[3] = {found.r[n], found.g[n], found.b[n]};
        for (std::size_t k = 0; k < 3; ++k)
            light[lit[n]][k] += e * std::max(0.0, static_cast<double>(f[k]));
    }
}

}  // namespace

View error_view(const std::vector<std::pair<std::string, Table>>& maps,
                const std::vector<double>& theta_in) {
    constexpr double kFull = 0.5;
    constexpr std::size_t kHead = 40, kGap = 8;
    const std::size_t width = maps.front().second.width, height = maps.front().second.height;
    View view;
    view.picture = {maps.size() * (width + kGap) - kGap, kHead + height, {}};
    view.picture.rgb.assign(3 * view.picture.width * view.picture.height, 255);
    view.words.push_back({4, 16, "red: brighter than measured, blue: darker; in full at 50 %"});
    for (std::size_t m = 0; m < maps.size(); ++m) {
        const std::size_t left = m * (width + kGap);
        view.words.push_back({static_cast<double>(left) + 4, 34, maps[m].first});
        for (std::size_t n = 0; n < width * height; ++n) {
            const double error =
                std::clamp(static_cast<double>(maps[m].second.planes[0][n]) / kFull, -1.0, 1.0);
            const double pale = 1 - std::abs(error);
            const Colour c = {error > 0 ? 1 : pale, pale, error < 0 ? 1 : pale};
            const std::size_t x = left + n % width, y = kHead + n / width;
            for (std::size_t k = 0; k < 3; ++k)
                view.picture.rgb[3 * (y * view.picture.width + x) + k] = srgb_code(c[k]);
        }
        for (std::size_t s = 0; s < theta_in.size(); ++s)
            view.words.push_back({static_cast<double>(left) + 4,
                                  static_cast<double>(kHead + s * height / theta_in.size()) + 12,
                                  in_words(theta_in[s]) + " degrees", 10});
    }
    return view;
}

std::string beyond_measured(const Material& material, double theta_in) {
    constexpr double kSame = 1e-3;  // degrees
    const double first = material.theta_in().front(), last = material.theta_in_max();
    if (theta_in >= first - kSame && theta_in <= last + kSame) return "";
    return "theta_in " + in_words(theta_in) + " degrees lies outside the measured " +
           in_words(first) + " to " + in_words(last) + ": the lobe is extrapolated";
}

View lobe_view(const LobeTables& tables, double theta_in, const Frame& frame,
               Resampler& resampler) {
    Mesh mesh;
    mesh.out = mesh_directions(theta_in);
    const Sampled found = resampler.values(tables, theta_in, mesh.out);
    View view;
    view.f_max = 1e-30;
    for (std::size_t n = 0; n < mesh.out.size(); ++n)
        view.f_max =
            std::max(view.f_max, (static_cast<double>(found.r[n]) + found.g[n] + found.b[n]) / 3);
    const auto width = static_cast<double>(frame.width), height = static_cast<double>(frame.height);
    const double side = std::min(width, height * 4 / 3);
    Camera camera;
    camera.scale = 0.43 * side;
    camera.x = 0.5 * width;
    camera.y = 0.5 * height + 0.1425 * side;
    Canvas canvas(frame.width, frame.height, kPaper);
    draw_ground(canvas, camera);
    // A mirror-like peak would leave nothing but a needle to see.
    constexpr double kNeedle = 20;
    const Material::Albedo e = resampler.albedos(tables, std::array{theta_in}).front();
    const double mean = (e.value[0] + e.value[1] + e.value[2]) / 3 / std::numbers::pi;
    view.cube_root = view.f_max > kNeedle * mean;
    shape(mesh, found, camera, view.f_max, view.cube_root);
    draw_mesh(canvas, camera, mesh);
    draw_ray(canvas, camera, 1.02 * direction(theta_in, 0), kLight, true);
    draw_ray(canvas, camera, 1.02 * direction(theta_in, 180), kMirror, false);
    draw_ray(canvas, camera, 1.02 * direction(0, 0), kNormal, false);
    view.picture = canvas.picture();
    view.words = lobe_words(frame, side, tint_of(found));
    const double font = font_of(side);
    view.words.push_back({font, height - 0.8 * font,
                          "theta_in " + in_words(theta_in) + " degrees, f_r to " +
                              in_words(view.f_max) + " 1/sr" +
                              (view.cube_root ? ", drawn as its cube root" : ""),
                          font});
    return view;
}

View sphere_view(const LobeTables& tables, const Frame& frame, Resampler& resampler) {
    constexpr std::size_t kSide = 2;  // samples along a pixel's side
    constexpr double kBehind = 0.16;
    const std::size_t width = kSide * frame.width, height = kSide * frame.height;
    const double radius = 0.46 * static_cast<double>(std::min(width, height));
    const Vec eye = direction(78, -90), right = unit(cross({0, 0, 1}, eye)), up = cross(eye, right);
    const std::vector<Pixel> pixels = sphere_pixels(width, height, radius, right, up, eye);
    std::vector<Colour> light(pixels.size());
    add_lamp(tables, resampler, pixels, unit(eye - 0.8 * right + 0.9 * up), eye, 2.0, light);
    add_lamp(tables, resampler, pixels, unit(-0.35 * eye + right + 0.35 * up), eye, 1.2, light);
    constexpr std::size_t kAlbedos = 64;
    const Companion companion = companion_of(tables, kAlbedos, resampler);
    std::vector<Colour> sum(frame.width * frame.height);
    std::vector<double> cover(sum.size(), 0.0);
    for (std::size_t n = 0; n < pixels.size(); ++n) {
        const Vec normal = pixels[n].normal;
        const double view = std::max(0.0, dot(normal, eye));
        const auto texel = std::min(static_cast<std::size_t>(view * kAlbedos), kAlbedos - 1);
        const double around = sky(2 * view * normal - eye);
        const std::size_t x = pixels[n].index % width / kSide, y = pixels[n].index / width / kSide;
        for (std::size_t k = 0; k < 3; ++k)
            sum[y * frame.width + x][k] +=
                light[n][k] + around * static_cast<double>(companion.table.planes[k][texel]);
        cover[y * frame.width + x] += 1;
    }
    View view;
    view.picture = {frame.width, frame.height, {}};
    for (std::size_t n = 0; n < sum.size(); ++n)
        for (std::size_t k = 0; k < 3; ++k) {
            const double share = cover[n] / (kSide * kSide);
            view.picture.rgb.push_back(
                srgb_code(sum[n][k] / (kSide * kSide) + (1 - share) * kBehind));
        }
    const double font = font_of(static_cast<double>(std::min(frame.width, frame.height)));
    if (!frame.title.empty())
        view.words.push_back({font, 1.6 * font, frame.title, font, {0.9, 0.9, 0.9}});
    return view;
}

}  // namespace kiln::measured
