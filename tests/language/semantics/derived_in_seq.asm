// also within a sequence
asm derived_in_seq
import StandardLibrary
signature:
  controlled n: Integer
  derived twice: Integer
  controlled x: Integer
definitions:
  function twice = 2 * n
  main rule r_Main = seq n := 5  x := twice endseq
default init s0:
  function n = 1
//= step 1: n := 5, x := 10
