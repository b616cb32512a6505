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
# furrow_add_manifest(TARGET name MANIFEST file [OUTPUT_FOLDER folder] [OPTIONS option...] [DEPENDS file-or-target...])
#
# The same for every asset that a manifest lists (docs/build_step.md), each in a rule of its own.
#
#   MANIFEST       relative to the source folder; its sources and recipes are relative to itself
#   OUTPUT_FOLDER  what its outputs are relative to, itself relative to the binary folder, which is the default
#
# The tool is furrow::tool; where that cannot run (cross-compiling), set FURROW_TOOL to one that can.
cmake_policy(VERSION 3.24)

function(furrow_add_asset)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "TARGET;SOURCE;RECIPE;OUTPUT" "OPTIONS;DEPENDS")
  furrow_check_arguments(furrow_add_asset TARGET SOURCE)
  get_filename_component(source ${arg_SOURCE} ABSOLUTE)
  if(NOT arg_OUTPUT)
    get_filename_component(arg_OUTPUT ${source} NAME_WLE)
    string(APPEND arg_OUTPUT .furrow)
  endif()
  set(recipe)
  set(recipe_option)
  if(arg_RECIPE)
    get_filename_component(recipe ${arg_RECIPE} ABSOLUTE)
    set(recipe_option --recipe ${recipe})
  endif()
  furrow_cook_rule(${arg_TARGET} ${arg_OUTPUT} INPUTS ${source} ${recipe} ${arg_DEPENDS} WORDS ${source} ${recipe_option} ${arg_OPTIONS})
endfunction()

function(furrow_add_manifest)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "TARGET;MANIFEST;OUTPUT_FOLDER" "OPTIONS;DEPENDS")
  furrow_check_arguments(furrow_add_manifest TARGET MANIFEST)
  get_filename_component(manifest ${arg_MANIFEST} ABSOLUTE)
  get_filename_component(folder ${manifest} DIRECTORY)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${manifest})
  file(READ ${manifest} json)
  string(JSON count ERROR_VARIABLE fault LENGTH "${json}" assets)
  if(fault)
    message(FATAL_ERROR "furrow_add_manifest: ${manifest}: ${fault}")
  elseif(count EQUAL 0)
    return()
  endif()
  math(EXPR last "${count} - 1")
  foreach(i RANGE ${last})
    set(known source sequence fps recipe output geometry)
    foreach(key ${known})
      set(${key})
    endforeach()
    string(JSON keys LENGTH "${json}" assets ${i})
    foreach(k RANGE 1 ${keys})
      math(EXPR k "${k} - 1")
      string(JSON key MEMBER "${json}" assets ${i} ${k})
      if(NOT key IN_LIST known)
        message(FATAL_ERROR "furrow_add_manifest: ${manifest}: assets[${i}].${key}: no such key: the keys are ${known}")
      endif()
      string(JSON ${key} GET "${json}" assets ${i} ${key})
    endforeach()
    if(NOT output OR NOT (source OR sequence))
      message(FATAL_ERROR "furrow_add_manifest: ${manifest}: assets[${i}]: needs an output, and a source or a sequence")
    endif()
    set(inputs)
    set(words)
    if(source)
      get_filename_component(source ${source} ABSOLUTE BASE_DIR ${folder})
      list(APPEND inputs ${source})
      list(APPEND words ${source})
    endif()
    if(sequence)
      get_filename_component(sequence ${sequence} ABSOLUTE BASE_DIR ${folder})
      list(APPEND words --sequence ${sequence})
    endif()
    if(recipe)
      get_filename_component(recipe ${recipe} ABSOLUTE BASE_DIR ${folder})
      list(APPEND inputs ${recipe})
      list(APPEND words --recipe ${recipe})
    endif()
    if(fps)
      list(APPEND words --fps ${fps})
    endif()
    if(geometry)
      list(APPEND words --geometry ${geometry})
    endif()
    if(arg_OUTPUT_FOLDER)
      set(output ${arg_OUTPUT_FOLDER}/${output})
    endif()
    furrow_cook_rule(${arg_TARGET} ${output} INPUTS ${inputs} ${arg_DEPENDS} WORDS ${words} ${arg_OPTIONS})
  endforeach()
endfunction()

macro(furrow_check_arguments name)
  foreach(needed ${ARGN})
    if(NOT arg_${needed})
      message(FATAL_ERROR "${name}: ${needed} is missing")
    endif()
  endforeach()
  if(arg_UNPARSED_ARGUMENTS OR arg_KEYWORDS_MISSING_VALUES)
    message(FATAL_ERROR "${name}: not understood: ${arg_UNPARSED_ARGUMENTS} ${arg_KEYWORDS_MISSING_VALUES}")
  endif()
endmacro()

# furrow_cook_rule(target output INPUTS file-or-target... WORDS word...): `furrow cook WORDS -o output` in the build of the target.
function(furrow_cook_rule target name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "INPUTS;WORDS")
  get_filename_component(output ${name} ABSOLUTE BASE_DIR ${CMAKE_CURRENT_BINARY_DIR})
  get_filename_component(folder ${output} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
  set(tool furrow::tool)
  if(FURROW_TOOL)
    set(tool ${FURROW_TOOL})
  endif()
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${tool} cook ${arg_WORDS} -o ${output} --depfile ${output}.d --quiet
    DEPENDS ${tool} ${arg_INPUTS}
    DEPFILE ${output}.d
    COMMENT "Cooking ${name}"
    VERBATIM)
  if(NOT TARGET ${target})
    add_custom_target(${target} ALL)
  endif()
  target_sources(${target} PRIVATE ${output})
endfunction()
