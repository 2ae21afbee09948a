# One test of what is installed: cmake -DSTEP=install|outside|... -P install_step.cmake, with the variables that
# CMakeLists.txt gives. WORK is the tests' folder.
set(prefix ${WORK}/prefix)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${result}: ${command}")
  endif()
endfunction()

# Configures a project outside the tree.
function(configure project name)
  file(REMOVE_RECURSE ${WORK}/${name})
  run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/${project} -B ${WORK}/${name} -G ${GENERATOR}
    -DCMAKE_CXX_COMPILER=${COMPILER} "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" "-DCMAKE_CXX_FLAGS=${FLAGS}" ${ARGN})
endfunction()

# The user's own list of installed files is kept.
function(keep_manifests from to)
  file(GLOB manifests ${from}/install_manifest*.txt)
  foreach(manifest ${manifests})
    file(MAKE_DIRECTORY ${to})
    cmake_path(GET manifest FILENAME name)
    file(RENAME ${manifest} ${to}/${name})
  endforeach()
endfunction()

# Installed into one folder, then moved to another: everything finds itself where it is.
function(step_install)
  file(REMOVE_RECURSE ${WORK})
  keep_manifests(${BUILD} ${WORK}/kept)
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
  keep_manifests(${BUILD} ${WORK}/installed)
  keep_manifests(${WORK}/kept ${BUILD})
  file(GLOB_RECURSE texts ${WORK}/first/*.cmake ${WORK}/first/*.pc ${WORK}/first/*.h)
  foreach(text ${texts})
    file(STRINGS ${text} found REGEX "${SOURCE}|${BUILD}|${WORK}")
    if(found)
      message(FATAL_ERROR "${text} refers to the source, the build or where it was installed: ${found}")
    endif()
  endforeach()
  file(RENAME ${WORK}/first ${prefix})
endfunction()

function(step_outside)
  configure(outside ${COMPONENT} -DCMAKE_PREFIX_PATH=${prefix} -DCOMPONENT=${COMPONENT})
  run(${CMAKE_COMMAND} --build ${WORK}/${COMPONENT})
  run(${CMAKE_COMMAND} -E chdir ${WORK}/${COMPONENT} ./outside)
endfunction()

# The same program by pkg-config alone, without CMake.
function(step_pkg_config)
  file(GLOB_RECURSE module ${prefix}/cloudcontact-core.pc)
  cmake_path(GET module PARENT_PATH modules)
  cmake_path(GET modules PARENT_PATH libraries)
  set(ENV{PKG_CONFIG_PATH} ${modules})
  string(REPLACE _ - module cloudcontact-${COMPONENT})
  execute_process(COMMAND pkg-config --cflags --libs ${module} OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  separate_arguments(own UNIX_COMMAND "${FLAGS}")
  string(REPLACE bullet_double bullet text ${COMPONENT})
  set(bytes 4)
  if(COMPONENT STREQUAL bullet_double)
    set(bytes 8)
  endif()
  set(program ${WORK}/by_pkg_config_${COMPONENT})
  run(${COMPILER} -std=c++17 ${own} -DNUMBER_BYTES=${bytes} -I${CMAKE_CURRENT_LIST_DIR} ${CMAKE_CURRENT_LIST_DIR}/outside/${text}_example.cpp
    -o ${program} ${flags} -Wl,-rpath,${libraries})
  run(${program})
endfunction()

function(step_components)
  configure(together together -DCMAKE_PREFIX_PATH=${prefix} "-DCOMPONENTS=${COMPONENTS}")
endfunction()

# Each header compiles alone.
function(step_headers)
  configure(headers headers -DCMAKE_PREFIX_PATH=${prefix} -DINCLUDE=${prefix}/include)
  run(${CMAKE_COMMAND} --build ${WORK}/headers --parallel 2)
endfunction()

# As a part of another project: it builds with the targets' include paths and standard, and nothing of CloudContact is
# installed. Only the program's own file is compiled: the library would take minutes.
function(step_fetched)
  configure(outside fetched -DSOURCE=${SOURCE} -DCOMPONENT=core)
  set(object outside.dir/core_example.cpp.o)
  if(GENERATOR MATCHES Ninja)
    run(${CMAKE_COMMAND} --build ${WORK}/fetched --target CMakeFiles/${object})
  endif()
  run(${CMAKE_COMMAND} --install ${WORK}/fetched --prefix ${WORK}/fetched/prefix)
  file(GLOB_RECURSE files ${WORK}/fetched/prefix/*)
  if(files)
    message(FATAL_ERROR "installed with another project: ${files}")
  endif()
endfunction()

# Both ways of embedding files give the same bytes.
function(step_embedded)
  foreach(incbin ON OFF)
    configure(embedded embedded_${incbin} -DMODULES=${SOURCE}/cmake -DCLOUDCONTACT_INCBIN=${incbin})
    run(${CMAKE_COMMAND} --build ${WORK}/embedded_${incbin})
    execute_process(COMMAND ${WORK}/embedded_${incbin}/embedded OUTPUT_FILE ${WORK}/embedded_${incbin}.txt
      COMMAND_ERROR_IS_FATAL ANY)
    run(${CMAKE_COMMAND} -E compare_files ${WORK}/embedded_${incbin}.txt ${WORK}/embedded_${incbin}/expected.txt)
  endforeach()
endfunction()

# A command's completion scripts and manual page are installed, and hold a word of its help.
function(check_shell_texts command word)
  foreach(file bash-completion/completions/${command} zsh/site-functions/_${command}
      fish/vendor_completions.d/${command}.fish man/man1/${command}.1)
    file(READ ${prefix}/share/${file} text)
    if(NOT text MATCHES ${word})
      message(FATAL_ERROR "share/${file} does not hold '${word}'")
    endif()
  endforeach()
endfunction()

function(step_program)
  run(${prefix}/bin/cloudcontact --version)
  run(${prefix}/bin/cloudcontact digitize sphere:0.01 --voxel 0.001 --json)
  if(NOT FLAGS MATCHES "-fsanitize=")
    check_shell_texts(cloudcontact simulate)
  endif()
endfunction()

# The package is imported from where it is installed, types with it, and its command finds it there. Python leaves
# compiled files there, which uninstalling removes.
function(step_python)
  unset(ENV{PYTHONDONTWRITEBYTECODE})
  set(package ${prefix}/${FOLDER}/cloudcontact)
  foreach(file __init__.py _core.pyi py.typed study/command.py)
    if(NOT EXISTS ${package}/${file})
      message(FATAL_ERROR "${package} has no ${file}")
    endif()
  endforeach()
  run(${prefix}/bin/cloudcontact-study --version)
  set(ENV{PYTHONPATH} ${prefix}/${FOLDER})
  run(${PYTHON} -c "import cloudcontact as cc; assert cc.__file__ == '${package}/__init__.py'\;\
assert cc.digitize('sphere:0.01', 0.001).volume > 4e-6")
  if(NOT EXISTS ${package}/study/__pycache__)
    message(FATAL_ERROR "Python compiled nothing in ${package}")
  endif()
  check_shell_texts(cloudcontact-study summary)
endfunction()

# Nothing is left but the folders that every prefix has.
function(step_uninstall)
  file(RENAME ${prefix} ${WORK}/first)
  run(${CMAKE_COMMAND} -DBUILD=${WORK}/installed -P ${SOURCE}/cmake/Uninstall.cmake)
  file(GLOB_RECURSE left ${WORK}/first/*)
  file(GLOB_RECURSE folders LIST_DIRECTORIES ON ${WORK}/first/*)
  list(FILTER folders INCLUDE REGEX "[Cc]loud[Cc]ontact[^/]*$")
  if(left OR folders)
    message(FATAL_ERROR "left after uninstall: ${left} ${folders}")
  endif()
endfunction()

cmake_language(CALL step_${STEP})
