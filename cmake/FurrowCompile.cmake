# furrow_compile(target): the flags every furrow target is built with.
#
# -ffp-contract=off: pose, edge and ring arithmetic keeps one fixed expression order in every tier (docs/architecture.md), so that the
# compiler may not fuse a multiply and an add. No math errno, no trapping math: loops with sqrt and selects vectorise, to the same bits.
function(furrow_compile target)
  if(MSVC)
    target_compile_options(${target} PRIVATE /W4 /WX /fp:precise)
  else()
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Werror
                                             -ffp-contract=off -fno-math-errno -fno-trapping-math)
  endif()
  if(FURROW_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=address,undefined -fno-sanitize-recover=undefined
                                            -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
  endif()
endfunction()
