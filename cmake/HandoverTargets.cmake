# SPDX-License-Identifier: Apache-2.0
# How the project's targets are made, and imported targets for packages that only give variables.

# Flags shared by every target of ours: strict floating point, so that plans repeat to the byte.
add_library(handover_flags INTERFACE)
target_compile_features(handover_flags INTERFACE cxx_std_20)
target_compile_options(handover_flags INTERFACE -ffp-contract=off)
if(HANDOVER_SANITIZE)
  target_compile_options(handover_flags INTERFACE -fsanitize=${HANDOVER_SANITIZE}
                                                  -fno-omit-frame-pointer)
  # Stacks that can be read, at a speed that tests can bear; the presets' build type sets no flags.
  target_compile_options(handover_flags INTERFACE -O1 -g1)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # What a sanitizer adds makes GCC see values that nobody has set.
    target_compile_options(handover_flags INTERFACE -Wno-maybe-uninitialized)
  endif()
  target_link_options(handover_flags INTERFACE -fsanitize=${HANDOVER_SANITIZE})
endif()

if(HANDOVER_FUZZ)
  target_compile_options(handover_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

add_library(handover_warnings INTERFACE)
target_compile_options(handover_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                                                   -Woverloaded-virtual -Wcast-qual)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees overlaps that are not there in "text" + std::string (its bug 105651).
  target_compile_options(handover_warnings INTERFACE -Wno-restrict)
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  # What handover/common/mutex.hpp says of members and functions.
  target_compile_options(handover_warnings INTERFACE -Wthread-safety)
endif()
if(HANDOVER_WARNINGS_AS_ERRORS)
  target_compile_options(handover_warnings INTERFACE -Werror)
endif()

# handover_library(<name> SOURCES <files> [PUBLIC <targets>] [PRIVATE <targets>])
# A static library handover_<name> with alias handover::<name>. Includes are written from server/
# ("core/model/robot_model.hpp"), from common/ ("wire/participant.hpp") or from include/.
function(handover_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(handover_${name} STATIC ${arg_SOURCES})
  add_library(handover::${name} ALIAS handover_${name})
  target_compile_features(handover_${name} PUBLIC cxx_std_20)
  set_target_properties(handover_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_link_libraries(
    handover_${name}
    PUBLIC ${arg_PUBLIC} $<BUILD_INTERFACE:handover_flags>
    PRIVATE ${arg_PRIVATE} $<BUILD_INTERFACE:handover_warnings>)
endfunction()

# handover_program(<name> SOURCES <files> [DEPS <targets>]): an executable in build/bin.
function(handover_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
  target_link_libraries(${name} PRIVATE ${arg_DEPS} handover_flags handover_warnings)
endfunction()

# handover_test(<name> SOURCES <files> [DEPS <targets>] [LABELS <labels>] [TIMEOUT <s>])
# A GoogleTest program; one ctest entry per program. Labels: unit (default), property, oracle, system,
# install, long (only in `./run test --long`).
function(handover_test name)
  if(NOT HANDOVER_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(arg "" "TIMEOUT" "SOURCES;DEPS;LABELS" ${ARGN})
  if(NOT arg_LABELS)
    set(arg_LABELS unit)
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  if(HANDOVER_SANITIZE)
    math(EXPR arg_TIMEOUT "10 * ${arg_TIMEOUT}")
  endif()
  add_executable(${name} ${arg_SOURCES})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_link_libraries(${name} PRIVATE ${arg_DEPS} GTest::gmock GTest::gtest_main handover_flags
                                        handover_warnings)
  target_compile_definitions(${name} PRIVATE HANDOVER_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  # Only for tests that run programs: the others are the same in every build folder, for ccache.
  if(arg_LABELS MATCHES "system|install")
    target_compile_definitions(${name} PRIVATE HANDOVER_BINARY_DIR="${CMAKE_BINARY_DIR}")
  endif()
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES LABELS "${arg_LABELS}" TIMEOUT ${arg_TIMEOUT})
  if(HANDOVER_SANITIZE)
    # new_delete_type_mismatch: Fast DDS's own matter. report_mutex_bugs: GCC 12's runtime misses how its timed
    # mutexes are locked.
    set(known ${PROJECT_SOURCE_DIR}/tests/sanitizers)
    set_property(TEST ${name} PROPERTY ENVIRONMENT_MODIFICATION
      ASAN_OPTIONS=set:new_delete_type_mismatch=0 UBSAN_OPTIONS=set:print_stacktrace=1:halt_on_error=1
      LSAN_OPTIONS=set:suppressions=${known}/lsan.supp TSAN_OPTIONS=set:report_mutex_bugs=0:suppressions=${known}/tsan.supp)
  endif()
endfunction()

# handover_npm_packages(): fetches what package-lock.json beside the caller says, once per lock file, into npm/ of the
# caller's build folder; npm/installed is the file to depend on.
function(handover_npm_packages)
  set(packages ${CMAKE_CURRENT_BINARY_DIR}/npm)
  add_custom_command(
    OUTPUT ${packages}/installed
    COMMAND ${CMAKE_COMMAND} -E make_directory ${packages}
    COMMAND ${CMAKE_COMMAND} -E copy package.json package-lock.json .npmrc ${packages}
    COMMAND ${NPM} --prefix ${packages} ci --ignore-scripts --loglevel=error
    COMMAND ${CMAKE_COMMAND} -E touch ${packages}/installed
    DEPENDS package.json package-lock.json .npmrc
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}
    COMMENT "Fetching npm packages of ${CMAKE_CURRENT_SOURCE_DIR}"
    VERBATIM)
endfunction()
