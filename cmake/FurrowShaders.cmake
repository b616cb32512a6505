# furrow_shader(NAME part...): puts the texts of a shader together: shaders/NAME in the build tree, an `inline constexpr` k and the name in
# UpperCamel in shader_text.h, and for compute shaders the same in HLSL and, where glslangValidator is found, SPIR-V. Collect with
# furrow_embed_shaders(target). The parts are named without the prelude of their language.
find_program(FURROW_GLSLANG glslangValidator)
find_program(FURROW_SPIRV_VAL spirv-val)
set(furrow_shader_dir ${CMAKE_CURRENT_BINARY_DIR}/shaders)

function(furrow_join out)
  set(parts)
  foreach(part ${ARGN})
    if(part MATCHES "\\.(h|glsl|hlsl|comp)$")
      set(part ${CMAKE_CURRENT_SOURCE_DIR}/shaders/${part})
      list(APPEND files ${part})
    endif()
    list(APPEND parts ${part})
  endforeach()
  add_custom_command(OUTPUT ${out} COMMAND ${CMAKE_COMMAND} "-DOUT=${out}" "-DPARTS=${parts}" -P ${PROJECT_SOURCE_DIR}/cmake/join.cmake
                     DEPENDS ${files} ${PROJECT_SOURCE_DIR}/cmake/join.cmake VERBATIM)
endfunction()

macro(furrow_raster_shader name)
  furrow_join(${furrow_shader_dir}/${name}.glsl "#version 330 core" "#extension GL_ARB_gpu_shader5 : enable" layout.h prelude_raster.glsl
              ${ARGN})
  list(APPEND furrow_shader_texts ${furrow_shader_dir}/${name}.glsl)
endmacro()

macro(furrow_compute_shader name)
  set(spirv ${furrow_shader_dir}/${name}.spv)
  furrow_join(${furrow_shader_dir}/${name}.comp "#version 430" layout.h prelude.glsl ${ARGN})
  furrow_join(${furrow_shader_dir}/${name}_hlsl.comp prelude.hlsl layout.h ${ARGN})
  list(APPEND furrow_shader_texts ${furrow_shader_dir}/${name}.comp ${furrow_shader_dir}/${name}_hlsl.comp)
  if(FURROW_GLSLANG AND FURROW_SPIRV_VAL)
    add_custom_command(OUTPUT ${spirv} COMMAND ${FURROW_GLSLANG} -V --quiet -S comp -o ${spirv} ${furrow_shader_dir}/${name}.comp
                       COMMAND ${FURROW_SPIRV_VAL} --target-env vulkan1.0 ${spirv} DEPENDS ${furrow_shader_dir}/${name}.comp VERBATIM)
    list(APPEND furrow_spirv ${spirv})
  endif()
endmacro()

function(furrow_embed_shaders target)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/generated)
  set(scripts ${PROJECT_SOURCE_DIR}/cmake/embed.cmake ${PROJECT_SOURCE_DIR}/cmake/embed_numbers.cmake)
  add_custom_command(OUTPUT ${out}/shader_text.h
                     COMMAND ${CMAKE_COMMAND} "-DOUT=${out}/shader_text.h" "-DNAMESPACE=furrow::shader_text" "-DFILES=${furrow_shader_texts}"
                             -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
                     DEPENDS ${furrow_shader_texts} ${scripts} VERBATIM)
  add_custom_command(OUTPUT ${out}/shader_spirv.h
                     COMMAND ${CMAKE_COMMAND} "-DOUT=${out}/shader_spirv.h" "-DNAMESPACE=furrow::shader_spirv" "-DFILES=${furrow_spirv}" -DWORDS=ON
                             -P ${PROJECT_SOURCE_DIR}/cmake/embed_numbers.cmake
                     DEPENDS ${furrow_spirv} ${scripts} VERBATIM)
  target_sources(${target} PRIVATE ${out}/shader_text.h ${out}/shader_spirv.h)
  target_include_directories(${target} PRIVATE ${out})
endfunction()
