// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "server/compute/thread_pool.h"

namespace kiln {
namespace {

TEST(ThreadPool, HandsOnWhatABodyThrowsAndWorksOn) {
    ThreadPool pool(4);
    for (std::size_t place = 0; place < 1000; place += 7) {
        std::string message;
        try {
            pool.parallel_for(1000, [&](std::size_t i) {
                if (i == place) throw std::runtime_error(std::to_string(i));
            });
        } catch (const std::runtime_error& error) {
            message = error.what();
        }
        ASSERT_EQ(message, std::to_string(place));
        std::atomic<std::size_t> sum = 0;
        pool.parallel_for(1000, [&](std::size_t i) { sum += i; });
        ASSERT_EQ(sum, 499500U);
    }
}

// Every thread throws; one of them is heard, and none is left in the body.
TEST(ThreadPool, HandsOnOneOfMany) {
    ThreadPool pool(4);
    for (int round = 0; round < 100; ++round) {
        std::atomic<int> inside = 0;
        EXPECT_THROW(pool.parallel_for(100,
                                       [&](std::size_t) {
                                           ++inside;
                                           struct Leave {
                                               std::atomic<int>& inside;
                                               ~Leave() { --inside; }
                                           } leave{inside};
                                           throw std::runtime_error("");
                                       }),
                     std::runtime_error);
        ASSERT_EQ(inside, 0);
    }
}

}  // namespace
}  // namespace kiln
