// SPDX-License-Identifier: Apache-2.0
// Jobs that nobody wrote survive their canonical form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "server/spec/channels.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

template <JobEnum E>
E any(std::mt19937_64& random) {
    return static_cast<E>(random() % words<E>().size());
}

Axis any_axis(std::mt19937_64& random, Parameter parameter) {
    std::uniform_real_distribution<double> unit(0, 1);
    Axis axis{parameter, any<Mapping>(random), any<Grid>(random), random() % 2 == 0, 0, 1};
    if (random() % 2 == 0) {
        const double a = unit(random), b = unit(random);
        if (a != b) axis.lo = std::min(a, b), axis.hi = std::max(a, b);
    }
    return axis;
}

/// Any lobe that makes sense, and numbers for the models that the job reads.
void any_models(std::mt19937_64& random, JobSpec& job) {
    job.distribution = any<Distribution>(random);
    const bool charlie = job.distribution == Distribution::charlie;
    const bool ggx = job.distribution == Distribution::ggx;
    const auto from = [&](int first, int count) {
        return first + static_cast<int>(random() % static_cast<unsigned>(count));
    };
    job.masking = static_cast<Masking>(charlie ? from(5, 2) : from(0, ggx ? 5 : 2));
    job.importance = static_cast<Importance>(ggx ? from(0, 4) : charlie ? from(2, 2) : from(1, 3));
    if (job.masking == Masking::charlie) job.terminator_softening = random() % 2 == 0;
    const auto read = [&](bool (*reads)(Quantity)) {
        return std::any_of(job.quantities.begin(), job.quantities.end(), reads);
    };
    if (read(reads_fresnel)) {
        job.fresnel.model = static_cast<Fresnel>(from(0, 5));
        if (job.fresnel.model == Fresnel::schlick) job.fresnel.exponent = 1 + from(0, 9) / 8.0;
        if (job.fresnel.model == Fresnel::schlick) job.fresnel.f0 = {from(0, 100) / 128.0};
        if (job.fresnel.model == Fresnel::conductor) job.fresnel.metal = any<Metal>(random);
    }
    if (read(reads_diffuse)) {
        job.diffuse.model = static_cast<DiffuseModel>(from(1, 9));
        job.diffuse.albedo = {from(0, 100) / 128.0};
    }
}

/// Any valid job; those of one axis and of custom layouts come up often.
JobSpec any_job(std::mt19937_64& random) {
    JobSpec job;
    const bool flat = random() % 4 == 0;
    std::vector<Quantity> all;
    for (std::size_t i = 0; i < words<Quantity>().size(); ++i)
        all.push_back(static_cast<Quantity>(i));
    std::shuffle(all.begin(), all.end(), random);
    job.format = any<ImageFormat>(random);
    // A metal makes three channels of a quantity.
    const std::size_t most = job.format == ImageFormat::png ? 1 : all.size();
    all.resize(1 + random() % most);
    job.quantities = flat ? std::vector{Quantity::average_albedo} : all;
    const auto size = [&] { return static_cast<std::int64_t>(1 + random() % 4096); };
    job.resolution = flat ? std::vector{size()} : std::vector{size(), size()};
    job.axes = {{.parameter = Parameter::NoV}, {.parameter = Parameter::roughness}};
    if (flat) job.axes.erase(job.axes.begin());
    if (random() % 2 == 0) {
        const Parameter rough = random() % 2 == 0 ? Parameter::roughness : Parameter::alpha;
        const auto kiln_axes = job.axes;
        job.axes = {any_axis(random, rough)};
        if (!flat) job.axes.push_back(any_axis(random, Parameter::NoV));
        if (!flat && random() % 2 == 0) std::swap(job.axes[0], job.axes[1]);
        job.layout = job.axes == kiln_axes ? "kiln" : "custom";
    }
    job.sample_count = static_cast<std::int64_t>(1 + random() % 1192);  // within the work of 4096²
    job.sampler = any<Sampler>(random);
    any_models(random, job);
    job.precision = any<Precision>(random);
    job.device = any<DeviceChoice>(random);
    job.seed = random() >> (11 + random() % 53);  // of any length up to 53 bits
    const bool first = random() % 2 == 0;
    job.pixel = job.format == ImageFormat::png ? (first ? PixelType::uint8 : PixelType::uint16)
                                               : (first ? PixelType::half : PixelType::float32);
    return job;
}

// KILN_FUZZ_ROUNDS=100000 is the long form.
TEST(Jobs, RandomJobsRoundTrip) {
    const char* given = std::getenv("KILN_FUZZ_ROUNDS");
    const std::uint64_t rounds = given != nullptr ? std::strtoull(given, nullptr, 10) : 10000;
    std::mt19937_64 random(20240229);
    std::size_t custom_count = 0, flat_count = 0;
    for (std::uint64_t i = 0; i < rounds; ++i) {
        const JobSpec job = any_job(random);
        custom_count += job.layout == "custom";
        flat_count += job.axes.size() == 1;
        const std::string text = canonical(job);
        const JobSpec again = parse_job(text);
        ASSERT_EQ(again, job) << text;
        ASSERT_EQ(canonical(again), text);
    }
    EXPECT_GE(custom_count, rounds * 2 / 5);
    EXPECT_GE(flat_count, rounds / 5);
}

}  // namespace
}  // namespace kiln
