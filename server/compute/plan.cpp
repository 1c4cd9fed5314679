// SPDX-License-Identifier: Apache-2.0
#include "server/compute/plan.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <memory>
#include <sstream>

#include "server/base/error.h"
#include "server/compute/fresnel.h"
#include "server/compute/multiscatter.h"
#include "server/compute/unread.h"
#include "server/spec/layouts.h"

namespace kiln {

namespace {

constexpr int kColourTerms = 7 << kColour, kTransmittedTerms = 7 << kTransmitted;
constexpr int kDiffuseTerms = 7 << kDiffuse | kTransmittedTerms;
constexpr double kSchlickExponent = 5;

Combination one(std::size_t term, double coefficient = 1) {
    Combination combination{};
    combination[term] = coefficient;
    return combination;
}

/// The Fresnel model of a slice: the job's, with the number that lies along z.
FresnelModel fresnel_of_slice(const JobSpec& job, std::size_t slice) {
    FresnelModel fresnel = job.fresnel;
    if (job.axes.size() < 3) return fresnel;
    const double value =
        axis_value(job.axes[2], static_cast<std::int64_t>(slice), job.resolution[2]);
    (job.axes[2].parameter == Parameter::ior ? fresnel.ior : fresnel.f0) = {value};
    return fresnel;
}

class Planner {
  public:
    Planner(const JobSpec& job, const std::function<Averages()>& averages)
        : job_(job), ask_averages_(averages) {
        plan_.channels = channels_of(job);
        slice_count_ = job.axes.size() > 2 ? static_cast<std::size_t>(job.resolution[2]) : 1;
    }

    Plan make() {
        for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
            const Quantity quantity = plan_.channels[c].quantity;
            if (quantity == Quantity::fresnel_average) {
                add_exact(c);
            } else if (!reads_fresnel(quantity)) {
                add(c, 0, slice_count_);
            } else {
                for (std::size_t slice = 0; slice < slice_count_; ++slice) add(c, slice, 1);
            }
        }
        std::stable_sort(plan_.passes.begin(), plan_.passes.end(),
                         [](const Pass& a, const Pass& b) {
                             return std::pair(a.slices[0], a.what.material.averaged) <
                                    std::pair(b.slices[0], b.what.material.averaged);
                         });
        for (Pass& pass : plan_.passes) settle(pass);
        say_what_is_left_out();
        plan_.warnings = layout_warnings(job_);
        if (std::any_of(job_.quantities.begin(), job_.quantities.end(), reads_fresnel))
            warn_of_negative_reflectance();
        return std::move(plan_);
    }

  private:
    void add_exact(std::size_t channel) {
        const JobSpec job = job_;
        const int colour = plan_.channels[channel].colour;
        plan_.exact.push_back({channel, [job, colour](std::size_t slice) {
                                   return fresnel_average(fresnel_of_slice(job, slice), colour);
                               }});
    }

    /// Estevez, Kulla 2017 under the masking of Neubelt, Pettineo 2013, as engines light cloth.
    static JobSpec sheen() {
        JobSpec job;
        job.distribution = Distribution::charlie;
        job.masking = Masking::neubelt;
        job.importance = Importance::uniform;
        return job;
    }

    /// The pass of this kind that fills these slices; a new one where there is none.
    Pass& pass(Lobe lobe, bool averaged, std::size_t slice, std::size_t slice_count) {
        for (Pass& pass : plan_.passes) {
            if (pass.lobe == lobe && (pass.what.material.averaged != 0) == averaged &&
                pass.slices[0] == slice && pass.slices.size() == slice_count)
                return pass;
        }
        Pass made;
        made.lobe = lobe;
        made.what.material = lobe_of(lobe == Lobe::sheen ? sheen() : job_);
        made.what.precision = job_.precision;
        made.points = point_kind(made.what.material);
        if (lobe == Lobe::diffuse) {
            made.what.material = {};
            made.what.material.importance = static_cast<int>(Importance::cosine);
            made.points = job_.diffuse.model == DiffuseModel::ggx_lambert
                              ? PointKind::facet_walk
                              : PointKind::cosine_diffuse;
        }
        made.what.material.averaged = averaged ? 1 : 0;
        made.places = averaged ? Places::averaged(job_) : Places::directional(job_);
        made.slices.clear();
        for (std::size_t s = slice; s < slice + slice_count; ++s) made.slices.push_back(s);
        plan_.passes.push_back(std::move(made));
        return plan_.passes.back();
    }

    void add(std::size_t channel, std::size_t slice, std::size_t count) {
        const Quantity quantity = plan_.channels[channel].quantity;
        const int colour = plan_.channels[channel].colour;
        const auto specular = [&](Combination a, bool averaged = false) {
            pass(Lobe::microfacet, averaged, slice, count).shares.push_back({channel, a, {}, {}});
        };
        const auto diffuse = [&](bool averaged) {
            pass(Lobe::diffuse, averaged, slice, count)
                .shares.push_back(
                    {channel, one(kDiffuse + static_cast<std::size_t>(colour)), {}, {}});
        };
        switch (quantity) {
            case Quantity::split_sum_scale: {
                Combination a = one(kWeight);
                a[kSchlick] = -1;
                return specular(a);
            }
            case Quantity::split_sum_bias:
                return specular(one(kSchlick));
            case Quantity::directional_albedo:
                return specular(one(kWeight));
            case Quantity::average_albedo:
                return specular(one(kWeight), true);
            // ∫ f_ms NoL dω = 1 − E(NoV) exactly (Kulla, Conty 2017). Sampling f_ms by GGX half
            // vectors, as is often done, misses most of it at low roughness.
            case Quantity::multiscatter_albedo:
                return specular(one(kDeficit));
            case Quantity::specular_albedo:
                return specular(reflected(fresnel_of_slice(job_, slice), colour));
            case Quantity::compensated_albedo:
                pass(Lobe::microfacet, false, slice, count)
                    .shares.push_back(compensated(channel, slice, colour));
                return;
            case Quantity::diffuse_albedo:
                return diffuse(false);
            case Quantity::diffuse_average_albedo:
                return diffuse(true);
            case Quantity::total_albedo:
                return add_total(channel, slice, colour);
            case Quantity::sheen_albedo:
                pass(Lobe::sheen, false, slice, count)
                    .shares.push_back({channel, one(kWeight), {}, {}});
                return;
            case Quantity::fresnel_average:
                break;
        }
        __builtin_unreachable();
    }

    /// F(VoH) f NoL / pdf. Without Fresnel it is the weight; Schlick's is F0 A + F90 B, whatever
    /// the colours.
    static Combination reflected(const FresnelModel& fresnel, int colour) {
        const auto channel = static_cast<std::size_t>(colour);
        if (fresnel.model == Fresnel::none) return one(kWeight);
        if (fresnel.model != Fresnel::schlick) return one(kColour + channel);
        const auto of = [&](const std::vector<double>& numbers) {
            return numbers[numbers.size() == 3 ? channel : 0];
        };
        Combination combination = one(kWeight, of(fresnel.f0));
        combination[kSchlick] = of(fresnel.f90) - of(fresnel.f0);
        return combination;
    }

    Share compensated(std::size_t channel, std::size_t slice, int colour) {
        const FresnelModel fresnel = fresnel_of_slice(job_, slice);
        Share share{channel, reflected(fresnel, colour), {}, {}};
        if (job_.multiscatter == Multiscatter::turquin) {
            const double F0 = kiln::fresnel(fresnel, colour, 1.0);
            share.b = one(kWeight);
            share.part = [F0](std::size_t, double S, double E) {
                if (E == 0)
                    throw Error(
                        "non_finite",
                        "Turquin's factor 1 + F0 (1 − E) / E has no value where E is 0, as "
                        "Charlie's is at roughness 0: let the roughness axis start above 0");
                const double scale = turquin_scale(F0, E);
                return Part{S * scale, scale, -S * F0 / (E * E), 0};
            };
        } else if (job_.multiscatter != Multiscatter::none) {
            share.b = one(kDeficit);
            share.part = kulla_conty(fresnel_average(fresnel, colour));
        }
        return share;
    }

    std::function<Part(std::size_t, double, double)> kulla_conty(double F_avg) {
        if (!averages_) averages_ = std::make_shared<const Averages>(ask_averages_());
        const Places places = Places::directional(job_);
        const bool linear = job_.multiscatter == Multiscatter::kulla_conty_linear;
        return [F_avg, linear, places, averages = averages_](std::size_t place, double S,
                                                             double deficit) {
            const std::size_t row = places.averaged_place(place);
            const double missing = averages->deficit[row], error = averages->standard_error[row];
            const double F_ms = multiscatter_fresnel(linear, F_avg, missing);
            const double slope =
                (multiscatter_fresnel(linear, F_avg, missing + 1e-6) - F_ms) / 1e-6;
            const double carried = slope * error * deficit;
            return Part{S + F_ms * deficit, 1, F_ms, carried * carried};
        };
    }

    void add_total(std::size_t channel, std::size_t slice, int colour) {
        const FresnelModel fresnel = fresnel_of_slice(job_, slice);
        const bool lit = job_.diffuse.model != DiffuseModel::none;
        Share specular = compensated(channel, slice, colour);
        Share under{channel, one(kDiffuse + static_cast<std::size_t>(colour)), {}, {}};
        if (job_.coupling == Coupling::kelemen && lit) {
            // ∫ of the matte lobe of Kelemen, Szirmay-Kalos 2001 as in Kulla, Conty 2017 is the
            // albedo times what the specular lobe leaves over, exactly.
            const double rho =
                job_.diffuse
                    .albedo[job_.diffuse.albedo.size() == 3 ? static_cast<std::size_t>(colour) : 0];
            specular.part = [rho, inner = specular.part](std::size_t place, double a, double b) {
                const Part s = inner ? inner(place, a, b) : Part{a, 1, 0, 0};
                const double left = 1 - rho;
                return Part{rho + left * s.value, left * s.by_a, left * s.by_b,
                            left * left * s.variance};
            };
        } else if (job_.coupling == Coupling::view) {
            const Places places = Places::directional(job_);
            const auto F = [fresnel, colour, places](std::size_t place) {
                return kiln::fresnel(fresnel, colour, places.NoV(place));
            };
            specular.a = one(kWeight);
            specular.part = [F](std::size_t place, double a, double) {
                return Part{F(place) * a, F(place), 0, 0};
            };
            under.part = [F](std::size_t place, double a, double) {
                return Part{(1 - F(place)) * a, 1 - F(place), 0, 0};
            };
        } else if (job_.coupling == Coupling::half_vector && job_.fresnel.model != Fresnel::none) {
            under.a = one(kTransmitted + static_cast<std::size_t>(colour));
        }
        pass(Lobe::microfacet, false, slice, 1).shares.push_back(std::move(specular));
        if (lit && job_.coupling != Coupling::kelemen)
            pass(Lobe::diffuse, false, slice, 1).shares.push_back(std::move(under));
    }

    /// Terms, numbers and the kernel's path, once all shares are known.
    void settle(Pass& pass) const {
        KernelMaterial& material = pass.what.material;
        for (const Share& share : pass.shares)
            material.terms |= terms_of(share.a) | terms_of(share.b);
        // A Fresnel term that reflects nothing needs none; there is no kernel without one.
        if (material.terms == 0) material.terms = 1 << kWeight;
        const FresnelModel fresnel = fresnel_of_slice(job_, pass.slices[0]);
        if (material.terms & (kColourTerms | kTransmittedTerms)) {
            material.fresnel = fresnel_function(fresnel);
            for (std::size_t c = 0; c < 3; ++c) {
                const auto numbers = fresnel_parameters(fresnel, static_cast<int>(c));
                std::copy(
                    numbers.begin(), numbers.end(),
                    pass.parameters.begin() + static_cast<std::ptrdiff_t>(c * numbers.size()));
            }
        }
        if (material.terms & kDiffuseTerms) {
            // The kernels have no number for a lobe that is not there.
            material.diffuse =
                static_cast<int>(job_.diffuse.model) - static_cast<int>(DiffuseModel::lambert);
            const auto& albedo = job_.diffuse.albedo;
            for (std::size_t c = 0; c < 3; ++c)
                pass.parameters[kAlbedoParameter + c] = albedo[albedo.size() == 3 ? c : 0];
        }
        const double exponent =
            fresnel.model == Fresnel::schlick ? fresnel.exponent : kSchlickExponent;
        pass.parameters[kExponentParameter] = exponent;
        const bool other_power = (material.terms & 1 << kSchlick) && exponent != kSchlickExponent;
        FresnelModel bias;  // F0 = 0, F90 = 1: what the Schlick term is a mean of
        bias.f0 = {0};
        bias.f90 = {1};
        bias.exponent = exponent;
        pass.mirror = [fresnel, bias](std::size_t term, double NoV) {
            if (term == kWeight) return 1.0;
            if (term == kSchlick) return kiln::fresnel(bias, 0, NoV);
            if (term >= kColour && term < kColour + 3)
                return kiln::fresnel(fresnel, static_cast<int>(term - kColour), NoV);
            return 0.0;
        };
        material.general = is_on_fast_path(material) && !other_power ? 0 : 1;
    }

    bool asks(Quantity quantity) const {
        return std::find(job_.quantities.begin(), job_.quantities.end(), quantity) !=
               job_.quantities.end();
    }

    void say_what_is_left_out() {
        plan_.left_out = unread_fields(job_);
        int terms = 0;
        bool averaged = false, all_slices = false;
        for (const Pass& pass : plan_.passes) {
            terms |= pass.what.material.terms;
            averaged |= pass.what.material.averaged != 0;
            all_slices |= pass.slices.size() > 1;
        }
        const auto leave = [&](const char* what, const char* why) {
            plan_.left_out.push_back({what, why});
        };
        const char* not_asked = "no quantity that was asked for needs it";
        const bool total = asks(Quantity::total_albedo);
        const bool matte =
            total && job_.coupling == Coupling::kelemen && job_.diffuse.model != DiffuseModel::none;
        const bool scaled =
            job_.multiscatter == Multiscatter::turquin &&
            std::any_of(job_.quantities.begin(), job_.quantities.end(), reads_multiscatter);
        if (!(terms & (1 << kSchlick | kColourTerms | kTransmittedTerms)) &&
            !(total && job_.coupling == Coupling::view) && !asks(Quantity::fresnel_average))
            leave("Fresnel term", not_asked);
        const bool compensates = asks(Quantity::compensated_albedo) || total;
        if (!(terms & 1 << kDeficit) && !scaled)
            leave("multiple-scattering term",
                  compensates ? "the job's multiscatter is none" : not_asked);
        if (matte)
            leave("sampling of the diffuse lobe",
                  "under coupling kelemen it returns the albedo of what the specular lobe leaves");
        else if (!(terms & kDiffuseTerms))
            leave("diffuse lobe", not_asked);
        if (averaged && job_.axes.size() > 1)
            leave(
                "averages along NoV",
                "they depend on roughness alone: integrated once for each roughness and repeated");
        if (all_slices)
            leave("quantities without a Fresnel term along z",
                  "they are the same in every slice: integrated once and repeated");
        if (!plan_.exact.empty())
            leave("sampling of fresnel_average", "it depends on the Fresnel model alone: exact");
    }

    /// The formula of f82_tint may be negative; what it gives stays in the table.
    void warn_of_negative_reflectance() {
        for (int c = 0; c < channel_count(job_.fresnel); ++c) {
            std::optional<Excursion> worst;
            FresnelModel model;
            for (std::size_t slice = 0; slice < slice_count_; ++slice) {
                const FresnelModel here = fresnel_of_slice(job_, slice);
                const auto found = fresnel_excursion(here, c);
                if (!found || (worst && worst->least <= found->least)) continue;
                worst = found;
                model = here;
            }
            if (!worst) continue;
            const auto channel = static_cast<std::size_t>(c);
            const double f0 = model.f0[model.f0.size() == 3 ? channel : 0];
            const double f82 = model.f82[model.f82.size() == 3 ? channel : 0];
            std::ostringstream text;
            text << std::setprecision(3) << "fresnel \"f82_tint\", f0 " << f0 << ", f82 " << f82
                 << ": the reflectance is negative for VoH from " << worst->begin << " to "
                 << worst->end << ", least " << worst->least << " at " << worst->at
                 << "; nothing is clamped. With this f0 it is not from f82 = "
                 << std::ceil(1e3 * f82_least(f0)) / 1e3 << " on";
            plan_.warnings.push_back(text.str());
        }
    }

    const JobSpec& job_;
    const std::function<Averages()>& ask_averages_;
    std::shared_ptr<const Averages> averages_;
    std::size_t slice_count_ = 1;
    Plan plan_;
};

}  // namespace

KernelMaterial lobe_of(const JobSpec& job) {
    KernelMaterial material;
    material.distribution = static_cast<int>(job.distribution);
    material.masking = static_cast<int>(job.masking);
    if (job.masking == Masking::charlie && job.terminator_softening)
        material.masking = kCharlieSoftened;
    material.importance = static_cast<int>(job.importance);
    return material;
}

Plan make_plan(const JobSpec& job, const std::function<Averages()>& averages) {
    return Planner(job, averages).make();
}

}  // namespace kiln
