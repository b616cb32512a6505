# furrow_embed(target header.h namespace file...): a generated header with one `inline constexpr const char*` a text file, named k and the
# file name in UpperCamel without its extension (compress.comp -> kCompress). furrow_embed_bytes() makes `inline constexpr uint8_t NAME[]` of any files.
function(furrow_embed target header namespace)
  furrow_embed_by(embed.cmake ${target} ${header} ${namespace} ${ARGN})
endfunction()

function(furrow_embed_bytes target header namespace)
  furrow_embed_by(embed_numbers.cmake ${target} ${header} ${namespace} ${ARGN})
endfunction()

function(furrow_embed_by script target header namespace)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/generated/${header})
  set(script ${PROJECT_SOURCE_DIR}/cmake/${script})
  set(files)
  foreach(file ${ARGN})
    list(APPEND files ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  endforeach()
  add_custom_command(
    OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} "-DOUT=${out}" "-DNAMESPACE=${namespace}" "-DFILES=${files}" -P ${script}
    DEPENDS ${files} ${script}
    COMMENT "Embedding ${header}"
    VERBATIM)
  target_sources(${target} PRIVATE ${out})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/generated)
endfunction()
