// no case and no otherwise: nothing
asm switch_without_match
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = switch n case 1: n := 2 endswitch
default init s0:
  function n = 0
//= step 1: nothing
