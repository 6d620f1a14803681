// each rule sees what the ones before it wrote
asm seq
import StandardLibrary
signature:
  controlled a: Integer
  controlled b: Integer
definitions:
  main rule r_Main = seq a := 1  b := a + 1  a := b * 10 endseq
//= step 1: a := 20, b := 2
