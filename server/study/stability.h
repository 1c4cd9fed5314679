// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/compute/engine.h"
#include "server/compute/opencl.h"
#include "server/study/study.h"
#include "server/study/wide.h"

/// What the files of the stability study share; nobody outside includes this.
namespace kiln::stability {

struct Place {
    double NoV = 1, alpha = 1;
};

enum Arithmetic : std::size_t {
    kNativeFloat,
    kOpenClFloat,
    kNativeDouble,
    kOpenClDouble,
    kArithmetics
};
constexpr bool is_double(std::size_t arithmetic) { return arithmetic >= kNativeDouble; }
constexpr bool is_opencl(std::size_t arithmetic) {
    return arithmetic == kOpenClFloat || arithmetic == kOpenClDouble;
}
/// Empty where there is no such backend, or where a value is not made in that arithmetic.
using Readings = std::array<std::optional<double>, kArithmetics>;

/// Units of last place in one rounding, and the least square that keeps its digits.
struct Format {
    double unit, tiny;
    long double half_least;  ///< half of the least number that it holds, a subnormal
    bool single;
    /// What counts as 0: lane_exp2() is 0 below 2^-125 (2^-1021), and what it is multiplied by up
    /// to 1e12 where the squares of its inputs are normal numbers (1e104 in double, at alpha
    /// 1e-40).
    double underflow;
    double rounded(double x) const {
        return single ? static_cast<double>(static_cast<float>(x)) : x;
    }
};
inline constexpr Format kSingle{0x1p-24, 0x1p-63, 0x1p-150L, true, 1e-25},
    kDouble{0x1p-53, 0x1p-511, 0x1p-1075L, false, 1e-200};

/// What is right at inputs as one format holds them, and how far from it a value may lie.
struct Right {
    double value = 0, tolerance = 0;
    /// An infinity that is right as well: the model's pole, where an input is within rounding of
    /// it.
    std::optional<double> pole{};
};

/// One value of one model, beside what it should be. `family` is a heat map, `row` and `column` its
/// place there; `model` has a verdict.
struct Finding {
    std::string family, model, row, column, quantity, input, source;
    std::optional<double> NoV, alpha;
    Right in_float, in_double;
    Readings values;
    double scale = 0;     ///< errors are shown as part of this where the value is below it
    std::string limit{};  ///< what the tolerances are made of

    /// |value − right| of the worst backend; 0 where both are the same infinity, infinite where one
    /// is, and of a NaN beside anything.
    std::optional<double> error_float() const;
    std::optional<double> error_double() const;
    bool passes() const;
    /// The greatest error over its tolerance: at most 1 where it passes.
    double strain() const;
};

/// Findings, of which only the worst of each (family, row, column, quantity) is kept.
class Findings {
  public:
    void add(Finding finding);
    const std::vector<Finding>& all() const { return kept_; }
    std::size_t values() const { return values_; }
    std::vector<Finding> take() { return std::move(kept_); }

  private:
    std::vector<Finding> kept_;
    std::vector<double> strains_;
    std::size_t values_ = 0;
};

/// Kernels to be launched, on every backend that the job may use.
class Bench {
  public:
    Bench(Engine& engine, const JobSpec& job, const Control& control)
        : engine_(engine), job_(job), control_(control) {}

    /// Builds what later launches on OpenCL need, `wide` for those in double, which not every
    /// device has. Throws Error("device_unavailable") where the job names a device that is not
    /// there.
    void open(std::span<const KernelKind> kernels, std::span<const KernelKind> wide);

    using Sums = std::array<std::vector<double>, kArithmetics>;  ///< empty: no such backend
    /// [batch][term asked for, by rising bit][place]
    Sums run(const KernelMaterial& material, const std::array<double, kParameterCount>& parameters,
             std::span<const double> points, std::span<const BatchRange> batches,
             std::span<const Place> places);
    /// [E, 1 − E, B][place], at one order.
    Sums run(Masking masking, std::span<const Place> places);
    /// [E, and B where it has one][place], at as many orders as jobs take. Of `kind` the precision
    /// is passed over.
    Sums run(QuadratureKind kind, const QuadratureParameters& parameters,
             std::span<const Place> places, bool on_opencl);
    /// 1 - E_avg by quadrature in double.
    double average_deficit(Masking masking, double alpha);

    /// Says how far the study is, and throws Cancelled.
    void look(double fraction);
    void look() { look(fraction_); }

    Engine& engine() { return engine_; }
    const JobSpec& job() const { return job_; }
    const Control& control() const { return control_; }
    bool has_opencl() const { return opencl_ != nullptr; }
    bool has_opencl_double() const { return opencl_double_ != nullptr; }
    DeviceReport device() const;
    std::uint64_t evaluations() const { return evaluations_; }

  private:
    template <typename Scalar>
    void launch(Backend& backend, const KernelMaterial& material,
                const std::array<double, kParameterCount>& parameters,
                std::span<const double> points, std::span<const BatchRange> batches,
                std::span<const Place> places, std::vector<double>& sums);

    Engine& engine_;
    const JobSpec& job_;
    const Control& control_;
    /// Calls on(backend, Scalar, precision, arithmetic) for all that are there.
    template <typename On>
    void each(On on);

    std::shared_ptr<OpenClBackend> opencl_, opencl_double_;
    std::string why_not_;
    double fraction_ = 0;
    std::uint64_t evaluations_ = 0;
};

/// A specular lobe with its default sampler; one line of lobes() adds a row everywhere.
struct Lobe {
    Distribution distribution;
    Masking masking;
    bool softened = false;
};
const std::vector<Lobe>& lobes();
std::string name_of(const Lobe& lobe);
JobSpec job_of(const Lobe& lobe);

/// A Fresnel model with its parameters; one line of fresnel_rows() adds a row.
struct FresnelRow {
    std::string name;
    FresnelModel model;
    double at_normal;  ///< F(1)
    double at_grazing = 1;
};
std::vector<FresnelRow> fresnel_rows();

/// What files refuse, as verdicts.
std::vector<Verdict> refused_spikes();

/// "alpha | NoV", powers of two as such.
inline constexpr const char* kPlaceJoint = " | ";
std::string place_column(const Place& place);

/// One part of the study. `programs` are the kernels that it launches on OpenCL in float.
struct Part {
    std::vector<KernelKind> programs;
    std::function<void(Bench&, Findings&)> run;
};
Part fresnel_part();
Part lobes_part();
Part diffuse_part();
Part quadrature_part();
Part sampled_part();
Part diffuse_rules_part();
Part rules_part();
Part facets_part();
Part spikes_part();
Part diffuse_albedo_part();
Part averages_part();
Part couplings_part();

/// Values of one model with one sample each.
struct Pointwise {
    std::string family, model, row;
    KernelMaterial material;
    std::array<double, kParameterCount> parameters{};
    struct Term {
        std::size_t index;
        std::string quantity;
        /// Rounding counts in units of this where the value is below it.
        std::function<double(const Place&)> scale = [](const Place&) { return 0.0; };
    };
    std::vector<Term> terms{};
    std::vector<std::pair<std::string, std::array<double, kPointScalars>>> points{};
    std::vector<Place> places{};
    std::function<std::string(const Place&)> column{};
    /// Rounded operations on the longest way through the model: some 30, their errors of either
    /// sign.
    double forward_units = 32;
    /// A row for each term, named after the model and it.
    bool rows_by_quantity = false;
    /// What is known in closed form, and where from; else long double decides.
    std::function<std::optional<double>(const Place&)> closed{};
    std::string closed_source{};
};
void run(Bench& bench, const Pointwise& pointwise, Findings& findings);
KernelMaterial material_of(const Pointwise& pointwise);

/// What is right of a mean over samples, and what chance and rounding may do to it.
struct Expected {
    double value = 0;
    std::string source{};
    double off = 0;  ///< how far `value` may be off itself
    /// Of the rare events that no replicate saw: how far one is from the mean at most, and all
    /// together. Where that is 0, every sample is the same.
    double greatest = 1, all = 1;
    double rounds_with = 1;    ///< rounding counts in units of this
    bool fifth_power = false;  ///< of a cosine's distance from 1
};
using ExpectedOf = std::function<Expected(std::size_t place, std::size_t term)>;
/// Means over the points of a job's sampler, beside what is right. Tolerance: what replicates agree
/// to, what none of them may have seen, the truth's own error, and the rounding of sums. A value
/// that so many samples cannot tell from 0 is left out.
void run_sampled(Bench& bench, const Pointwise& pointwise, PointKind kind, Findings& findings,
                 const ExpectedOf& expected);

/// "1e-06", "0.5".
std::string plain(double value);

}  // namespace kiln::stability
