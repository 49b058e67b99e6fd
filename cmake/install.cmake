# cmake --install: the programs, the libraries with their headers, and what find_package(strake) needs.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(libraries mesh patches primo remesh repair volume objectives optimize cases report)
foreach(name ${libraries} version)
  set_target_properties(strake_${name} PROPERTIES EXPORT_NAME ${name})
  add_library(strake::${name} ALIAS strake_${name})
endforeach()
set_target_properties(strake_options PROPERTIES EXPORT_NAME options)
# Everything: strake::strake.
add_library(strake_everything INTERFACE)
set_target_properties(strake_everything PROPERTIES EXPORT_NAME strake)
list(TRANSFORM libraries PREPEND strake_ OUTPUT_VARIABLE targets)
target_link_libraries(strake_everything INTERFACE ${targets} strake_version)
add_library(strake::strake ALIAS strake_everything)

install(TARGETS ${targets} strake_version strake_options strake_everything EXPORT strake
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/strake)
install(TARGETS strake RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
# Some headers name libraries that users of ours need not know, and are not for them.
foreach(folder core objectives optimize cases report)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/strake FILES_MATCHING
    PATTERN "*.hpp" PATTERN "*_impl.hpp" EXCLUDE PATTERN "nlopt_run.hpp" EXCLUDE PATTERN "restarts.hpp" EXCLUDE PATTERN "json_number.hpp" EXCLUDE
    PATTERN "cases/*" EXCLUDE)
endforeach()
file(GLOB case_headers ${PROJECT_SOURCE_DIR}/cases/*.hpp)  # not those of the examples
install(FILES ${case_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/strake/cases)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/strake)
install(EXPORT strake NAMESPACE strake:: FILE strake-targets.cmake DESTINATION ${package})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/strake-config.cmake.in ${PROJECT_BINARY_DIR}/strake-config.cmake
  INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/strake-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/strake-config.cmake ${PROJECT_BINARY_DIR}/strake-config-version.cmake
  DESTINATION ${package})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(STRAKE_PYTHON)
  set(STRAKE_PYTHON_DIR lib/python3/dist-packages CACHE STRING "where the Python package is installed, below the prefix")
  install(TARGETS strake_python LIBRARY DESTINATION ${STRAKE_PYTHON_DIR}/strake)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/strake DESTINATION ${STRAKE_PYTHON_DIR} PATTERN "__pycache__" EXCLUDE)
endif()
