# What `cmake --install` puts where.

# What a static link needs beside LAPACK: what the Fortran compiler adds by itself.
set(fortran_runtime "")
foreach(name IN LISTS CMAKE_Fortran_IMPLICIT_LINK_LIBRARIES)
   if(NOT name MATCHES "^(gcc|gcc_s|c|m)$|/" AND NOT "-l${name}" IN_LIST fortran_runtime)
      list(APPEND fortran_runtime -l${name})
   endif()
endforeach()
list(JOIN fortran_runtime " " fortran_runtime)

# Libraries, not the flag of the compiler, by which what is compiled in the same command would be for threads too.
set(openmp_flags "")
set(openmp_static_flags "")
if(NUTATE_OPENMP)
   list(TRANSFORM OpenMP_Fortran_LIB_NAMES PREPEND " -l" OUTPUT_VARIABLE openmp_flags)
   list(JOIN openmp_flags "" openmp_flags)
   # The runtime of gfortran calls these if there are threads, but does not ask for them: an archive would leave them out.
   set(openmp_static_flags "${openmp_flags} -Wl,-u,pthread_mutex_destroy -Wl,-u,pthread_cond_destroy")
endif()
# From the folder of the files of pkg-config up to the prefix: lib/ may have a folder of its own for the processor.
file(RELATIVE_PATH pc_to_prefix "/prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/prefix")
string(REGEX REPLACE "/$" "" pc_to_prefix "${pc_to_prefix}")
configure_file(cmake/nutate.pc.in nutate.pc @ONLY)
configure_file(cmake/nutate-fortran.pc.in nutate-fortran.pc @ONLY)
configure_file(cmake/nutate-static.pc.in nutate-static.pc @ONLY)
configure_package_config_file(cmake/nutate-config.cmake.in nutate-config.cmake
   INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/nutate)
write_basic_package_version_file(nutate-config-version.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS nutate EXPORT nutate_targets)
install(TARGETS nutate_static EXPORT nutate_fortran_targets)
install(TARGETS nutate_program)
file(GLOB headers CONFIGURE_DEPENDS include/*.h)
install(FILES ${headers} TYPE INCLUDE)
install(DIRECTORY ${module_folder}/ DESTINATION ${module_install_folder} FILES_MATCHING PATTERN "*.mod")
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/nutate.pc ${CMAKE_CURRENT_BINARY_DIR}/nutate-fortran.pc
   ${CMAKE_CURRENT_BINARY_DIR}/nutate-static.pc
   DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(EXPORT nutate_targets NAMESPACE nutate:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/nutate)
install(EXPORT nutate_fortran_targets NAMESPACE nutate:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/nutate)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/nutate-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/nutate-config-version.cmake
   DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/nutate)

# The Python package beside the library, knowing where that is.
set(python_folder ${CMAKE_INSTALL_DATADIR}/nutate/python)
install(FILES python/pyproject.toml python/README.md DESTINATION ${python_folder})
install(DIRECTORY python/examples DESTINATION ${python_folder} FILES_MATCHING PATTERN "*.py")
install(DIRECTORY python/nutate DESTINATION ${python_folder} FILES_MATCHING PATTERN "*.py" PATTERN "*.js" PATTERN "py.typed" PATTERN __pycache__ EXCLUDE)
install(CODE "file(WRITE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${python_folder}/nutate/_location.py\"
   \"LIBRARY = r'''\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/libnutate.so.${PROJECT_VERSION_MAJOR}'''\\n\")
   list(APPEND CMAKE_INSTALL_MANIFEST_FILES \"\${CMAKE_INSTALL_PREFIX}/${python_folder}/nutate/_location.py\")")

install(FILES README.md CHANGELOG.md LICENSE CITATION.cff TYPE DOC)
install(DIRECTORY docs example TYPE DOC PATTERN conf.py EXCLUDE PATTERN _static EXCLUDE)
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/nutate)
