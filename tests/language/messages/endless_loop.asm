asm endless_loop
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = while n >= 0 do n := n + 1  //~ R011
default init s0:
  function n = 0
