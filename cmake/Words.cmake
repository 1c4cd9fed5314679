# SPDX-License-Identifier: Apache-2.0
# The closed sets of a job, from the contract: whoever adds a word there has its enumerator and its
# spelling, and where kernels read the set its number and its line in their dispatch. What is missing
# then, a function of that word, the compiler names.

set(contract ${CMAKE_CURRENT_SOURCE_DIR}/api/openapi.json)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${contract})
file(READ ${contract} contract_text)

# The words of the enum at a path of components/schemas, its steps separated by dots.
function(words_at path out)
  string(REPLACE "." ";" steps "${path}")
  string(JSON words GET "${contract_text}" components schemas ${steps} enum)
  string(REGEX MATCHALL "[a-z0-9_A-Z]+" words "${words}")
  set(${out} ${words} PARENT_SCOPE)
endfunction()

# C++ has other uses for these.
set(enumerator_of_auto automatic)
set(enumerator_of_float float32)

set(sets "")
set(enums "")
macro(closed_set name path)
  words_at(${path} words)
  set(enumerators "")
  set(spellings "")
  foreach(word ${words})
    if(DEFINED enumerator_of_${word})
      list(APPEND enumerators ${enumerator_of_${word}})
    else()
      list(APPEND enumerators ${word})
    endif()
    list(APPEND spellings "\"${word}\"")
  endforeach()
  list(JOIN enumerators ", " enumerators)
  list(JOIN spellings ", " spellings)
  string(APPEND enums "enum class ${name} { ${enumerators} }; // ${path}\n")
  string(APPEND sets " \\\n    set(${name}, ${spellings})")
endmacro()

set(job Job.properties)
closed_set(Kind ${job}.kind)
closed_set(Quantity Quantity)
closed_set(Parameter Axis.properties.parameter)
closed_set(Mapping Axis.properties.mapping)
closed_set(Grid Axis.properties.grid)
closed_set(Integrator ${job}.integrator)
closed_set(Sampler ${job}.sampler)
closed_set(Importance ${job}.importance)
closed_set(Distribution ${job}.microfacet.properties.distribution)
closed_set(Masking ${job}.microfacet.properties.masking)
closed_set(Fresnel ${job}.fresnel.properties.model)
closed_set(Metal ${job}.fresnel.properties.metal)
closed_set(DiffuseModel ${job}.diffuse.properties.model)
closed_set(Coupling ${job}.coupling)
closed_set(Multiscatter ${job}.multiscatter)
closed_set(Precision ${job}.precision)
closed_set(DeviceChoice ${job}.device)
closed_set(ImageFormat Output.properties.format)
closed_set(PixelType Output.properties.pixel)
closed_set(ThetaInBeyond Extrapolation.properties.theta_in)

set(numbers "")
set(rows "")
# Numbers of a set's words for kernels, less `without`, and rows of (NUMBER, word) for a dispatch.
macro(kernel_words prefix path without)
  words_at(${path} words)
  list(REMOVE_ITEM words ${without})
  string(APPEND rows "#define ${prefix}_ROWS(row)")
  set(number 0)
  foreach(word ${words})
    string(TOUPPER ${word} upper)
    string(APPEND numbers "#define ${prefix}_${upper} ${number}\n")
    string(APPEND rows " row(${upper}, ${word})")
    math(EXPR number "${number} + 1")
  endforeach()
  string(APPEND numbers "#define ${prefix}_COUNT ${number}\n")
  string(APPEND rows "\n")
endmacro()

kernel_words(KILN_DISTRIBUTION ${job}.microfacet.properties.distribution "")
kernel_words(KILN_MASKING ${job}.microfacet.properties.masking "")
kernel_words(KILN_IMPORTANCE ${job}.importance "")
kernel_words(KILN_DIFFUSE ${job}.diffuse.properties.model none)

# Written where they differ alone, so that nothing is built again for another change of the contract.
set(KILN_GENERATED ${CMAKE_CURRENT_BINARY_DIR}/generated)
set(head "// From the words of api/openapi.json, in their order, by cmake/Words.cmake.\n")
file(CONFIGURE OUTPUT ${KILN_GENERATED}/server/spec/closed_sets.h
     CONTENT "${head}#pragma once\n\nnamespace kiln {\n\n${enums}\n}\n\n#define KILN_CLOSED_SETS(set)${sets}\n"
     @ONLY)
file(CONFIGURE OUTPUT ${KILN_GENERATED}/kernels/words.h CONTENT "${head}${numbers}${rows}" @ONLY)
include_directories(${KILN_GENERATED})
