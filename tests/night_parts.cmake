# Nightly tests are in parts. Each ./dev test runs one part, chosen by the number of commits, so that
# as many commits in a row run all.
set(night_parts 5)

# The part, 1 to 5, of a test: by its name, so that it stays in its part. Some names say it. The longest
# ones are placed by hand, so that no part takes much more than ten minutes.
function(night_part_of test part)
  if(test MATCHES "\\.Night([1-5])/")
    set(${part} ${CMAKE_MATCH_1} PARENT_SCOPE)
    return()
  endif()
  if(test STREQUAL "docs.commands.docs/background/dissertation.md")
    set(${part} 4 PARENT_SCOPE)
    return()
  endif()
  if(test MATCHES "^portable\\.")
    set(${part} 1 PARENT_SCOPE)
    return()
  endif()
  string(MD5 digits "${test}")
  string(SUBSTRING "${digits}" 0 4 digits)
  math(EXPR number "0x${digits} % ${night_parts} + 1")
  set(${part} ${number} PARENT_SCOPE)
endfunction()

# Labels tests as nightly: night-1 to night-5.
function(slipstream_nightly)
  foreach(test IN LISTS ARGN)
    night_part_of(${test} part)
    set_property(TEST ${test} APPEND PROPERTY LABELS night-${part})
  endforeach()
endfunction()
