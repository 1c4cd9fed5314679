// SPDX-License-Identifier: Apache-2.0
#include "server/compute/advice.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <ranges>
#include <tuple>

#include "server/base/error.h"
#include "server/compute/exactness.h"
#include "server/compute/lattice.h"
#include "server/compute/plan.h"
#include "server/compute/quadrature.h"
#include "server/spec/channels.h"

namespace kiln {

namespace {

/// What "quadrature" in float32 is off by at most, of values up to `most`.
double integration_bound(double most) { return kQuadratureFloatRounding * std::max(1.0, most); }
/// Of the bound: lookup errors need not be known better.
constexpr double kShareOfBound = 0.01, kFinest = 1e-6;
/// What exact values are off by at most: 1 may look larger, and is exact in half.
constexpr double kCoarsest = 1e-4;
/// What parabolas between its places do not know of a dense lattice's error: over 48 tables of E
/// and B, four mappings, two grids, sides of 64 to 768 (there beside cells 3 % apart, else all),
/// the bound was between 0.960 and 1.029 of the largest error.
constexpr double kMissed = 1.05;

/// Of the first look at a table: most that are too small show it at the ends of their axes.
constexpr double kFirstGrowth = 4;
/// Lookups of what is constant along an axis differ by the rounding of float under its mappings.
constexpr double kRounding = 1e-7;

struct Pixel {
    PixelType type;
    std::uint64_t bytes;
};

std::vector<Pixel> pixels_of(ImageFormat format) {
    if (format == ImageFormat::png) return {{PixelType::uint8, 1}, {PixelType::uint16, 2}};
    return {{PixelType::half, 2}, {PixelType::float32, 4}};
}

Pixel pixel_of(const JobSpec& job) {
    const std::vector<Pixel> all = pixels_of(job.format);
    return *std::ranges::find(all, job.pixel, &Pixel::type);
}

/// Of the smallest square tables so many are narrowed.
constexpr std::ptrdiff_t kNarrowed = 3;

/// Axes of a table, sizes to come.
using Axes = std::vector<Axis>;

std::vector<Axes> axes_to_try(const JobSpec& job) {
    std::vector<Axes> all{job.axes};
    const bool free = job.layout == JobSpec{}.layout || job.layout == "custom";
    if (!free) return all;
    constexpr Mapping kMappings[] = {Mapping::linear, Mapping::sqrt, Mapping::square};
    for (std::size_t a = 0; a < std::min<std::size_t>(job.axes.size(), 2); ++a) {
        std::vector<Axes> more;
        for (const Axes& axes : all)
            for (const Mapping mapping : kMappings) {
                more.push_back(axes);
                more.back()[a].mapping = mapping;
            }
        all = std::move(more);
    }
    std::vector<Axes> both;
    for (const Grid grid : {Grid::center, Grid::node})
        for (Axes axes : all) {
            for (std::size_t a = 0; a < std::min<std::size_t>(axes.size(), 2); ++a)
                axes[a].grid = grid;
            both.push_back(std::move(axes));
        }
    return both;
}

JobSpec sized(const JobSpec& job, const Axes& axes, std::int64_t size) {
    JobSpec made = job;
    made.integrator = Integrator::quadrature;
    made.precision = Precision::float32;
    // They are of sampling, whose limits would refuse what a table by quadrature never costs.
    made.sample_count = JobSpec{}.sample_count;
    made.target_error.reset();
    made.time_budget_s.reset();
    if (axes != job.axes) made.layout = "custom";
    made.axes = axes;
    for (std::size_t a = 0; a < std::min<std::size_t>(axes.size(), 2); ++a)
        made.resolution[a] = size;
    return made;
}

class Search {
  public:
    Search(const JobSpec& job, double max_error, Backend& native, ThreadPool& pool,
           const Control& control)
        : job_(job), max_error_(max_error), native_(native), pool_(pool) {
        control_.cancelled = control.cancelled;
        control_.progress = [this, &control](const Progress&) { control.progress({done_, {}}); };
    }

    std::optional<Closest> closest() { return std::move(closest_); }

    std::vector<Candidate> run() {
        std::vector<Axes> all = axes_to_try(job_);
        // Square roots of NoV need the smallest tables: what is known early is not searched beyond.
        std::stable_partition(all.begin(), all.end(), [](const Axes& axes) {
            return !axes.empty() && axes[0].mapping == Mapping::sqrt;
        });
        for (std::size_t i = 0; i < all.size(); ++i)
            add_smallest(all[i], [&](double share) {
                done_ = (static_cast<double>(i) + share) / static_cast<double>(all.size());
            });
        if (!judged_ && pole_) throw *pole_;
        sort();
        const std::vector<Candidate> squares(
            found_.begin(),
            found_.begin() + std::min<std::ptrdiff_t>(kNarrowed, std::ssize(found_)));
        for (const Candidate& square : squares) narrow(square);
        sort();
        const auto equal = [](const Candidate& a, const Candidate& b) {
            return a.bytes == b.bytes && a.job.pixel == b.job.pixel &&
                   std::abs(a.total() - b.total()) <= kRounding;
        };
        found_.erase(std::unique(found_.begin(), found_.end(), equal), found_.end());
        return std::move(found_);
    }

  private:
    /// For each pixel type the first size that is within the bound. Stops where even the next size
    /// would be larger than twice the smallest table known: it will not be the answer.
    void add_smallest(const Axes& axes, const std::function<void(double)>& done) {
        std::vector<Pixel> open = pixels_of(job_.format);
        double tried = 0;
        for (const std::int64_t size : kAdvisedSizes) {
            done(tried++ / static_cast<double>(std::size(kAdvisedSizes)));
            const JobSpec made = sized(job_, axes, size);
            std::erase_if(
                open, [&](const Pixel& pixel) { return bytes_of(made, pixel) > 2 * smallest_; });
            if (open.empty()) return;
            double most = 0;
            const std::optional<double> reconstruction = reconstruction_of(made, most);
            if (!reconstruction) return;
            judged_ = true;
            std::erase_if(open, [&](const Pixel& pixel) {
                Candidate candidate = candidate_of(made, pixel, *reconstruction, most);
                note(candidate);
                // Of a larger table these are no less.
                if (candidate.integration + candidate.quantisation > max_error_) return true;
                if (candidate.total() > max_error_) return false;
                smallest_ = std::min(smallest_, candidate.bytes);
                found_.push_back(std::move(candidate));
                return true;
            });
        }
    }

    /// A square table within the bound, with fewer texels along one axis, then along the other.
    void narrow(const Candidate& square) {
        Candidate best = square;
        for (std::size_t a = std::min<std::size_t>(job_.axes.size(), 2); a-- > 0;)
            for (const std::int64_t size : std::views::reverse(kAdvisedSizes)) {
                if (size >= best.job.resolution[a]) continue;
                JobSpec made = best.job;
                made.resolution[a] = size;
                double most = 0;
                const std::optional<double> reconstruction = reconstruction_of(made, most);
                if (!reconstruction) break;
                Candidate candidate = candidate_of(made, pixel_of(best.job), *reconstruction, most);
                if (candidate.total() > max_error_) break;
                best = std::move(candidate);
            }
        if (best.bytes < square.bytes) found_.push_back(std::move(best));
    }

    void sort() {
        std::stable_sort(found_.begin(), found_.end(), [](const Candidate& a, const Candidate& b) {
            return std::tuple(a.bytes, a.total()) < std::tuple(b.bytes, b.total());
        });
    }

    Candidate candidate_of(const JobSpec& made, const Pixel& pixel, double reconstruction,
                           double most) const {
        Candidate candidate{made, bytes_of(made, pixel), integration_bound(most),
                            quantisation_bound(pixel.type, most * (1 - kCoarsest)), reconstruction};
        candidate.job.pixel = pixel.type;
        return candidate;
    }

    void note(const Candidate& candidate) {
        if (closest_ && closest_->table.total() <= candidate.total()) return;
        closest_ = Closest{candidate, worst_channel_, worst_at_};
    }

    std::uint64_t bytes_of(const JobSpec& job, const Pixel& pixel) const {
        std::uint64_t bytes = pixel.bytes * channels_of(job).size();
        for (const std::int64_t n : job.resolution) bytes *= static_cast<std::uint64_t>(n);
        return bytes;
    }

    /// Nothing where a texel stands on a pole: of nodes, where those of centres do not.
    std::optional<double> reconstruction_of(const JobSpec& job, double& most) {
        try {
            return finite_reconstruction_of(job, most);
        } catch (const Error& error) {
            if (error.code() != "non_finite") throw;
            pole_ = error;
            return {};
        }
    }

    /// Coarse lattices first, which find no more than there is: that much where it is enough to
    /// know that no pixel type helps.
    double finite_reconstruction_of(const JobSpec& job, double& most) {
        double worst = 0;
        const auto judge = [&](const Lattice& lattice, auto error_of) {
            const double tolerance = std::clamp(kShareOfBound * max_error_, kFinest, kCoarsest);
            const Table exact = exact_table(lattice.job(), tolerance, native_, pool_, control_);
            worst = 0;
            for (std::size_t p = 0; p < exact.planes.size(); ++p) {
                const std::vector<float>& plane = exact.planes[p];
                if (const double error = error_of(lattice, plane); !(error < worst)) {
                    worst = error;
                    worst_channel_ = exact.channels[p];
                    worst_at_ = lattice.worst_place(plane);
                }
                for (const float value : plane)
                    most = std::max(most, std::abs(static_cast<double>(value)));
            }
        };
        const auto seen = [](const Lattice& lattice, const std::vector<float>& plane) {
            return lattice.reconstruction_max(plane);
        };
        for (const double growth : {kFirstGrowth, Lattice::kFine}) {
            judge(Lattice(job, growth), seen);
            if (worst > max_error_) return worst;
        }
        judge(Lattice::dense(job), [](const Lattice& lattice, const std::vector<float>& plane) {
            return kMissed * lattice.reconstruction_bound(plane);
        });
        return worst;
    }

    const JobSpec& job_;
    const double max_error_;
    Backend& native_;
    ThreadPool& pool_;
    Control control_;
    double done_ = 0;  ///< of all axes and sizes
    std::vector<Candidate> found_;
    std::uint64_t smallest_ = std::uint64_t{1} << 60;
    bool judged_ = false;
    std::string worst_channel_;  ///< of the last reconstruction_of()
    std::vector<double> worst_at_;
    std::optional<Closest> closest_;
    std::optional<Error> pole_;
};

}  // namespace

std::vector<PixelType> advised_pixels(ImageFormat format) {
    std::vector<PixelType> types;
    for (const Pixel& pixel : pixels_of(format)) types.push_back(pixel.type);
    return types;
}

double quantisation_bound(PixelType pixel, double most) {
    switch (pixel) {
        case PixelType::uint8:
            return 0.5 / 255;
        case PixelType::uint16:
            return 0.5 / 65535;
        case PixelType::half:
            // Half a unit in the last of 11 digits; 1 itself is exact.
            return std::ldexp(1.0, std::ilogb(std::max(most, 6e-5) * (1 - 1e-9)) - 11);
        case PixelType::float32:
        case PixelType::rgb9e5:  // of measured kinds, which have no such figure
            return std::ldexp(1.0, std::ilogb(std::max(most, 1e-30) * (1 - 1e-9)) - 24);
    }
    __builtin_unreachable();
}

std::vector<Candidate> advise(const JobSpec& job, double max_error, Backend& native,
                              ThreadPool& pool, const Control& control,
                              std::optional<Closest>* closest) {
    Search search(job, max_error, native, pool, control);
    std::vector<Candidate> found = search.run();
    if (closest != nullptr) *closest = search.closest();
    return found;
}

}  // namespace kiln
