// a clash within one rule of a sequence is a clash
asm seq_clash_inside
import StandardLibrary
signature:
  controlled a: Integer
definitions:
  main rule r_Main = seq par a := 1  a := 2 endpar  a := 3 endseq
//= step 1: R001
