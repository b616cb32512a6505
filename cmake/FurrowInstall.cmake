# The installed package: find_package(furrow CONFIG [COMPONENTS runtime|gl|tool ...]), or pkg-config for furrow.h and libfurrow.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(furrow_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/furrow)
set(FURROW_COMPONENTS)

# furrow_install(component target...): installs targets as furrow::EXPORT_NAME, to be found with the component.
macro(furrow_install component)
  install(TARGETS ${ARGN} EXPORT furrow_${component})
  install(EXPORT furrow_${component} NAMESPACE furrow:: FILE furrow_${component}.cmake DESTINATION ${furrow_package_dir})
  list(APPEND FURROW_COMPONENTS ${component})
endmacro()

furrow_install(runtime furrow_runtime furrow_shared)
install(DIRECTORY runtime/include/furrow DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES runtime/shaders/furrow_shade.glsl DESTINATION ${CMAKE_INSTALL_DATADIR}/furrow/shaders)
file(RELATIVE_PATH furrow_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" furrow_prefix "${furrow_prefix}")
configure_file(cmake/furrow.pc.in ${PROJECT_BINARY_DIR}/furrow.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/furrow.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
if(FURROW_BUILD_GL)
  furrow_install(gl furrow_gl)
  install(DIRECTORY runtime/gl/include/furrow DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endif()
if(FURROW_BUILD_EDITOR)
  furrow_install(tool furrow)
  install(TARGETS furrow-editor furrow_content)  # the editor's samples
  install(TARGETS furrow_images LIBRARY DESTINATION lib/furrow)  # where the tool looks for it, whatever CMAKE_INSTALL_LIBDIR
  install(FILES cmake/FurrowAddAsset.cmake DESTINATION ${furrow_package_dir})
endif()

configure_package_config_file(cmake/furrow-config.cmake.in ${PROJECT_BINARY_DIR}/furrow-config.cmake
                              INSTALL_DESTINATION ${furrow_package_dir} PATH_VARS CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/furrow-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/furrow-config.cmake ${PROJECT_BINARY_DIR}/furrow-config-version.cmake
        DESTINATION ${furrow_package_dir})
install(FILES LICENSE NOTICE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})
