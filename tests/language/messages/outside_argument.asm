// a function over a subset has no location outside of it to write; to read one gives undef
asm outside_argument
import StandardLibrary
signature:
  domain Seat subsetof Integer
  controlled taken: Prod(Seat, Integer) -> Boolean
  controlled next: Integer
definitions:
  domain Seat = {1 : 2}
  main rule r_Main = if isUndef(taken(next, 7)) then
    par
      taken(next, 7) := true  //~ R023
      next := next + 1
    endpar
  endif
default init s0:
  function next = 1
