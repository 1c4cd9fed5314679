// SPDX-License-Identifier: Apache-2.0
#include "server/spec/channels.h"

#include <algorithm>
#include <tuple>

#include "server/spec/words.h"

namespace kiln {

bool reads_fresnel(Quantity quantity) {
    return quantity == Quantity::specular_albedo || quantity == Quantity::compensated_albedo ||
           quantity == Quantity::fresnel_average || quantity == Quantity::total_albedo;
}

bool reads_diffuse(Quantity quantity) {
    return quantity == Quantity::diffuse_albedo || quantity == Quantity::diffuse_average_albedo ||
           quantity == Quantity::total_albedo;
}

bool reads_lobe(Quantity quantity) {
    return quantity != Quantity::diffuse_albedo && quantity != Quantity::diffuse_average_albedo &&
           quantity != Quantity::fresnel_average && quantity != Quantity::sheen_albedo;
}

bool reads_multiscatter(Quantity quantity) {
    return quantity == Quantity::compensated_albedo || quantity == Quantity::total_albedo;
}

bool depends_on_NoV(Quantity quantity) {
    return quantity != Quantity::average_albedo && quantity != Quantity::fresnel_average &&
           quantity != Quantity::diffuse_average_albedo;
}

int channel_count(const FresnelModel& model) {
    const auto most = [](auto... sizes) { return static_cast<int>(std::max({sizes...})); };
    switch (model.model) {
        case Fresnel::none:
            return 1;
        case Fresnel::schlick:
            return most(model.f0.size(), model.f90.size());
        case Fresnel::dielectric:
            return most(model.ior.size());
        case Fresnel::conductor:
            return model.metal ? 3 : most(model.eta.size(), model.k.size());
        case Fresnel::edge_tint:
            return most(model.reflectivity.size(), model.edge_tint.size());
        case Fresnel::f82_tint:
            return most(model.f0.size(), model.f82.size());
    }
    __builtin_unreachable();
}

namespace {
/// A dielectric seen from inside, in any channel or slice, or a conductor that is one.
bool reflects_totally(const JobSpec& job) {
    const auto& [eta, k] = std::tie(job.fresnel.eta, job.fresnel.k);
    for (std::size_t c = 0; c < 3 && !eta.empty() && !k.empty(); ++c)
        if (eta[eta.size() > 1 ? c : 0] < 1 && k[k.size() > 1 ? c : 0] == 0)
            return job.fresnel.model == Fresnel::conductor;
    if (job.fresnel.model != Fresnel::dielectric) return false;
    const auto& ior = job.fresnel.ior;
    if (job.axes.size() > 2 && job.axes[2].parameter == Parameter::ior) return job.axes[2].lo < 1;
    return std::any_of(ior.begin(), ior.end(), [](double n) { return n < 1; });
}
}  // namespace

std::optional<std::string> quadrature_lacks(const JobSpec& job, Quantity quantity) {
    const auto quoted = [](std::string_view word) { return '"' + std::string(word) + '"'; };
    if (quantity == Quantity::fresnel_average) return {};  // exact
    const bool total = quantity == Quantity::total_albedo;
    const bool exact = job.coupling == Coupling::kelemen && total;
    // Chan's bound of 1 on f is a fold, along a curve.
    const bool folded = job.diffuse.model == DiffuseModel::chan2018;
    if (reads_diffuse(quantity) && folded && !exact)
        return "diffuse " + quoted(to_word(job.diffuse.model)) + ", which " +
               quoted(to_word(quantity)) + " reads";
    if (reads_diffuse(quantity) && !total) return {};
    const bool under =
        total && job.coupling == Coupling::half_vector && job.diffuse.model != DiffuseModel::none;
    if (under && reflects_totally(job))
        return "a diffuse lobe under an index below 1 by coupling \"half_vector\": total "
               "reflection "
               "begins at a kink across its rule";
    return {};
}

std::vector<Channel> channels_of(const JobSpec& job) {
    std::vector<Channel> channels;
    for (const Quantity quantity : job.quantities) {
        const std::string word(to_word(quantity));
        const bool coloured = (reads_fresnel(quantity) && channel_count(job.fresnel) == 3) ||
                              (reads_diffuse(quantity) && job.diffuse.albedo.size() == 3);
        if (!coloured) {
            channels.push_back({quantity, 0, word});
            continue;
        }
        for (int colour = 0; colour < 3; ++colour)
            channels.push_back({quantity, colour, word + "." + "RGB"[colour]});
    }
    return channels;
}

}  // namespace kiln
