// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "server/base/version.h"
#include "server/image/describe_measured.h"
#include "server/image/describing.h"
#include "server/image/image.h"
#include "server/image/model_words.h"
#include "server/spec/channels.h"
#include "server/spec/kinds.h"
#include "server/spec/layouts.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

using describing::any, describing::is_split_sum, describing::number, describing::text;

constexpr const char* kAlphaMapping = "alpha = roughness^2";
constexpr const char* kColor = "linear data, no transfer function";

std::string joined(const std::vector<std::string>& parts, const char* separator) {
    std::string out;
    for (const auto& part : parts) out += (out.empty() ? "" : separator) + part;
    return out;
}

const char* meaning(const JobSpec& job, Quantity quantity) {
    if (quantity == Quantity::compensated_albedo && job.multiscatter == Multiscatter::none)
        return ", single scattering under the Fresnel term: the job compensates nothing";
    switch (quantity) {
        case Quantity::split_sum_scale:
            return " (A), multiplies F0: albedo(F0, F90) = F0 A + F90 B";
        case Quantity::split_sum_bias:
            return " (B), multiplies F90: albedo(F0, F90) = F0 A + F90 B";
        case Quantity::directional_albedo:
            return ", E(NoV, roughness) with F = 1";
        case Quantity::average_albedo:
            return ", E_avg(roughness) = 2 * integral of E mu dmu over 0..1, equal for every NoV";
        case Quantity::multiscatter_albedo:
            return ", integral of f_ms times the cosine (Kulla and Conty 2017): 1 - E with F = 1";
        case Quantity::specular_albedo:
            return ", single scattering under the Fresnel term";
        case Quantity::compensated_albedo:
            return ", single scattering and its compensation under the Fresnel term";
        case Quantity::fresnel_average:
            return ", F_avg = 2 * integral of F mu dmu over 0..1";
        case Quantity::diffuse_albedo:
            return ", directional albedo of the diffuse lobe";
        case Quantity::diffuse_average_albedo:
            return ", 2 * integral of the diffuse lobe's albedo mu dmu over 0..1";
        case Quantity::total_albedo:
            return ", white-furnace value of the coupled lobes";
        case Quantity::sheen_albedo:
            return ", E(NoV, roughness) of Charlie under Neubelt's masking, uniform importance";
    }
    return "";
}

std::vector<std::string> channel_lines(const JobSpec& job) {
    const std::vector<Channel> channels = channels_of(job);
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const std::string letter = channels.size() > 4 ? "" : std::string(1, "RGBA"[i]) + ": ";
        const double added = added_by_shader(job, channels[i].quantity);
        const std::string less = added > 0 ? " - " + number(added) : "";
        lines.push_back(letter + channels[i].name + less + meaning(job, channels[i].quantity));
    }
    if (job.format == ImageFormat::png && channels.size() == 2)
        lines.emplace_back("B: 0, carries no quantity (PNG has no two-channel colour)");
    return lines;
}

// The axis as p(t), t in 0…1 from the start of its range to the end.
std::string formula(const Axis& axis) {
    const std::string p = text(to_word(axis.parameter));
    const std::string lo = number(axis.lo), hi = number(axis.hi);
    const bool whole = axis.lo == 0 && axis.hi == 1;
    switch (axis.mapping) {
        case Mapping::linear:
            return p + " = " + (whole ? "t" : lo + " + (" + hi + " - " + lo + ") t");
        case Mapping::sqrt:
            return p + " = " +
                   (whole ? "t^2"
                          : "(sqrt(" + lo + ") + (sqrt(" + hi + ") - sqrt(" + lo + ")) t)^2");
        case Mapping::square:
            return p + " = " +
                   (whole ? "sqrt(t)" : "sqrt(" + lo + "^2 + (" + hi + "^2 - " + lo + "^2) t)");
    }
    return "";
}

const char* mapping_words(Mapping mapping) {
    switch (mapping) {
        case Mapping::linear:
            return "linear in ";
        case Mapping::sqrt:
            return "linear in the square root of ";
        case Mapping::square:
            return "linear in the square of ";
    }
    return "";
}

// What a preset's shift and bounds do to the ends of an axis.
std::string bounds(const Axis& axis) {
    std::string words;
    if (axis.least > 0) words += ", at least " + number(axis.least);
    if (axis.shift != 0)
        words += std::isfinite(axis.most)
                     ? ", at most " + number(axis.most)
                     : ", not bounded, so beyond " + number(axis.hi) + " at that end";
    return words;
}

bool is_sheen(Quantity quantity) { return quantity == Quantity::sheen_albedo; }

std::string listed_slices(const Axis& axis) {
    std::string line = "z: " + text(to_word(axis.parameter)) + ", slice by slice";
    for (std::size_t i = 0; i < axis.values.size(); ++i)
        line += (i ? ", " : ": ") + number(axis.values[i]);
    return line +
           "; slices stand one below the other; between two of them mix both by where the value "
           "lies";
}

/// Where a shader finds parameter t on an axis. Slices stand one below the other in v, and lie too
/// far apart for the hardware to mix them.
std::string lookup(const JobSpec& job, std::size_t index, const std::string& t) {
    const bool centers = job.axes[index].grid == Grid::center;
    const std::string n = std::to_string(job.resolution[index]);
    const std::string bracketed = t == "t" ? t : "(" + t + ")";
    if (index == 2)
        return "; slices stand one below the other; look up at slice = " + bracketed +
               (centers ? " " + n + " - 0.5" : " (" + n + " - 1)") + " within 0.." +
               std::to_string(job.resolution[2] - 1) +
               ", mixing the slices next to it by its fraction";
    const std::string along = centers ? t : "(" + bracketed + " (" + n + " - 1) + 0.5)/" + n;
    if (index == 0) return "; look up at u = " + along;
    if (job.axes.size() < 3) return "; look up at v = " + along;
    return "; look up at v = (slice + " + along + ")/" + std::to_string(job.resolution[2]) +
           " of a whole slice";
}

std::string filtering(const JobSpec& job) {
    if (job.axes.size() < 3) return "lookup: bilinear, clamp to edge, no mipmaps";
    const std::string edge = number(0.5) + "/" + std::to_string(job.resolution[1]);
    return "lookup: bilinear in a slice, v " + std::to_string(job.resolution[2]) +
           " - slice held within " + edge + "..1 - " + edge +
           " or the next slice bleeds in; clamp to edge, no mipmaps";
}

std::string axis_line(const JobSpec& job, std::size_t index) {
    const Axis& axis = job.axes[index];
    if (!axis.values.empty()) return listed_slices(axis);
    const std::string n = std::to_string(job.resolution[index]);
    const std::string letter(1, "xyz"[index]);
    const bool sliced = job.axes.size() == 3;
    const char* unit = index == 0 ? "column" : index == 1 ? "row" : "slice";
    const char* start = index == 0   ? "left"
                        : index == 2 ? "slice 0, topmost"
                        : sliced     ? "row 0, top of each slice"
                                     : "row 0, top of the image";
    const bool centers = axis.grid == Grid::center;
    const double first = axis.flip ? axis.hi : axis.lo, last = axis.flip ? axis.lo : axis.hi;

    std::string place = centers ? "(i + 0.5)/" + n : "i/(" + n + " - 1)";
    if (job.resolution[index] == 1) place = centers ? "0.5" : "0";
    const std::string shift = axis.shift == 0 ? "" : number(axis.shift) + "/" + n;
    if (!shift.empty()) place += " + " + shift;
    std::string t = axis.flip ? "1 - t" : "t";
    if (!shift.empty()) t += (axis.flip ? " + " : " - ") + shift;
    return letter + ": " + text(to_word(axis.parameter)) + " from " + number(first) + " (" + start +
           ") to " + number(last) + (axis.flip ? ", flipped, " : ", ") +
           mapping_words(axis.mapping) + text(to_word(axis.parameter)) +
           (centers ? ", texel centres: " : ", nodes at the texels: ") + unit + " i of " + n +
           (sliced && index == 1 ? " in each slice" : "") +
           " lies at t = " + (axis.flip ? "1 - " : "") + place + ", " + formula(axis) +
           bounds(axis) + lookup(job, index, t);
}

std::vector<std::string> axis_lines(const JobSpec& job) {
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < job.axes.size(); ++i) lines.push_back(axis_line(job, i));
    return lines;
}

std::vector<std::string> per_axis(const JobSpec& job, std::string (*of)(const Axis&)) {
    std::vector<std::string> words;
    for (std::size_t i = 0; i < job.axes.size(); ++i)
        words.push_back(std::string(1, "xyz"[i]) + " " + of(job.axes[i]));
    return words;
}

}  // namespace

Metadata describe(const JobSpec& job, const Provenance& provenance) {
    if (is_measured(job.kind)) return describe_measured(job, provenance);
    std::vector<std::string> quantities;
    for (const Quantity q : job.quantities) quantities.push_back(text(to_word(q)));
    const auto grid = [](const Axis& axis) {
        return axis.values.empty() ? text(to_word(axis.grid)) : std::string("listed");
    };

    const bool cloth = !any(job, reads_lobe) && any(job, is_sheen);
    Metadata out = {
        {"kiln.job", canonical(job)},
        {"kiln.quantities", joined(quantities, " ")},
        {"kiln.channels", joined(channel_lines(job), "\n")},
        {"kiln.axes", joined(axis_lines(job), "\n")},
        {"kiln.grid", joined(per_axis(job, grid), ", ")},
        {"kiln.layout", job.layout},
        {"kiln.alpha_mapping", kAlphaMapping},
        {"kiln.distribution", text(to_word(cloth ? Distribution::charlie : job.distribution))},
        {"kiln.masking", text(to_word(cloth ? Masking::neubelt : job.masking))},
        {"kiln.fresnel", fresnel_words(job)},
        {"kiln.diffuse", diffuse_words(job)},
        {"kiln.coupling", text(to_word(job.coupling))},
        {"kiln.multiscatter", text(to_word(job.multiscatter))},
        {"kiln.integrator", text(to_word(job.integrator))},
        {"kiln.version", kVersion},
        {"kiln.kernel_digest", provenance.kernel_digest},
        {"kiln.encoder_revision", std::to_string(kEncoderRevision)},
        {"kiln.numerics", provenance.numerics},
        {"kiln.key", provenance.key},
        {"kiln.color", kColor},
    };
    if (job.integrator == Integrator::monte_carlo) {
        out.emplace_back("kiln.sampler", to_word(job.sampler));
        out.emplace_back("kiln.importance", to_word(cloth ? Importance::uniform : job.importance));
        out.emplace_back("kiln.sample_count", std::to_string(job.sample_count));
        out.emplace_back("kiln.seed", std::to_string(job.seed));
    }
    if (provenance.standard_error_max)
        out.emplace_back("kiln.standard_error_max", number(*provenance.standard_error_max));
    return out;
}

std::vector<std::string> convention(const JobSpec& job) {
    if (is_measured(job.kind)) return measured_convention(job);
    std::vector<std::string> lines = axis_lines(job);
    for (auto& line : channel_lines(job)) lines.push_back(std::move(line));
    for (auto& line : layout_lines(job)) lines.push_back(std::move(line));
    lines.emplace_back(kAlphaMapping);
    if (any(job, reads_lobe)) {
        lines.push_back("distribution: " + distribution_words(job.distribution));
        lines.push_back("masking: " + masking_words(job));
    }
    if (any(job, reads_fresnel) || any(job, is_split_sum))
        lines.push_back("Fresnel: " + fresnel_words(job));
    if (any(job, reads_diffuse)) lines.push_back("diffuse: " + diffuse_words(job));
    if (any(job, reads_multiscatter)) {
        lines.push_back("coupling: " + text(to_word(job.coupling)));
        lines.push_back("multiple scattering: " + multiscatter_words(job.multiscatter));
    }
    lines.emplace_back("V points away from the surface, NoV = cos(theta)");
    lines.push_back(std::string("values: ") + kColor);
    lines.push_back(filtering(job));
    return lines;
}

}  // namespace kiln
