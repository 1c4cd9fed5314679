// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "client/failure.h"
#include "client/terminal.h"
#include "server/base/default_address.h"
#include "server/measured/material.h"
#include "server/spec/job_spec.h"

namespace kiln::client {

/// Where a server is looked for when none was named.
inline const std::string kDefaultServer = std::string("http://") + kDefaultAddress;

/// How long a command may take, and how its user hears of it.
struct WatchOptions {
    double timeout_s = 0;  ///< 0 = none
    bool json = false;
    ProgressMode progress = ProgressMode::automatic;
};

/// And where its job runs.
struct RunOptions : WatchOptions {
    std::string server;  ///< "" where none was named
    bool local = false;
};

struct BakeOptions : RunOptions {
    std::string job;                        ///< file, or "-" for standard input
    std::vector<std::string> settings;      ///< field=value
    std::string output;                     ///< file, or "-" for standard output
    std::string report;                     ///< file, or "" for none
    std::vector<std::string> measurements;  ///< files that the job names by their hash
    std::string sidecar;  ///< of measured kinds: file, or "" for one beside the output
};

struct StudyOptions : RunOptions {
    Kind kind = Kind::furnace;
    std::string job;                    ///< file, "-" for standard input, "" for no document
    std::vector<std::string> settings;  ///< field=value
    std::string folder;                 ///< "" for none
};

struct AdviseOptions : WatchOptions {
    std::string job;                    ///< file, or "-" for standard input
    std::vector<std::string> settings;  ///< field=value
    double max_error = 0;
};

struct SceneOptions : RunOptions {
    std::string scene;                      ///< file, or "-" for standard input
    std::vector<std::string> settings;      ///< option=value of the contract's PlanOptions
    std::string output;                     ///< folder
    std::string report;                     ///< file, or "" for none beside that in the folder
    std::vector<std::string> measurements;  ///< files that the scene names by their hash
    std::optional<double> max_error;        ///< bound on the proof
    bool prove = true;
};

struct ServerOptions {
    std::string server;  ///< "" where none was named
    bool json = false;
};

struct SliceOptions {
    std::vector<std::string> files;  ///< a material each
    std::string output;              ///< .exr or .png
    std::string sidecar;             ///< JSON for a shader, or "" for none
    std::vector<double> theta_in;    ///< degrees; empty = the usual ones
    std::size_t width = 361, height = 181, gutter = 0;
    measured::Extrapolation extrapolation;
    std::optional<double> phi_in;  ///< degrees; else the mean over all azimuths
    bool json = false;
};

struct ViewOptions {
    std::string file, output;        ///< output: .png
    std::optional<double> theta_in;  ///< degrees; 30 where none is given
    std::size_t size = 640;          ///< pixels along the picture
    bool sphere = false;             ///< a lit sphere in place of the lobe
    measured::Extrapolation extrapolation;
    std::optional<double> phi_in;  ///< degrees; else the mean over all azimuths
};

struct FitOptions {
    std::string file;              ///< "-" for standard input
    std::string error_map;         ///< .exr or .png, or "" for none
    std::optional<double> phi_in;  ///< degrees; else the mean over all azimuths
    bool json = false;
};

// Each command writes its data to standard output and everything else to standard error, and
// returns its exit status or throws Failure, or what the rooms below throw.
Exit bake(const BakeOptions& options);
/// Makes a study of a job, prints its verdicts, and writes KIND.png, .svg, .csv and .json into the
/// folder. Exit::different where a verdict is not what is known of the model.
Exit study(const StudyOptions& options);
/// Exit::different where no table is within max_error.
Exit advise(const AdviseOptions& options);
/// Says what a scene needs, and what it does not; bakes nothing.
Exit plan(const SceneOptions& options);
/// Bakes a scene's plan into a folder: tables, manifest.json, report.json. Exit::different where a
/// bound on the error was asked for and does not hold.
Exit bake_scene(const SceneOptions& options);
Exit info(const std::string& path, bool json);
/// Exit::different above max_error in any texel, for NaN, and for files of different sizes or
/// channels.
Exit diff(const std::string& a, const std::string& b, double max_error, bool json);
Exit devices(bool json);
/// What a measured file says, and what speaks for it. Exit::usage where no format fits.
Exit measure_info(const std::string& path, bool json);
/// Gives measured files to a server and prints their ids.
Exit measure_upload(const ServerOptions& options, const std::vector<std::string>& files);
/// Measured files into an image of slices; of several, an atlas.
Exit measure_slices(const SliceOptions& options);
/// A measured file's reflection lobe, or a sphere of its material, as a picture.
Exit measure_view(const ViewOptions& options);
/// Analytic models fitted to a measured file, with what they miss.
Exit measure_fit(const FitOptions& options);
Exit list_jobs(const ServerOptions& options, const std::string& state, std::size_t count_max);
/// `id` may be the start of an id that fits one job alone.
Exit cancel(const ServerOptions& options, const std::string& id);

}  // namespace kiln::client
