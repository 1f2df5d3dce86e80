# `cpack` writes cosplat.deb: the command with its viewer, the plug-ins, the C header and the manual
# pages. The static libraries and their headers are a component of their own, which is left out.
# Configure with the preset `deb`, whose prefix is /usr: paths of plug-ins follow from it.

# Manual pages of the command and its subcommands, from what their --help says.
set(man_folder ${PROJECT_BINARY_DIR}/man)
add_custom_command(
  OUTPUT ${man_folder}/cosplat.1
  COMMAND ${CMAKE_COMMAND} -DCOMMAND=$<TARGET_FILE:cosplat> -DFOLDER=${man_folder}
          -DVERSION=${PROJECT_VERSION} -P ${PROJECT_SOURCE_DIR}/cmake/ManPages.cmake
  DEPENDS cosplat ${PROJECT_SOURCE_DIR}/cmake/ManPages.cmake
  COMMENT "Manual pages")
if(NOT COSPLAT_SANITIZE)
  add_custom_target(cosplat_man ALL DEPENDS ${man_folder}/cosplat.1)
  install(DIRECTORY ${man_folder}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME cosplat)
set(CPACK_PACKAGE_VENDOR CoSplat)
# Who builds it, as Debian's tools are told. Without that it is a package for this machine only.
set(CPACK_PACKAGE_CONTACT "The CoSplat authors <cosplat@localhost>")
if(DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
  set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Head avatars and scenes of Gaussian splats")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
  "Trains head avatars from tracked video and static scenes from photographs, shows them, and plays
avatars inside other programs: a C library, a GStreamer element, a source for OBS, a Python module.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME cosplat)
set(CPACK_DEBIAN_RUNTIME_FILE_NAME cosplat.deb)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# The plug-ins' own library, which is in the package.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/avatar/plugin)
# The viewer's window, and what single commands run.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libgl1-mesa-dri")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "colmap, nodejs, npm, chromium, obs-studio, python3")
include(CPack)
