# cmake -DTOOL= -DCONTENT= -DSCRATCH= -DGENERATOR= -DCOMPILER= -DLAUNCHER= -P thread_sanitizer.cmake: builds threads_test with ThreadSanitizer and runs it
# on small assets.
cmake_minimum_required(VERSION 3.24)

include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${SCRATCH})
run_well(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/thread_sanitizer -B ${SCRATCH}/build -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
         -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -DCMAKE_BUILD_TYPE=)
run_well(${CMAKE_COMMAND} --build ${SCRATCH}/build --target threads_test)
file(WRITE ${SCRATCH}/recipe.json [[{"layers": [{"name": "a", "compress": "none", "direction": {"axis": [1, 0, 0]}}]}]])
foreach(name panel sleeve)
  run_well(${TOOL} cook ${CONTENT}/${name}.glb --recipe ${SCRATCH}/recipe.json --geometry raw -o ${SCRATCH}/${name}.furrow)
endforeach()
run_well(${CMAKE_COMMAND} -E env TSAN_OPTIONS=halt_on_error=1 ${SCRATCH}/build/threads_test ${SCRATCH}/panel.furrow ${SCRATCH}/sleeve.furrow)
file(REMOVE_RECURSE ${SCRATCH})
