# SPDX-License-Identifier: Apache-2.0
find_program(PYTHON3 python3 REQUIRED)

# kiln_service_test(SCRIPT): SCRIPT_test.py of this folder against the built kilnd, with nothing beside
# Python's standard library.
function(kiln_service_test script)
  add_test(NAME service.${script}
    COMMAND ${PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/${script}_test.py)
  set(environment "KILND=$<TARGET_FILE:kilnd>" "KILN_SCRATCH=${PROJECT_BINARY_DIR}"
    "CLFAULT_LIBRARY=$<TARGET_FILE:clfault>" "KILN_HOSTILE_SCENES=$<TARGET_FILE:write_hostile_scenes>"
    "PYTHONPATH=${PROJECT_SOURCE_DIR}/tests/http:${PROJECT_SOURCE_DIR}/examples/measured"
    "PYTHONDONTWRITEBYTECODE=1")
  set_tests_properties(service.${script} PROPERTIES TIMEOUT 300 ENVIRONMENT "${environment}")
endfunction()
