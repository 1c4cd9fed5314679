// SPDX-License-Identifier: Apache-2.0
#include "server/spec/words.h"

namespace kiln {
#define KILN_SPELLED(Set, ...)                                   \
    std::span<const std::string_view> words_of(Set) {            \
        static constexpr std::string_view all[] = {__VA_ARGS__}; \
        return all;                                              \
    }
KILN_CLOSED_SETS(KILN_SPELLED)
#undef KILN_SPELLED

std::vector<DiffuseModel> diffuse_lobes() {
    std::vector<DiffuseModel> lobes;
    for (std::size_t i = 0; i < words<DiffuseModel>().size(); ++i) {
        const auto model = static_cast<DiffuseModel>(i);
        if (model != DiffuseModel::none && model != DiffuseModel::ggx_lambert)
            lobes.push_back(model);
    }
    return lobes;
}

}  // namespace kiln
