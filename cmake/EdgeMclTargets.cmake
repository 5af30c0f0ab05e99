# What every target of the project shares.

add_library(edge_mcl_build_flags INTERFACE)
target_compile_options(edge_mcl_build_flags INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor)
if(EDGE_MCL_WERROR)
  target_compile_options(edge_mcl_build_flags INTERFACE -Werror)
endif()
# Functions of a shared library are not replaced from outside, so calls within it may be inlined.
target_compile_options(edge_mcl_build_flags INTERFACE -fno-semantic-interposition)
# An inline function of a header is compiled into every library and program. Without this a program's
# copy, which may be less optimised, would replace the library's.
target_compile_options(edge_mcl_build_flags INTERFACE -fvisibility-inlines-hidden)
# One result whatever the optimiser does: no contraction of a*b+c behind the reader's back.
target_compile_options(edge_mcl_build_flags INTERFACE -ffp-contract=off)
if(EDGE_MCL_SANITIZE STREQUAL "address")
  target_compile_options(edge_mcl_build_flags INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=undefined -fsanitize-recover=alignment
    -fno-omit-frame-pointer -g)
  target_link_options(edge_mcl_build_flags INTERFACE -fsanitize=address,undefined)
elseif(EDGE_MCL_SANITIZE STREQUAL "thread")
  target_compile_options(edge_mcl_build_flags INTERFACE -fsanitize=thread -fno-omit-frame-pointer -g)
  target_link_options(edge_mcl_build_flags INTERFACE -fsanitize=thread)
elseif(EDGE_MCL_SANITIZE)
  message(FATAL_ERROR "EDGE_MCL_SANITIZE is OFF, address or thread, not ${EDGE_MCL_SANITIZE}")
endif()

# Headers lie beside their sources and are included as <edge_mcl/ROOM/...>, in the tree as after
# installation.
set(EDGE_MCL_INCLUDE_TREE "${CMAKE_CURRENT_BINARY_DIR}/edge_mcl_include")
file(MAKE_DIRECTORY "${EDGE_MCL_INCLUDE_TREE}/edge_mcl")

function(edge_mcl_library target room)
  file(CREATE_LINK "${CMAKE_CURRENT_SOURCE_DIR}" "${EDGE_MCL_INCLUDE_TREE}/edge_mcl/${room}"
    SYMBOLIC)
  add_library(edge_mcl::${target} ALIAS ${target})
  target_include_directories(${target} PUBLIC
    "$<BUILD_INTERFACE:${EDGE_MCL_INCLUDE_TREE}>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  target_compile_features(${target} PUBLIC cxx_std_17)
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:edge_mcl_build_flags>)
  set_target_properties(${target} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION 0 INSTALL_RPATH "$ORIGIN")
  install(TARGETS ${target} EXPORT edge_mclTargets
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT dev
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  # A header whose first line says "Internal." is not installed.
  file(GLOB_RECURSE headers RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}" CONFIGURE_DEPENDS "*.h")
  foreach(header ${headers})
    file(STRINGS "${header}" first_line LIMIT_COUNT 1)
    if(NOT first_line MATCHES "Internal\\.")
      get_filename_component(folder "${header}" DIRECTORY)
      install(FILES "${header}"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/edge_mcl/${room}/${folder}" COMPONENT dev)
    endif()
  endforeach()
endfunction()

# Headers of other libraries take most of the compiler's time, so each target reads them once.
function(edge_mcl_precompile target)
  if(NOT EDGE_MCL_PCH OR EDGE_MCL_SANITIZE OR EDGE_MCL_FUZZ)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE ${ARGN})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -fpch-preprocess)  # ccache needs it
  endif()
endfunction()
# Uses the precompiled header of another target of the same kind and options.
function(edge_mcl_precompile_as target other)
  if(EDGE_MCL_PCH AND NOT EDGE_MCL_SANITIZE AND NOT EDGE_MCL_FUZZ)
    target_precompile_headers(${target} REUSE_FROM ${other})
    set_target_properties(${target} ${other} PROPERTIES DEFINE_SYMBOL "")
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE -fpch-preprocess)
    endif()
  endif()
endfunction()

# For nodes, tools and tests: they call libraries and compute nothing themselves. Most of their compile
# time is the optimisation of other libraries' templates, which gains nothing there.
function(edge_mcl_shell target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()
set(EDGE_MCL_PCH_CORE <algorithm> <array> <cmath> <functional> <map> <memory> <optional> <sstream> <string>
  <vector> <Eigen/Geometry> <opencv2/core.hpp> <tbb/parallel_for.h>)
