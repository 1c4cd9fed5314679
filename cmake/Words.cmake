# SPDX-License-Identifier: Apache-2.0
# The words of diffuse.model in the contract, as C sees them. Whoever adds a word there has its number,
# its enumerator, its spelling and its line in the kernels' dispatch: diffuse_WORD() is what is missing.

set(contract ${CMAKE_CURRENT_SOURCE_DIR}/api/openapi.json)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${contract})
file(READ ${contract} text)
string(JSON words GET "${text}" components schemas Job properties diffuse properties model enum)
string(REGEX MATCHALL "[a-z0-9_]+" words "${words}")

set(head "// From the words of diffuse.model in api/openapi.json, in their order.\n")
set(spec "${head}#define KILN_DIFFUSE_WORDS(row)")
set(kernel "${head}")
set(rows "#define KILN_DIFFUSE_ROWS(row)")
set(number 0)
foreach(word ${words})
  string(APPEND spec " row(${word})")
  if(word STREQUAL "none")
    continue()
  endif()
  string(TOUPPER ${word} name)
  string(APPEND kernel "#define KILN_DIFFUSE_${name} ${number}\n")
  string(APPEND rows " row(${name}, ${word})")
  math(EXPR number "${number} + 1")
endforeach()
# Written where they differ alone, so that nothing is built again for another change of the contract.
set(KILN_GENERATED ${CMAKE_CURRENT_BINARY_DIR}/generated)
file(CONFIGURE OUTPUT ${KILN_GENERATED}/server/spec/diffuse_words.h CONTENT "${spec}\n" @ONLY)
file(CONFIGURE OUTPUT ${KILN_GENERATED}/kernels/diffuse_words.h CONTENT "${kernel}${rows}\n" @ONLY)
include_directories(${KILN_GENERATED})
