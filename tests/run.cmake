# For test scripts.

# Runs a command; its exit status and output are left in `status` and `said`.
function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE out ERROR_VARIABLE out RESULT_VARIABLE result)
  set(status ${result} PARENT_SCOPE)
  set(said "${out}" PARENT_SCOPE)
endfunction()

function(run_well)
  run(${ARGN})
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "status ${status}: ${ARGN}\n${said}")
  endif()
  set(said "${said}" PARENT_SCOPE)
endfunction()
