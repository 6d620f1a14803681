// rules write it and may read it
asm out
import StandardLibrary
signature:
  out o: Integer
definitions:
  main rule r_Main = o := o + 1
default init s0:
  function o = 0
//= step 1: o := 1
//= step 2: o := 2
