# Compiles and links all targets so that errors in memory end the program instead of being exploited.
# Only as the top-level project, whose parent would choose otherwise; sanitizers find more themselves.
# `slipstream_assertions` is for rooms that read files and packets of others.
set(slipstream_hardened FALSE)
set(slipstream_assertions "")
if(NOT PROJECT_IS_TOP_LEVEL OR NOT CMAKE_SYSTEM_NAME STREQUAL "Linux"
   OR NOT CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang" OR CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  return()
endif()
set(slipstream_hardened TRUE)

# Fortified functions need an optimising build.
add_compile_options(-fstack-protector-strong
  "$<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=3>")
add_link_options(LINKER:-z,relro LINKER:-z,now)

if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  add_compile_options(-fcf-protection)

  # The start files and some static libraries of Debian 12 lack the mark, which the linker would then
  # leave out. A system enforces it only if all libraries of a process have it.
  add_link_options(LINKER:-z,ibt LINKER:-z,shstk)
endif()

# Checks each index of std::vector, std::span and std::array. Not in the rooms with kernels, some of
# which index vectors in their inner loops.
set(slipstream_assertions _GLIBCXX_ASSERTIONS)
