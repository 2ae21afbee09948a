# Whether the Python package is built (plugin/python), and how libraries become a part of its module. AUTO: where
# pybind11 and Python are found, as part of the program's build, without sanitizers.
set(CLOUDCONTACT_PYTHON AUTO CACHE STRING "the Python package: ON, OFF, or AUTO, where pybind11 is found")
set_property(CACHE CLOUDCONTACT_PYTHON PROPERTY STRINGS AUTO ON OFF)
set(with_python OFF)
if(CLOUDCONTACT_PYTHON STREQUAL ON OR (CLOUDCONTACT_PYTHON STREQUAL AUTO AND CLOUDCONTACT_PROGRAM
    AND NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize="))
  # The distribution's Python has the numpy that script/bootstrap installs; others need -DPython_EXECUTABLE.
  if(NOT DEFINED Python_EXECUTABLE AND NOT SKBUILD AND EXISTS /usr/bin/python3)
    set(Python_EXECUTABLE /usr/bin/python3)
  endif()
  find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
  find_package(pybind11 2.10 QUIET CONFIG)
  if(Python_FOUND AND pybind11_FOUND AND CLOUDCONTACT_PROGRAM)
    set(with_python ON)
  elseif(CLOUDCONTACT_PYTHON STREQUAL ON)
    message(FATAL_ERROR "the Python package needs Python's headers, pybind11 and CLOUDCONTACT_PROGRAM; install "
      "python3-dev and pybind11-dev, or set CLOUDCONTACT_PYTHON=OFF")
  else()
    message(STATUS "CloudContact is built without its Python package: pybind11 or Python's headers are not found")
  endif()
endif()

# A static library that the module links. Code for shared libraries is as fast here as other code: functions are
# inlined within a file all the same.
function(cloudcontact_python_part target)
  get_target_property(type ${target} TYPE)
  if(with_python AND type STREQUAL STATIC_LIBRARY)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_compile_options(${target} PRIVATE -fno-semantic-interposition)
  endif()
endfunction()

# Sets a variable to the folder, within the prefix, from which Python imports what is installed there. Debian's Python
# has lib/python3/dist-packages in /usr and lib/python3.11/dist-packages in other prefixes, others site-packages.
function(cloudcontact_python_folder variable)
  execute_process(COMMAND ${Python_EXECUTABLE} -c "import sysconfig; print('deb_system' in sysconfig.get_scheme_names())"
    OUTPUT_VARIABLE debian OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  set(folder lib/python${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}/site-packages)
  if(debian AND CMAKE_INSTALL_PREFIX STREQUAL /usr)
    set(folder lib/python3/dist-packages)
  elseif(debian)
    set(folder lib/python${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}/dist-packages)
  endif()
  set(CLOUDCONTACT_PYTHON_FOLDER ${folder} CACHE STRING "where the Python package is installed, within the prefix")
  set(${variable} ${CLOUDCONTACT_PYTHON_FOLDER} PARENT_SCOPE)
endfunction()
