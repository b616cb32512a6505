# cmake -DTOOL= -DCONTENT= -DSOURCE= -DSCRATCH= -P docs.cmake: what README.md and the artist guide tell a reader to do with the demo's
# face works, in the order of the page.
cmake_minimum_required(VERSION 3.24)

include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

cmake_path(GET TOOL PARENT_PATH bin)
foreach(page README.md docs/artist_guide.md)
  file(REMOVE_RECURSE ${SCRATCH})
  file(COPY ${CONTENT}/face.glb ${CONTENT}/face.json DESTINATION ${SCRATCH})
  file(READ ${SOURCE}/${page} text)
  if(text MATCHES "```json\n([^`]*)```")
    file(WRITE ${SCRATCH}/first.json "${CMAKE_MATCH_1}")
  endif()
  file(STRINGS ${SOURCE}/${page} commands REGEX "^    furrow [a-z]+ face[.]")
  if(NOT commands)
    message(FATAL_ERROR "${page} has no commands")
  endif()
  foreach(command ${commands})
    run_well(${CMAKE_COMMAND} -E chdir ${SCRATCH} env PATH=${bin}:$ENV{PATH} sh -c ${command})
  endforeach()
endforeach()
file(REMOVE_RECURSE ${SCRATCH})
