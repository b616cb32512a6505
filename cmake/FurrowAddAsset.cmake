# furrow_add_asset(TARGET name SOURCE file [RECIPE file] [OUTPUT file] [OPTIONS option...] [DEPENDS file-or-target...])
#
# Cooks an asset in the build of a target, and again whenever a file is newer that the cook read: source, recipe, every image that the recipe
# names, buffers of a glTF; or the tool itself. Works with Ninja and Makefiles, Visual Studio and Xcode.
#
#   TARGET   the target that needs the asset, of the same folder; one that is not there becomes a custom target of `all`. May be given several times.
#   SOURCE   what to cook, relative to the source folder
#   RECIPE   relative to the source folder; without one the cook works out everything itself
#   OUTPUT   relative to the binary folder; default: the name of SOURCE with the extension .furrow
#   OPTIONS  more options of `furrow cook`, such as --geometry raw or --cache DIR
#   DEPENDS  what must be made first: inputs that the build generates
#
# The tool is furrow::tool; where that cannot run (cross-compiling), set FURROW_TOOL to one that can.
cmake_policy(VERSION 3.24)

function(furrow_add_asset)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "TARGET;SOURCE;RECIPE;OUTPUT" "OPTIONS;DEPENDS")
  foreach(needed TARGET SOURCE)
    if(NOT arg_${needed})
      message(FATAL_ERROR "furrow_add_asset: ${needed} is missing")
    endif()
  endforeach()
  if(arg_UNPARSED_ARGUMENTS OR arg_KEYWORDS_MISSING_VALUES)
    message(FATAL_ERROR "furrow_add_asset: not understood: ${arg_UNPARSED_ARGUMENTS} ${arg_KEYWORDS_MISSING_VALUES}")
  endif()

  get_filename_component(source ${arg_SOURCE} ABSOLUTE)
  if(NOT arg_OUTPUT)
    get_filename_component(arg_OUTPUT ${source} NAME_WLE)
    string(APPEND arg_OUTPUT .furrow)
  endif()
  get_filename_component(output ${arg_OUTPUT} ABSOLUTE BASE_DIR ${CMAKE_CURRENT_BINARY_DIR})
  get_filename_component(folder ${output} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
  set(recipe)
  set(recipe_option)
  if(arg_RECIPE)
    get_filename_component(recipe ${arg_RECIPE} ABSOLUTE)
    set(recipe_option --recipe ${recipe})
  endif()
  set(tool furrow::tool)
  if(FURROW_TOOL)
    set(tool ${FURROW_TOOL})
  endif()

  add_custom_command(
    OUTPUT ${output}
    COMMAND ${tool} cook ${source} ${recipe_option} -o ${output} --depfile ${output}.d --quiet ${arg_OPTIONS}
    DEPENDS ${tool} ${source} ${recipe} ${arg_DEPENDS}
    DEPFILE ${output}.d
    COMMENT "Cooking ${arg_OUTPUT}"
    VERBATIM)
  if(NOT TARGET ${arg_TARGET})
    add_custom_target(${arg_TARGET} ALL)
  endif()
  target_sources(${arg_TARGET} PRIVATE ${output})
endfunction()
