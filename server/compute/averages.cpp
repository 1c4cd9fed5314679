// SPDX-License-Identifier: Apache-2.0
#include "server/compute/averages.h"

#include <vector>

#include "server/base/error.h"
#include "server/compute/quadrature.h"

namespace kiln {

namespace {
/// Of the average albedo by quadrature.
constexpr double kExact = 1e-9;

}  // namespace

Averages average_deficits(const JobSpec& job, Backend& native, const Control& control) {
    const Places places = Places::averaged(job);
    std::vector<double> alpha;
    for (std::size_t i = 0; i < places.count(); ++i) alpha.push_back(places.alpha(i));
    const auto between = [&] {
        control.progress({});
        if (control.cancelled()) throw Cancelled();
    };
    return {quadrature_averages(native, quadrature_average_kind(lobe_of(job)), {}, alpha, kExact,
                                between)
                .mean};
}

}  // namespace kiln
