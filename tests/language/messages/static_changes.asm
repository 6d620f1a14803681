// what depends on the state is derived
asm static_changes
import StandardLibrary
signature:
  controlled speed: Integer
  static fast: Boolean //~ W006
definitions:
  function fast = speed > 5
  main rule r_Main = if fast then speed := 0 endif
default init s0:
  function speed = 0
