// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

#include "tests/reference/lobe.h"

namespace kiln::reference {
namespace {

// Over 3000 random points down to NoV, alpha = 1e-9 two orders within 1e-8 left at most 2e-11 in
// the finer.
constexpr double kTableAgreement = 1e-8;

/// Calls row(index) for every index below row_count on several threads; the first failure is thrown
/// here.
template <class Row>
void for_each_row(std::size_t row_count, unsigned thread_count, const Row& row) {
    if (thread_count == 0) thread_count = std::max(1U, std::thread::hardware_concurrency());
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::exception_ptr failure;
    const auto work = [&] {
        try {
            for (std::size_t index = next++; index < row_count; index = next++) row(index);
        } catch (...) {
            const std::lock_guard lock(mutex);
            failure = std::current_exception();
            next = row_count;
        }
    };
    std::vector<std::jthread> helpers;
    for (unsigned i = 1; i < thread_count && i < row_count; ++i) helpers.emplace_back(work);
    work();
    helpers.clear();
    if (failure) std::rethrow_exception(failure);
}

double value(Quantity quantity, Masking masking, double NoV, double alpha) {
    switch (quantity) {
        case Quantity::scale:
            return split_sum_to(NoV, alpha, masking, kTableAgreement).scale;
        case Quantity::bias:
            return split_sum_to(NoV, alpha, masking, kTableAgreement).bias;
        case Quantity::directional:
            return directional_albedo_to(NoV, alpha, masking, kTableAgreement);
        case Quantity::multiscatter:
            return cheaper_deficit(NoV, alpha, masking, 1e-4);
        case Quantity::average:
            break;
    }
    return average_albedo(alpha, masking);
}

}  // namespace

std::vector<double> table(Quantity quantity, Masking masking, std::span<const double> NoV,
                          std::span<const double> alpha, unsigned thread_count) {
    std::vector<double> values(NoV.size() * alpha.size());
    for_each_row(alpha.size(), thread_count, [&](std::size_t row) {
        const auto begin = values.begin() + static_cast<std::ptrdiff_t>(row * NoV.size());
        if (quantity == Quantity::average) {
            std::fill_n(begin, NoV.size(), value(quantity, masking, 1, alpha[row]));
            return;
        }
        std::transform(NoV.begin(), NoV.end(), begin,
                       [&](double mu) { return value(quantity, masking, mu, alpha[row]); });
    });
    return values;
}

std::vector<SplitSum> split_sum_table(Masking masking, std::span<const double> NoV,
                                      std::span<const double> alpha, unsigned thread_count) {
    std::vector<SplitSum> values(NoV.size() * alpha.size());
    for_each_row(alpha.size(), thread_count, [&](std::size_t row) {
        for (std::size_t i = 0; i < NoV.size(); ++i)
            values[row * NoV.size() + i] =
                split_sum_to(NoV[i], alpha[row], masking, kTableAgreement);
    });
    return values;
}

}  // namespace kiln::reference
