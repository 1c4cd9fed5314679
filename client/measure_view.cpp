// SPDX-License-Identifier: Apache-2.0
// `measure view` and `measure fit`: a measured material as a picture and as parameters.
#include <cstdio>

#include "client/commands.h"
#include "client/files.h"
#include "client/terminal.h"
#include "server/image/image.h"
#include "server/measured/bounds.h"
#include "server/measured/fits.h"
#include "server/measured/physics.h"
#include "server/measured/slices.h"
#include "server/measured/views.h"

namespace kiln::client {

namespace {

using namespace measured;

Material material_of(const std::string& path, const Extrapolation& extrapolation, PhiIn phi_in) {
    const std::string bytes = read_input(path, kFileBytesMax);
    try {
        Reading reading = read_measurement(bytes);
        return Material(reading.components.front(), extrapolation, reading.understood, phi_in);
    } catch (const Error& error) {
        throw Failure(Exit::usage, error.code(), path + ": " + error.what());
    }
}

std::string colour_words(const Colour& c) {
    return format_number(c[0]) + " " + format_number(c[1]) + " " + format_number(c[2]);
}

std::string percent(double share) { return format_number(100 * share) + " %"; }

std::string colour_json(const Colour& c) {
    char text[96];
    std::snprintf(text, sizeof text, "[%.9g, %.9g, %.9g]", c[0], c[1], c[2]);
    return text;
}

std::string fit_json(const Fit& fit) {
    char text[256];
    std::snprintf(text, sizeof text,
                  "{\"model\": \"%s\", \"%s\": %.9g, \"f90\": %.9g, \"error\": %.6g, "
                  "\"error_worst\": %.6g, ",
                  to_string(fit.model).c_str(),
                  fit.model == FitModel::ggx_diffuse ? "alpha" : "exponent", fit.width, fit.f90,
                  fit.error, fit.error_worst);
    return text + ("\"diffuse\": " + colour_json(fit.diffuse)) +
           ", \"f0\": " + colour_json(fit.f0) + "}";
}

void check_map(const std::string& path) {
    const std::string extension = extension_of(path);
    if (extension != "png" && extension != "exr")
        throw Failure(Exit::usage, "usage", "--error-map: name a file that ends in .png or .exr");
    check_output(path);
}

/// Of at most six measured incidences, downwards; the models beside each other in a PNG and as
/// channels in an EXR.
std::string error_map_file(const std::vector<Fit>& fits, const Material& material,
                           const LobeTables& tables, Resampler& resampler,
                           const std::string& extension) {
    constexpr std::size_t kSlicesMax = 6, kWidth = 361, kHeight = 181;
    const std::vector<double> all = material.theta_in();
    std::vector<double> theta_in;
    const std::size_t count = std::min(all.size(), kSlicesMax);
    for (std::size_t n = 0; n < count; ++n)
        theta_in.push_back(count > 1 ? all[n * (all.size() - 1) / (count - 1)] : all[0]);
    std::vector<std::pair<std::string, Table>> maps;
    Table table{kWidth, kHeight * count, {}, {}};
    std::string names = "(fit - f) / (|f| + 0.01 of the slice's largest f), green:";
    for (const Fit& fit : fits) {
        Table map = error_map(fit, tables, theta_in, kWidth, kHeight, resampler);
        table.channels.push_back(to_string(fit.model));
        table.planes.push_back(map.planes[0]);
        names += " " + to_string(fit.model);
        maps.emplace_back(to_string(fit.model), std::move(map));
    }
    if (extension == "png") {
        const View view = error_view(maps, theta_in);
        return png_of(view.picture, view.words);
    }
    std::string slices = "theta_in downwards, degrees:";
    for (const double theta : theta_in) slices += " " + format_number(theta);
    return encode(table, ImageFormat::exr, PixelType::half,
                  {{"kiln.channels", names}, {"kiln.slices", slices}})
        .bytes;
}

}  // namespace

Exit measure_view(const ViewOptions& options) {
    if (extension_of(options.output) != "png")
        throw Failure(Exit::usage, "usage", "-o: name a file that ends in .png");
    if (options.sphere && options.theta_in)
        throw Failure(Exit::usage, "usage",
                      "--theta-in is of a lobe; a sphere is lit from all sides. Leave one out");
    check_output(options.output);
    constexpr double kThetaIn = 30;
    const double theta_in = options.theta_in.value_or(kThetaIn);
    const Material material = material_of(options.file, options.extrapolation, options.phi_in);
    const std::string beyond = options.sphere ? "" : beyond_measured(material, theta_in);
    if (!beyond.empty()) say("kiln: " + printable(options.file) + ": " + beyond);
    Resampler resampler;
    const LobeTables tables = make_lobe_tables(material);
    const View view =
        options.sphere
            ? sphere_view(tables, {options.size, options.size, ""}, resampler)
            : lobe_view(tables, theta_in, {options.size, options.size * 3 / 4, ""}, resampler);
    write_output(options.output, png_of(view.picture, view.words));
    return Exit::done;
}

Exit measure_fit(const FitOptions& options) {
    if (!options.error_map.empty()) check_map(options.error_map);
    const Material material = material_of(options.file, {}, options.phi_in);
    Resampler resampler;
    const LobeTables tables = make_lobe_tables(material);
    const std::vector<Fit> fits = {fit_model(FitModel::ggx_diffuse, tables, resampler),
                                   fit_model(FitModel::lafortune_phong, tables, resampler)};
    if (!options.error_map.empty())
        write_output(options.error_map, error_map_file(fits, material, tables, resampler,
                                                       extension_of(options.error_map)));
    const SliceLayout layout;
    const double predicted =
        make_slices(layout, {&material}).accounts[0].predicted.between_incidences();
    if (options.json) {
        std::printf("{\"fits\": [%s, %s], \"predicted_error_of_a_table\": %.6g}\n",
                    fit_json(fits[0]).c_str(), fit_json(fits[1]).c_str(), predicted);
        return Exit::done;
    }
    std::vector<std::vector<std::string>> rows{
        {"model", "alpha or n", "diffuse", "f0", "f90", "error", "at the worst theta_in"}};
    for (const Fit& fit : fits)
        rows.push_back({to_string(fit.model), format_number(fit.width), colour_words(fit.diffuse),
                        colour_words(fit.f0),
                        fit.model == FitModel::ggx_diffuse ? format_number(fit.f90) : "-",
                        percent(fit.error), percent(fit.error_worst)});
    for (const std::string& line : columns(rows)) std::printf("%s\n", line.c_str());
    std::printf(
        "\nThe usual table of this file, %zu slices of %zu x %zu texels, would be off by %s, as "
        "the "
        "file's own points predict.\n",
        layout.theta_in.size(), layout.width, layout.height, percent(predicted).c_str());
    return Exit::done;
}

}  // namespace kiln::client
