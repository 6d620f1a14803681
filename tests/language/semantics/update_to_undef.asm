// undef takes a value away
asm update_to_undef
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = x := undef
default init s0:
  function x = 1
//= step 1: x := undef
