# cmake -DTOOL= -DSOURCE= -DSCRATCH= -DGENERATOR= -DCOMPILER= -DLAUNCHER= -P runtime_alone.cmake: builds a game with the runtime alone, with and without
# Draco, where no other package can be found, and loads assets in it.

cmake_minimum_required(VERSION 3.24)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${SCRATCH})
file(WRITE ${SCRATCH}/recipe.json [[{"layers": [{"name": "a", "compress": "none"}]}]])
foreach(geometry raw draco)
  run_well(${TOOL} cook ${SOURCE} --recipe ${SCRATCH}/recipe.json --geometry ${geometry} -o ${SCRATCH}/${geometry}.furrow)
endforeach()

set(here ${CMAKE_CURRENT_LIST_DIR}/runtime_alone)
foreach(draco ON OFF)
  run_well(${CMAKE_COMMAND} -S ${here} -B ${SCRATCH}/build -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
           -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -DCMAKE_BUILD_TYPE=Release -DFURROW_WITH_DRACO=${draco}
           -DCMAKE_PROJECT_TOP_LEVEL_INCLUDES=${here}/provider.cmake)
  run_well(${CMAKE_COMMAND} --build ${SCRATCH}/build)
  run_well(${SCRATCH}/build/game ${SCRATCH}/raw.furrow)
  if(draco)
    run_well(${SCRATCH}/build/game ${SCRATCH}/draco.furrow)
  else()
    run(${SCRATCH}/build/game ${SCRATCH}/draco.furrow)
    if(NOT status EQUAL 1 OR NOT said MATCHES "Draco")
      message(FATAL_ERROR "a runtime without Draco should refuse a Draco asset by name, but status ${status}: ${said}")
    endif()
  endif()
endforeach()
file(REMOVE_RECURSE ${SCRATCH})
