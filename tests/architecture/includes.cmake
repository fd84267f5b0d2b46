# SPDX-License-Identifier: Apache-2.0
# cmake -DROOT=<source tree> -P includes.cmake
# Each large library has one home, and the planning core knows nothing above it.
cmake_minimum_required(VERSION 3.25)

file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/common/*.?pp ${ROOT}/client/*.?pp ${ROOT}/server/*.?pp)
if(NOT sources)
  message(FATAL_ERROR "no sources below ${ROOT}")
endif()
set(bad "")

# only(<what> <include> <home>...): files outside the homes (regular expressions of paths) that include it.
function(only what include)
  list(JOIN ARGN "|" homes)
  foreach(source IN LISTS sources)
    if(source MATCHES "^(${homes})")
      continue()
    endif()
    file(STRINGS ${ROOT}/${source} found REGEX "^[ \t]*#[ \t]*include[ \t]*[<\"](${include})")
    foreach(line IN LISTS found)
      string(APPEND bad "\n${source}: ${line}: ${what}")
    endforeach()
  endforeach()
  set(bad "${bad}" PARENT_SCOPE)
endfunction()

only("Bullet is for server/core/collision" "bt[A-Z]|Bullet|LinearMath/" "server/core/collision/[^/]*\\.cpp$")
only("Qhull is for server/core/decomposition" "libqhull" "server/core/decomposition/[^/]*\\.cpp$")
only("OMPL is for server/core/motion" "ompl/" "server/core/motion/[^/]*\\.cpp$")
only("urdfdom is for server/core/model" "urdf_|console_bridge/" "server/core/model/[^/]*\\.cpp$")
only("assimp is for server/core/model and the verifier" "assimp/"
     "server/core/model/[^/]*\\.cpp$" "client/verify/[^/]*\\.cpp$")
only("YAML is for server/settings" "yaml-cpp/" "server/settings/[^/]*\\.cpp$")
only("DDS is for the wire, the daemon's endpoint and the client library"
     "fast(dds|rtps|cdr)/|handover(PubSubTypes)?\\.h" "common/wire/" "server/dds/" "client/src/")
only("the core knows nothing above it" "wire/|dds/|settings/|runtime/|handover/client/"
     "common/" "client/" "server/dds/" "server/runtime/" "server/settings/" "server/[^/]*$")

if(bad)
  message("${bad}")  # apart: a fatal error's text is wrapped
  message(FATAL_ERROR "includes where they do not belong")
endif()
