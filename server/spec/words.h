// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "server/spec/job_spec.h"

namespace kiln {

#define KILN_WORDS_OF(Set, ...) std::span<const std::string_view> words_of(Set);
KILN_CLOSED_SETS(KILN_WORDS_OF)
#undef KILN_WORDS_OF

/// The closed sets that a job document spells as words.
template <class T>
concept JobEnum = std::is_enum_v<T> && requires(T value) {
    words_of(value);
};

/// The words of a closed set, in the order of its enumerators.
template <JobEnum E>
std::span<const std::string_view> words() {
    return words_of(E());
}

template <JobEnum E>
std::string_view to_word(E value) {
    return words<E>()[static_cast<std::size_t>(value)];
}

/// Empty when the set has no such word.
template <JobEnum E>
std::optional<E> from_word(std::string_view word) {
    const auto all = words<E>();
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i] == word) return static_cast<E>(i);
    }
    return std::nullopt;
}

/// The diffuse models that have a value at a pair of directions: all but none and ggx_lambert.
std::vector<DiffuseModel> diffuse_lobes();

}  // namespace kiln
