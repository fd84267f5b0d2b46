# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where. Programs look for their share beside themselves and the package for its
# libraries, so that the whole prefix may be moved afterwards.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS handoverd handoverctl handover-verify)

# The client library and what it is linked with. Its headers show values only; wire and idl have none here.
install(
  TARGETS handover_client handover_plan_file handover_common handover_wire handover_idl
  EXPORT handoverTargets
  FILE_SET HEADERS)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/handover)
install(EXPORT handoverTargets NAMESPACE handover:: DESTINATION ${package_folder})
configure_package_config_file(
  cmake/handoverConfig.cmake.in ${CMAKE_BINARY_DIR}/handoverConfig.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/handoverConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(
  FILES ${CMAKE_BINARY_DIR}/handoverConfig.cmake ${CMAKE_BINARY_DIR}/handoverConfigVersion.cmake
  DESTINATION ${package_folder})

# The root that PATHs in cells and plans stand on.
set(share ${CMAKE_INSTALL_DATADIR}/handover)
install(DIRECTORY config DESTINATION ${share} PATTERN "*.service" EXCLUDE)
install(DIRECTORY robots DESTINATION ${share} PATTERN tools EXCLUDE)
install(FILES idl/handover.idl DESTINATION ${share}/idl)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
# Not below CMAKE_INSTALL_LIBDIR: systemd reads /usr/lib and /usr/local/lib.
install(FILES config/handoverd.service DESTINATION lib/systemd/system)
