# What `cmake --install` installs, in four parts that the packages share (Package.cmake): libraries (shared ones),
# development (headers, static libraries, CMake and pkg-config files), program and python (plugin/python/CMakeLists.txt).
include(CMakePackageConfigHelpers)
get_property(components GLOBAL PROPERTY CLOUDCONTACT_COMPONENTS)
set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/CloudContact)
set(pc_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# Headers: all but Bullet's need Eigen alone.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/cloudcontact DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT development FILES_MATCHING PATTERN "*.h" PATTERN bullet EXCLUDE PATTERN bullet.h EXCLUDE)
if(TARGET CloudContact::bullet OR TARGET CloudContact::bullet_double)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/cloudcontact/bullet COMPONENT development
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cloudcontact)
  install(FILES ${PROJECT_SOURCE_DIR}/include/cloudcontact/bullet.h COMPONENT development
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cloudcontact)
endif()
install(FILES ${PROJECT_BINARY_DIR}/include/cloudcontact/version.h COMPONENT development
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cloudcontact)

# pkg-config files find themselves, so that the tree can be moved.
file(RELATIVE_PATH up ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" up "${up}")
set(pc_prefix "\${pcfiledir}/${up}")
foreach(folder libdir includedir)
  string(TOUPPER CMAKE_INSTALL_${folder} place)
  set(pc_${folder} "\${prefix}/${${place}}")
  if(IS_ABSOLUTE "${${place}}")
    set(pc_${folder} "${${place}}")
  endif()
endforeach()
set(about_core "clouds, fields, contacts, haptic tools")
set(about_files "files of meshes, points and volumes")
set(about_device "batches on all cores or an OpenCL device")
set(about_bullet "Bullet's collision shape, in float")
set(about_bullet_double "Bullet's collision shape, in double")

foreach(name ${components})
  install(TARGETS cloudcontact_${name} EXPORT CloudContact-${name}
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT libraries
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libraries NAMELINK_COMPONENT development
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  install(EXPORT CloudContact-${name} NAMESPACE CloudContact:: DESTINATION ${config_folder} COMPONENT development)
  get_property(others GLOBAL PROPERTY CLOUDCONTACT_${name}_NEEDS)
  set(packages "")
  foreach(part ${others} ${name})
    get_property(some GLOBAL PROPERTY CLOUDCONTACT_${part}_PACKAGES)
    list(APPEND packages ${some})
  endforeach()
  list(REMOVE_DUPLICATES packages)
  string(APPEND needs "set(CloudContact_${name}_targets ${others} ${name})\n"
    "set(CloudContact_${name}_packages \"${packages}\")\n")
  # Static libraries are linked before what they need.
  list(TRANSFORM others PREPEND cloudcontact- OUTPUT_VARIABLE pc_requires)
  list(REVERSE pc_requires)
  get_property(modules GLOBAL PROPERTY CLOUDCONTACT_${name}_PC_PUBLIC)
  list(APPEND pc_requires ${modules})
  list(JOIN pc_requires " " pc_requires)
  set(pc_about ${about_${name}})
  string(REPLACE _ - file cloudcontact-${name}.pc)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/component.pc.in ${PROJECT_BINARY_DIR}/${file} @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${file} DESTINATION ${pc_folder} COMPONENT development)
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/CloudContactConfig.cmake.in CloudContactConfig.cmake
  INSTALL_DESTINATION ${config_folder} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(CloudContactConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/CloudContactConfig.cmake ${PROJECT_BINARY_DIR}/CloudContactConfigVersion.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindCloudContactBullet.cmake DESTINATION ${config_folder} COMPONENT development)

if(TARGET cloudcontact)
  set(programs cloudcontact)
  if(TARGET cloudcontact-chart)
    list(APPEND programs cloudcontact-chart)
  endif()
  install(TARGETS ${programs} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  # The program finds shared libraries beside it, wherever the tree is moved to.
  file(RELATIVE_PATH libraries ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  if(BUILD_SHARED_LIBS AND APPLE)
    set_target_properties(${programs} PROPERTIES INSTALL_RPATH "@loader_path/${libraries}")
  elseif(BUILD_SHARED_LIBS)
    set_target_properties(${programs} PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries}")
  endif()
endif()

# Licenses, one copy for each package.
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libcloudcontact-dev
  RENAME copyright COMPONENT development)
if(BUILD_SHARED_LIBS)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libcloudcontact
    RENAME copyright COMPONENT libraries)
endif()
if(TARGET cloudcontact)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/cloudcontact
    RENAME copyright COMPONENT program)
  install(FILES ${PROJECT_SOURCE_DIR}/docs/notices.txt DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/cloudcontact
    COMPONENT program)
endif()

# `uninstall` removes what the last `cmake --install` of this build installed.
if(NOT TARGET uninstall)
  add_custom_target(uninstall COMMENT "Removes what was installed from this build" VERBATIM
    COMMAND ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR} -P ${CMAKE_CURRENT_LIST_DIR}/Uninstall.cmake)
endif()
