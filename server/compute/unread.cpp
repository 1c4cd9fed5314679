// SPDX-License-Identifier: Apache-2.0
#include "server/compute/unread.h"

#include <algorithm>
#include <string>

#include "server/spec/channels.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

void add_fresnel(const JobSpec& job, std::vector<LeftOut>& left_out) {
    const auto& asked = job.quantities;
    const bool split_sum = std::any_of(asked.begin(), asked.end(), [](Quantity quantity) {
        return quantity == Quantity::split_sum_scale || quantity == Quantity::split_sum_bias;
    });
    FresnelModel any;
    if (job.fresnel.model == Fresnel::schlick && split_sum) any.exponent = job.fresnel.exponent;
    if (job.fresnel == any || std::any_of(asked.begin(), asked.end(), reads_fresnel)) return;
    left_out.push_back(
        {job.fresnel.model == Fresnel::schlick
             ? "f0 and f90"
             : "fresnel \"" + std::string(to_word(job.fresnel.model)) + "\"",
         split_sum ? "A and B are the two terms of Schlick's model, for any f0 and f90; no other "
                     "quantity that was asked for has a Fresnel term"
                   : "no quantity that was asked for has a Fresnel term"});
}

void add_sampling(const JobSpec& job, std::vector<LeftOut>& left_out) {
    if (job.integrator != Integrator::quadrature) return;
    const JobSpec usual;
    std::string fields;
    const auto add = [&](const char* field, bool set) {
        if (set) fields += (fields.empty() ? "" : ", ") + std::string(field);
    };
    add("sample_count", job.sample_count != usual.sample_count);
    add("sampler", job.sampler != usual.sampler);
    add("importance", job.importance != usual.importance);
    add("seed", job.seed != usual.seed);
    if (!fields.empty()) left_out.push_back({fields, "integrator quadrature draws no samples"});
}

}  // namespace

std::vector<LeftOut> unread_fields(const JobSpec& job) {
    std::vector<LeftOut> left_out;
    add_fresnel(job, left_out);
    add_sampling(job, left_out);
    return left_out;
}

}  // namespace kiln
