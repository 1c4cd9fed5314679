// SPDX-License-Identifier: Apache-2.0
// write_hostile_scenes FOLDER: each hostile scene as a file 0, 1, …, and on standard output a line
// for each: code ("-" where it is to be read), pointer, name, with tabs between.
#include <cstdio>
#include <fstream>

#include "tests/scene/scenes.h"

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    std::size_t index = 0;
    for (const auto& scene : kiln::test::hostile_scenes()) {
        std::ofstream file(argv[1] + ("/" + std::to_string(index++)), std::ios::binary);
        if (!(file << scene.bytes).flush()) return 1;
        std::printf("%s\t%s\t%s\n", scene.code.empty() ? "-" : scene.code.c_str(),
                    scene.pointer.c_str(), scene.name.c_str());
    }
}
