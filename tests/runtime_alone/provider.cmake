# Refuses every package that the runtime alone has no business to seek.
macro(furrow_refuse_packages method name)
  if(NOT (${name} STREQUAL draco AND FURROW_WITH_DRACO))
    message(FATAL_ERROR "the runtime alone sought ${name}")
  endif()
endmacro()
cmake_language(SET_DEPENDENCY_PROVIDER furrow_refuse_packages SUPPORTED_METHODS FIND_PACKAGE)
