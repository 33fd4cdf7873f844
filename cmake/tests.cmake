# What `make test` runs: the unit tests, linked with the static library, and with the test-drive that fpm has fetched.
file(GLOB test_drive_sources CONFIGURE_DEPENDS build/dependencies/test-drive/src/*.[fF]90)
file(GLOB unit_sources CONFIGURE_DEPENDS test/*.f90 test/*.c)
set(unit_folder ${CMAKE_CURRENT_BINARY_DIR}/unit_modules)
add_executable(unit EXCLUDE_FROM_ALL ${unit_sources} ${test_drive_sources})
target_link_libraries(unit PRIVATE nutate_static)
target_include_directories(unit PRIVATE include ${unit_folder})
set_target_properties(unit PROPERTIES Fortran_MODULE_DIRECTORY ${unit_folder} LINKER_LANGUAGE Fortran)
# Tests compute little, and would take several times as long to compile if they were optimised.
list(FILTER unit_sources INCLUDE REGEX "\\.f90$")
if(flags MATCHES "-O[23]" AND NOT flags MATCHES "-fcheck")
   set_source_files_properties(${unit_sources} ${test_drive_sources} PROPERTIES COMPILE_OPTIONS -O0)
endif()

# The programs of example/, which the tests of the command line run.
add_custom_target(examples)
file(GLOB example_sources CONFIGURE_DEPENDS example/*.f90)
foreach(source ${example_sources})
   cmake_path(GET source STEM name)
   add_executable(${name} EXCLUDE_FROM_ALL ${source})
   target_link_libraries(${name} PRIVATE nutate_static)
   set_target_properties(${name} PROPERTIES LINKER_LANGUAGE Fortran RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/example
      Fortran_MODULE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/example/modules)
   add_dependencies(examples ${name})
endforeach()
