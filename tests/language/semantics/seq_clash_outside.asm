// two sequences in a block clash by their net updates
asm seq_clash_outside
import StandardLibrary
signature:
  controlled a: Integer
definitions:
  main rule r_Main = par seq a := 1  a := 2 endseq  seq a := 2  a := 3 endseq endpar
//= step 1: R001
