// a term passed to a macro is read where it stands: again after each rule of a sequence
asm macro_in_seq
import StandardLibrary
signature:
  controlled a: Integer
  controlled x: Integer
  controlled y: Integer
definitions:
  rule r_read($n in Integer) = seq x := $n  a := 10  y := $n endseq
  main rule r_Main = r_read[a + 1]
default init s0:
  function a = 1
//= step 1: a := 10, x := 2, y := 11
