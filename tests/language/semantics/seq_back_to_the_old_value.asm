// what a sequence wrote stays in the update set, even if it changes nothing
asm seq_back_to_the_old_value
import StandardLibrary
signature:
  controlled a: Integer
definitions:
  main rule r_Main = seq a := 5  a := 0 endseq
default init s0:
  function a = 0
//= step 1: a := 0
