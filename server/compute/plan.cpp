// SPDX-License-Identifier: Apache-2.0
#include "server/compute/plan.h"

#include "server/compute/quantity.h"

namespace kiln {

namespace {

constexpr int kFresnelBit = 2, kDeficitBit = 4;

void add_pass(Plan& plan, const JobSpec& job, bool averaged) {
    Pass pass{{job.masking, job.importance, 0, averaged, job.precision},
              averaged ? Places::averaged(job) : Places{},
              {}};
    for (std::size_t channel = 0; channel < job.quantities.size(); ++channel) {
        if (quantity_row(job.quantities[channel]).averaged != averaged) continue;
        pass.what.terms |= terms_of(job.quantities[channel]);
        pass.channels.push_back(channel);
    }
    if (pass.channels.empty()) return;
    if (!averaged) pass.places = Places::directional(job);
    plan.passes.push_back(std::move(pass));
}

void say_what_is_left_out(Plan& plan, const JobSpec& job) {
    int terms = 0;
    bool averaged = false;
    for (const Pass& pass : plan.passes) {
        terms |= pass.what.terms;
        averaged |= pass.what.averaged;
    }
    if (!(terms & kFresnelBit))
        plan.left_out.push_back({"Fresnel term", "no quantity that was asked for needs it"});
    if (!(terms & kDeficitBit))
        plan.left_out.push_back(
            {"multiple-scattering term", "no quantity that was asked for needs it"});
    if (averaged && job.axes.size() > 1)
        plan.left_out.push_back({"average_albedo along NoV",
                                 "it depends on roughness alone: integrated once for "
                                 "each roughness and repeated"});
}

}  // namespace

Plan make_plan(const JobSpec& job) {
    Plan plan;
    add_pass(plan, job, false);
    add_pass(plan, job, true);
    say_what_is_left_out(plan, job);
    return plan;
}

}  // namespace kiln
