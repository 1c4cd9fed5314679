# SPDX-License-Identifier: Apache-2.0
# Concatenates FILES into OUT, each under a #line with its own name.
set(text "")
foreach(path ${FILES})
  get_filename_component(name ${path} NAME)
  file(READ ${path} content)
  string(APPEND text "#line 1 \"kernels/${name}\"\n${content}")
endforeach()
file(WRITE ${OUT} "${text}")
