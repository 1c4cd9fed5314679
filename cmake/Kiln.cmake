# SPDX-License-Identifier: Apache-2.0
# The three shapes that every room of the project is built from.

# What is built for every change: a quarter less time in the compiler than -O2.
set(KILN_OFTEN_BUILT $<$<CONFIG:RelWithDebInfo>:-O1>)

# kiln_room(NAME SOURCES... [LINK libs...] [NUMERIC]): the library kiln_NAME of one folder under server/.
# NUMERIC: what its code computes takes longer than the compiler.
function(kiln_room name)
  cmake_parse_arguments(ARG "NUMERIC" "" "LINK" ${ARGN})
  add_library(kiln_${name} STATIC ${ARG_UNPARSED_ARGUMENTS})
  if(NOT ARG_NUMERIC)
    target_compile_options(kiln_${name} PRIVATE ${KILN_OFTEN_BUILT})
  endif()
  target_include_directories(kiln_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(kiln_${name} PUBLIC ${ARG_LINK})
endfunction()

# What every test reads, parsed once for all of them: a quarter of what the compiler has to do there.
# Not for rooms: what GCC 12 says of its own std::string (GCC bug 105651) it says of precompiled
# headers too, and hides of others.
set(KILN_TEST_HEADERS <algorithm> <array> <cmath> <cstdint> <cstring> <filesystem> <fstream>
                      <functional> <map> <memory> <optional> <random> <string> <string_view>
                      <vector> <gtest/gtest.h>)

# kiln_test(NAME SOURCES... [LINK libs...]): one GoogleTest program, each case known to ctest.
function(kiln_test name)
  cmake_parse_arguments(ARG "" "" "LINK" ${ARGN})
  add_executable(${name} ${ARG_UNPARSED_ARGUMENTS})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${name} PRIVATE KILN_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
                                             KILN_BINARY_DIR="${PROJECT_BINARY_DIR}")
  # -pthread, which comes with OpenEXR, for all alike; -fpch-preprocess is for ccache.
  target_compile_options(${name} PRIVATE ${KILN_OFTEN_BUILT} -pthread
                         $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess
                           -Wno-array-bounds -Wno-stringop-overflow>)
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gtest GTest::gtest_main)
  get_property(first_test GLOBAL PROPERTY KILN_FIRST_TEST)
  if(first_test)
    target_precompile_headers(${name} REUSE_FROM ${first_test})
  else()
    target_precompile_headers(${name} PRIVATE ${KILN_TEST_HEADERS})
    set_property(GLOBAL PROPERTY KILN_FIRST_TEST ${name})
  endif()
  gtest_discover_tests(${name} PROPERTIES TIMEOUT 300 DISCOVERY_TIMEOUT 60)
endfunction()

# kiln_embed(TARGET FILE SYMBOL): FILE's bytes as `extern const std::string_view kiln::embedded::SYMBOL`.
function(kiln_embed target file symbol)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/embedded_${symbol}.cpp)
  add_custom_command(
    OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} -DIN=${file} -DOUT=${out} -DSYMBOL=${symbol} -P ${PROJECT_SOURCE_DIR}/cmake/Embed.cmake
    DEPENDS ${file} ${PROJECT_SOURCE_DIR}/cmake/Embed.cmake
    VERBATIM)
  target_sources(${target} PRIVATE ${out})
endfunction()
