// also within a longer term, and from macro to macro
asm macro_in_seq_passed_on
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
definitions:
  rule r_read($t in Integer) = seq x := 10  y := $t endseq
  rule r_more($t in Integer) = r_read[$t + 1]
  main rule r_Main = r_more[x]
default init s0:
  function x = 1
//= step 1: x := 10, y := 11
