// SPDX-License-Identifier: Apache-2.0
#include "server/scene/table_jobs.h"

#include <algorithm>
#include <charconv>

#include "server/spec/axis_value.h"
#include "server/spec/channels.h"
#include "server/spec/deficit.h"
#include "server/spec/kinds.h"
#include "server/spec/slice_grid.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

// Charlie's lobe is no number at NoV = 0.
constexpr double kSheenNoVLeast = 1e-4;

// Samples a second that two cores with AVX-512 were seen to integrate, by benchmarks/bench_kernels:
// a scale for people, not a promise.
constexpr double kGgxRate = 1.5e9, kOtherRate = 0.2e9;
// Texels a second of an atlas with its albedos and lookup errors, by the same cores.
constexpr double kAtlasRate = 0.7e6;

std::string number(double value) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string axis(const char* parameter, const char* mapping, double lo, double hi, bool flip) {
    return std::string(R"({"parameter":")") + parameter + R"(","mapping":")" + mapping +
           R"(","grid":"node","flip":)" + (flip ? "true" : "false") + R"(,"range":[)" + number(lo) +
           "," + number(hi) + "]}";
}

/// A range, or the one node that a value takes: the start of an axis that ends at 1, or its end.
std::string roughness_axis_of(const Range& piece) {
    if (!piece.fixed()) return axis("roughness", "linear", piece.lo, piece.hi, false);
    if (piece.lo < 1) return axis("roughness", "linear", piece.lo, 1, false);
    return axis("roughness", "linear", 0, 1, true);
}

std::string model_fields(TableKind kind, const PlanOptions& options,
                         const std::optional<rules::Reflectance>& fixed) {
    switch (kind) {
        case TableKind::specular:
            if (!fixed) return R"("quantities":["split_sum_scale","split_sum_bias"])";
            if (*fixed == rules::Reflectance{1, 1}) return R"("quantities":["directional_albedo"])";
            return std::string(R"("quantities":[")") +
                   (options.multiscatter == Multiscatter::none ? "specular" : "compensated") +
                   R"(_albedo"],"multiscatter":")" + std::string(to_word(options.multiscatter)) +
                   R"(","fresnel":{"model":"schlick","f0":)" + number(fixed->f0) + R"(,"f90":)" +
                   number(fixed->f90) + "}";
        case TableKind::average:
            return R"("quantities":["average_albedo"])";
        case TableKind::sheen:
            return R"("quantities":["directional_albedo"],)"
                   R"("microfacet":{"distribution":"charlie","masking":"charlie"})";
        case TableKind::diffuse:
            return R"("quantities":["diffuse_albedo"],"diffuse":{"model":")" +
                   std::string(to_word(options.diffuse)) + R"("})";
    }
    __builtin_unreachable();
}

std::uint64_t pixel_bytes(PixelType pixel) {
    switch (pixel) {
        case PixelType::uint8:
            return 1;
        case PixelType::half:
        case PixelType::uint16:
            return 2;
        case PixelType::float32:
        case PixelType::rgb9e5:  // three colours
            return 4;
    }
    __builtin_unreachable();
}

}  // namespace

JobSpec table_job(TableKind kind, const Range& piece, const PlanOptions& options,
                  const std::optional<rules::Reflectance>& fixed) {
    const std::string rows = std::to_string(rules::rows_of(piece, options.resolution));
    const bool line = kind == TableKind::average;
    const double NoV_least = kind == TableKind::sheen ? kSheenNoVLeast : 0;
    const std::string rough = roughness_axis_of(piece);
    const std::string layout =
        line ? R"({"x":)" + rough + "}"
             : R"({"x":)" + axis("NoV", "sqrt", NoV_least, 1, false) + R"(,"y":)" + rough + "}";
    const std::string resolution =
        line ? "[" + rows + "]" : "[" + std::to_string(options.resolution) + "," + rows + "]";
    try {
        return parse_job("{" + model_fields(kind, options, fixed) + R"(,"resolution":)" +
                         resolution + R"(,"layout":)" + layout + R"(,"sample_count":)" +
                         std::to_string(options.sample_count) + R"(,"device":")" +
                         std::string(to_word(options.device)) + R"(","output":{"format":")" +
                         std::string(to_word(options.format)) + R"(","pixel":")" +
                         std::string(to_word(options.pixel)) + R"("}})");
    } catch (const InvalidJob& error) {
        const Problem& first = error.problems.front();
        throw Error("bad_query", "the options make no job: " + first.pointer + " " + first.message);
    }
}

namespace {

/// Texels whose deficit is drawn by log-uniform tangents, beside everything else: the engine draws
/// there twice.
std::uint64_t texels_drawn_twice(const JobSpec& job) {
    const bool asked = job.quantities[0] == Quantity::compensated_albedo &&
                       (job.multiscatter == Multiscatter::kulla_conty ||
                        job.multiscatter == Multiscatter::kulla_conty_linear);
    if (!asked) return 0;
    std::uint64_t count = 0;
    for (std::int64_t y = 0; y < job.resolution[1]; ++y) {
        const double alpha = alpha_from_roughness(axis_value(job.axes[1], y, job.resolution[1]));
        for (std::int64_t x = 0; x < job.resolution[0]; ++x) {
            const double NoV = axis_value(job.axes[0], x, job.resolution[0]);
            const double expected = expected_deficit(job.masking, NoV, alpha);
            count += better_apart(alpha, expected, false) ? 1 : 0;
        }
    }
    return count;
}

/// Nothing but interpolation of what was measured: no BRDF is evaluated.
Estimate estimate_of_measured(const JobSpec& job) {
    const SliceGrid grid = slice_grid(job);
    const std::uint64_t texels = grid.width() * grid.height();
    // Where values come from stands in a channel of its own, which a PNG has no place for.
    const std::uint64_t colours = job.pixel == PixelType::rgb9e5 ? 1 : 3;
    const std::uint64_t channels = colours + (job.format == ImageFormat::exr ? 1 : 0);
    return {.evaluations = 0,
            .bytes = texels * channels * pixel_bytes(job.pixel),
            .seconds = static_cast<double>(texels) / kAtlasRate};
}

}  // namespace

Estimate estimate_of(const JobSpec& job) {
    if (is_measured(job.kind)) return estimate_of_measured(job);
    Estimate estimate;
    const bool averaged =
        std::none_of(job.quantities.begin(), job.quantities.end(), depends_on_NoV);
    std::uint64_t texels = 1;
    for (const std::int64_t n : job.resolution) texels *= static_cast<std::uint64_t>(n);
    std::uint64_t places = texels;
    if (averaged && job.resolution.size() > 1)
        places = static_cast<std::uint64_t>(job.resolution[1]);
    places += texels_drawn_twice(job);
    estimate.evaluations = places * static_cast<std::uint64_t>(job.sample_count);
    estimate.bytes = texels * channels_of(job).size() * pixel_bytes(job.pixel);
    const bool ggx =
        job.distribution == Distribution::ggx && job.quantities[0] != Quantity::diffuse_albedo;
    estimate.seconds = static_cast<double>(estimate.evaluations) / (ggx ? kGgxRate : kOtherRate);
    return estimate;
}

void Estimate::add(const Estimate& other) {
    evaluations += other.evaluations;
    bytes += other.bytes;
    seconds += other.seconds;
}

}  // namespace kiln
