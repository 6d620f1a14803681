// a sequence in a block adds its net updates; its neighbours do not see it
asm seq_in_par
import StandardLibrary
signature:
  controlled a: Integer
  controlled b: Integer
definitions:
  main rule r_Main = par
    seq a := 5  a := a + 1 endseq
    b := a
  endpar
default init s0:
  function a = 0
//= step 1: a := 6, b := 0
